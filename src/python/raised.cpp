#include "python/raised.h"

#include <chrono>
#include <condition_variable>
#include <mutex>
#include <thread>

namespace py = pybind11;

namespace tress::python {
namespace {

/// The longest time until a signal is noticed.
constexpr std::chrono::milliseconds look_interval{50};

PyObject* error_type = nullptr;

void set_error(const Error& error) {
  const py::object raised = py::reinterpret_borrow<py::object>(error_type)(error.message());
  raised.attr("file") = error.file;
  raised.attr("place") = error.place;
  raised.attr("expected") = error.expected;
  raised.attr("found") = error.found;
  PyErr_SetObject(error_type, raised.ptr());
}

}  // namespace

void bind_error(py::module_& module) {
  error_type = PyErr_NewExceptionWithDoc("tress.Error",
                                         "What tress refuses: the text names the file, the place in it, what was "
                                         "expected and what was found.",
                                         nullptr, nullptr);
  const py::object type = py::reinterpret_borrow<py::object>(error_type);
  for (const char* part : {"file", "place", "expected", "found"}) type.attr(part) = "";
  module.attr("Error") = type;
  py::register_exception_translator([](std::exception_ptr thrown) {
    try {
      if (thrown) std::rethrow_exception(thrown);
    } catch (const Raised& raised) {
      set_error(raised.error);
    }
  });
}

struct Worker::Shared {
  std::mutex mutex;
  std::condition_variable changed;
  const std::function<bool()>* question = nullptr;
  bool answer = false, is_done = false;
};

bool Worker::ask(const std::function<bool()>& question) {
  std::unique_lock lock(shared_->mutex);
  shared_->question = &question;
  shared_->changed.notify_all();
  shared_->changed.wait(lock, [&] { return shared_->question == nullptr; });
  return shared_->answer;
}

void Worker::run(const std::function<void()>& work) {
  Shared shared;
  shared_ = &shared;
  std::exception_ptr of_python, of_work;
  std::thread thread([&] {
    try {
      work();
    } catch (...) {
      of_work = std::current_exception();
    }
    const std::lock_guard lock(shared.mutex);
    shared.is_done = true;
    shared.changed.notify_all();
  });
  const auto attempt = [&](const auto& call) {
    try {
      return call();
    } catch (...) {
      if (!of_python) of_python = std::current_exception();
      stop_ = true;
      return false;
    }
  };
  while (true) {
    const std::function<bool()>* question = nullptr;
    bool is_done = false;
    {
      const py::gil_scoped_release released;
      std::unique_lock lock(shared.mutex);
      shared.changed.wait_for(lock, look_interval, [&] { return shared.is_done || shared.question != nullptr; });
      question = shared.question;
      is_done = shared.is_done;
    }
    attempt([] {
      if (PyErr_CheckSignals() != 0) throw py::error_already_set();
      return true;
    });
    if (question != nullptr) {
      const bool answer = !stop_ && attempt(*question);
      const std::lock_guard lock(shared.mutex);
      shared.question = nullptr;
      shared.answer = answer;
      shared.changed.notify_all();
    }
    if (is_done) break;
  }
  thread.join();
  shared_ = nullptr;
  if (of_python) std::rethrow_exception(of_python);
  if (of_work) std::rethrow_exception(of_work);
}

}  // namespace tress::python
