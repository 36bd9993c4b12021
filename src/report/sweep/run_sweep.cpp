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

SweepRun::SweepRun(SweepJob job)
    : job_(std::move(job)), engine_(job_.variants, job_.grid, job_.judged, job_.statistics, job_.threads) {}

FailedVariants SweepRun::run(std::uint64_t begin, const std::function<void(const std::string&)>& write,
                             const std::function<void(std::uint64_t, std::uint64_t)>& progress) const {
  const std::uint64_t total = job_.size(), count = total > begin ? total - begin : 0;
  const std::uint64_t threads = thread_count(job_.threads);
  // The variants of a batch are spread over all threads where they are few.
  const std::uint64_t batch = std::clamp<std::uint64_t>(count / threads, 1, engine_.batch());
  const std::uint64_t batches = (count + batch - 1) / batch;
  Failures failures(job_.grid);
  const auto inner_threads = static_cast<unsigned>(threads / std::clamp<std::uint64_t>(batches, 1, threads));
  texts_in_order(
      batches, static_cast<unsigned>(threads),
      [&](std::uint64_t i) {
        std::vector<std::uint64_t> variants;
        for (std::uint64_t v = i * batch; v < std::min(count, (i + 1) * batch); ++v)
          variants.push_back(job_.shard.variant(begin + v));
        std::string text;
        for (const SweptVariant& v : engine_.evaluate(variants, inner_threads)) {
          if (!v.check) failures.add(v);
          text += job_.text(v);
        }
        return text;
      },
      [&](std::uint64_t i, const std::string& text) {
        write(text);
        if (progress) progress(std::min(total, begin + (i + 1) * batch), total);
      });
  return failures.all();
}

std::string SweepRun::text(std::uint64_t index) const {
  const std::uint64_t variant = job_.shard.variant(index);
  return job_.text(engine_.evaluate({&variant, 1}, job_.threads).front());
}

}  // namespace qerr
