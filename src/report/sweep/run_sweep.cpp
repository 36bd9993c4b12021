#include "report/sweep/run_sweep.hpp"

#include <algorithm>
#include <map>
#include <mutex>

#include "core/in_order.hpp"
#include "core/parallel.hpp"

namespace qerr {

namespace {

constexpr std::size_t named_failures = 5;

/// Faults by variant, of which the first ones are kept, whatever the order in which threads meet them.
class Failures {
 public:
  explicit Failures(const SweepGrid& grid) : grid_(grid) {}

  void add(const SweptVariant& v) {
    const std::lock_guard lock(mutex_);
    ++count_;
    first_[v.variant] = v.fault;
    if (first_.size() > named_failures) first_.erase(std::prev(first_.end()));
  }

  FailedVariants all() const {
    FailedVariants all{count_, {}};
    for (const auto& [variant, fault] : first_)
      all.first.push_back("variant " + std::to_string(variant) + " (" + grid_.description(variant) +
                          "): " + fault);
    return all;
  }

 private:
  const SweepGrid& grid_;
  std::mutex mutex_;
  std::uint64_t count_ = 0;
  std::map<std::uint64_t, std::string> first_;
};

}  // namespace

FailedVariants run_sweep(const SweepJob& job, std::uint64_t begin,
                         const std::function<void(const std::string&)>& write,
                         const std::function<void(std::uint64_t, std::uint64_t)>& progress) {
  const std::uint64_t total = job.size(), count = total > begin ? total - begin : 0;
  const unsigned threads = thread_count(job.threads);
  Failures failures(job.grid);
  WorkspaceOptions options;
  // The last of few variants have a thread each, at most.
  options.threads =
      static_cast<unsigned>(std::max<std::uint64_t>(1, threads / std::max<std::uint64_t>(1, count)));
  texts_in_order(
      count, threads,
      [&](std::uint64_t i) {
        const SweptVariant v =
            evaluate_variant(job.variants, job.grid, job.shard.variant(begin + i), job.judged, options);
        if (!v.check) failures.add(v);
        return job.text(v);
      },
      [&](std::uint64_t i, const std::string& text) {
        write(text);
        if (progress) progress(begin + i + 1, total);
      });
  return failures.all();
}

std::string text_of(const SweepJob& job, std::uint64_t index) {
  WorkspaceOptions options;
  options.threads = job.threads;
  return job.text(evaluate_variant(job.variants, job.grid, job.shard.variant(index), job.judged, options));
}

}  // namespace qerr
