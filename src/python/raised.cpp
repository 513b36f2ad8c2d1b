#include "python/raised.h"

#include <array>
#include <cerrno>
#include <chrono>
#include <condition_variable>
#include <cstring>
#include <mutex>
#include <string>
#include <thread>

namespace py = pybind11;

namespace tress::python {
namespace {

/// The longest time until a signal is noticed.
constexpr std::chrono::milliseconds look_interval{50};

PyObject* error_type = nullptr;

/// The kinds of errors: InvalidValue and so on, in the order of Raised::Kind, then of files.
struct Types {
  std::array<PyObject*, 3> of_kind{};
  PyObject* file_missing = nullptr;
  PyObject* file_failed = nullptr;
} types;

/// The errno whose text this is, in the system's words or those of our readers; 0: none.
int system_code(const std::string& found) {
  constexpr int most = 133;
  if (found == "no such file") return ENOENT;
  if (found == "a directory" || found == "a folder or a device") return EISDIR;
  for (int code = 1; code <= most; ++code)
    if (found == std::strerror(code)) return code;
  return 0;
}

void set_error(const Raised& raised) {
  const Error& error = raised.error;
  const int code = error.file.empty() ? 0 : system_code(error.found);
  PyObject* type = code == ENOENT ? types.file_missing
                   : code != 0    ? types.file_failed
                                  : types.of_kind[static_cast<std::size_t>(raised.kind)];
  const py::object made = py::reinterpret_borrow<py::object>(type)(error.message());
  made.attr("file") = error.file;
  made.attr("place") = error.place;
  made.attr("expected") = error.expected;
  made.attr("found") = error.found;
  if (code != 0) {
    made.attr("errno") = code;
    made.attr("strerror") = error.found;
    made.attr("filename") = error.file;
  }
  PyErr_SetObject(type, made.ptr());
}

/// Makes a kind of tress.Error that is one of Python's as well, whose text stays that of tress.
PyObject* make_kind(py::module_& module, const char* name, PyObject* of_python, const char* text) {
  py::dict members;
  members["__str__"] = py::reinterpret_borrow<py::object>(PyExc_Exception).attr("__str__");
  members["__module__"] = "tress";
  const py::tuple bases =
      py::make_tuple(py::reinterpret_borrow<py::object>(error_type), py::reinterpret_borrow<py::object>(of_python));
  PyObject* made = PyErr_NewExceptionWithDoc((std::string("tress.") + name).c_str(), text, bases.ptr(), members.ptr());
  module.attr(name) = py::reinterpret_borrow<py::object>(made);
  return made;
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
  types = {{make_kind(module, "InvalidValue", PyExc_ValueError, "A value, or the content of a file, that is refused."),
            make_kind(module, "InvalidIndex", PyExc_IndexError, "A slice, node or part that does not exist."),
            make_kind(module, "InvalidCall", PyExc_RuntimeError, "A call at a wrong time.")},
           make_kind(module, "FileMissing", PyExc_FileNotFoundError, "A file or folder that does not exist."),
           make_kind(module, "FileFailed", PyExc_OSError, "A file that cannot be read or written.")};
  py::register_exception_translator([](std::exception_ptr thrown) {
    try {
      if (thrown) std::rethrow_exception(thrown);
    } catch (const Raised& raised) {
      set_error(raised);
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
