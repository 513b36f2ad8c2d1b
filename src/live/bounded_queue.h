// Threads that answer connections, with a limit on the number of waiting connections.
#pragma once

#include <httplib.h>

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <deque>
#include <functional>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

namespace tress::live {

/// If the queue is full, the thread that accepts connections waits: further ones stay in the system's own short queue
/// and take no file descriptor of this program.
class BoundedQueue final : public httplib::TaskQueue {
 public:
  using Task = std::function<void()>;
  using Enqueued = decltype(std::declval<httplib::TaskQueue&>().enqueue(Task()));  // void or bool, by version

  /// closing: once it is set, no thread waits for room, and the server closes new connections at once. It must outlive
  /// the queue.
  BoundedQueue(std::size_t threads, std::size_t room, const std::atomic<bool>& closing)
      : room_(room), closing_(closing) {
    for (std::size_t i = 0; i < threads; ++i) threads_.emplace_back([this] { work(); });
  }

  Enqueued enqueue(Task task) override {
    std::unique_lock lock(mutex_);
    while (tasks_.size() >= room_ && !closing_) changed_.wait_for(lock, std::chrono::milliseconds(50));
    tasks_.push_back(std::move(task));
    lock.unlock();
    changed_.notify_all();
    return Enqueued(true);
  }

  void shutdown() override {
    {
      const std::scoped_lock lock(mutex_);
      is_over_ = true;
    }
    changed_.notify_all();
    for (std::thread& thread : threads_) thread.join();
    threads_.clear();
  }

 private:
  void work() {
    for (;;) {
      std::unique_lock lock(mutex_);
      changed_.wait(lock, [&] { return !tasks_.empty() || is_over_; });
      if (tasks_.empty()) return;
      const Task task = std::move(tasks_.front());
      tasks_.pop_front();
      lock.unlock();
      changed_.notify_all();
      task();
    }
  }

  std::size_t room_;
  const std::atomic<bool>& closing_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<Task> tasks_;
  bool is_over_ = false;
  std::vector<std::thread> threads_;
};

}  // namespace tress::live
