#include "core/parallel.hpp"

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <exception>
#include <map>
#include <mutex>
#include <new>
#include <optional>
#include <system_error>
#include <thread>
#include <vector>

namespace qerr {

namespace {

std::atomic<bool> refused{false};

constexpr std::uint64_t held_per_thread = 8;

class OrderedTexts {
 public:
  OrderedTexts(std::uint64_t count, unsigned threads, const std::function<std::string(std::uint64_t)>& make,
               const std::function<void(std::uint64_t, std::string)>& pass)
      : count_(count), most_held_(held_per_thread * threads), make_(make), pass_(pass) {}

  void work() {
    try {
      make_texts();
    } catch (...) {  // without memory for the result: the others must not wait for it
      const std::lock_guard lock(mutex_);
      failure_ = std::current_exception();
      changed_.notify_all();
    }
  }

  void rethrow() const {
    if (failure_) std::rethrow_exception(failure_);
  }

 private:
  struct Made {
    std::string text;
    std::exception_ptr failure;
  };

  void make_texts() {
    while (const auto i = next()) {
      std::string text;
      std::exception_ptr failure;
      try {
        text = make_(*i);
      } catch (...) {
        failure = std::current_exception();
      }
      add(*i, {std::move(text), failure});
    }
  }

  std::optional<std::uint64_t> next() {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return failure_ || next_ >= count_ || next_ < passed_ + most_held_; });
    if (failure_ || next_ >= count_) return std::nullopt;
    return next_++;
  }

  /// Passes on what is next in the order, unless another thread is doing so and will find it.
  void add(std::uint64_t i, Made made) {
    std::unique_lock lock(mutex_);
    made_.emplace(i, std::move(made));
    if (passing_) return;
    passing_ = true;
    while (!failure_ && !made_.empty() && made_.begin()->first == passed_) {
      Made first = std::move(made_.begin()->second);
      made_.erase(made_.begin());
      lock.unlock();
      if (!first.failure) try {
          pass_(passed_, std::move(first.text));
        } catch (...) {
          first.failure = std::current_exception();
        }
      lock.lock();
      failure_ = first.failure;
      ++passed_;
      changed_.notify_all();
    }
    passing_ = false;
  }

  const std::uint64_t count_, most_held_;
  const std::function<std::string(std::uint64_t)>& make_;
  const std::function<void(std::uint64_t, std::string)>& pass_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::map<std::uint64_t, Made> made_;
  std::uint64_t next_ = 0, passed_ = 0;
  bool passing_ = false;
  std::exception_ptr failure_;
};

}  // namespace

bool threads_refused() { return refused; }

unsigned thread_count(unsigned requested) {
  return requested > 0 ? requested : std::max(1u, std::thread::hardware_concurrency());
}

void parallel_for(std::size_t count, unsigned threads, const std::function<void(std::size_t)>& task) {
  const std::size_t workers = std::min<std::size_t>(thread_count(threads), count);
  std::atomic<std::size_t> next{0};
  std::exception_ptr failure;
  std::mutex failure_mutex;
  const auto work = [&] {
    try {
      for (std::size_t i = next++; i < count; i = next++) task(i);
    } catch (...) {
      next = count;
      const std::lock_guard lock(failure_mutex);
      if (!failure) failure = std::current_exception();
    }
  };
  std::vector<std::jthread> pool;
  try {
    for (std::size_t k = 1; k < workers; ++k) pool.emplace_back(work);
  } catch (const std::system_error&) {
    refused = true;
  } catch (const std::bad_alloc&) {
    refused = true;
  }
  work();
  pool.clear();
  if (failure) std::rethrow_exception(failure);
}

void texts_in_order(std::uint64_t count, unsigned threads,
                    const std::function<std::string(std::uint64_t)>& make,
                    const std::function<void(std::uint64_t, std::string)>& pass) {
  const auto workers = static_cast<unsigned>(std::min<std::uint64_t>(thread_count(threads), count));
  OrderedTexts texts(count, workers, make, pass);
  // Where the system permits fewer threads, the first ones do the work of the others.
  parallel_for(workers, workers, [&](std::size_t) { texts.work(); });
  texts.rethrow();
}

}  // namespace qerr
