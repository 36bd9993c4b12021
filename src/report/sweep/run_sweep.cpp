#include "report/sweep/run_sweep.hpp"

#include <algorithm>
#include <map>
#include <mutex>

#include "core/in_order.hpp"
#include "core/parallel.hpp"

namespace qerr {

namespace {

constexpr std::size_t named_faults = 3, most_faults = 1000;

/// Faults, each with the first variant that has it, whatever the order in which threads meet them.
class Failures {
 public:
  explicit Failures(const SweepGrid& grid) : grid_(grid) {}

  void add(const SweptVariant& v) {
    const std::lock_guard lock(mutex_);
    ++count_;
    const auto known = first_.find(v.fault);
    if (known != first_.end())
      known->second = std::min(known->second, v.variant);
    else if (first_.size() < most_faults)
      first_.emplace(v.fault, v.variant);
  }

  FailedVariants all() const {
    FailedVariants all{count_, {}};
    std::map<std::uint64_t, std::string> by_variant;
    for (const auto& [fault, variant] : first_) by_variant.emplace(variant, fault);
    for (const auto& [variant, fault] : by_variant)
      if (all.first.size() < named_faults)
        all.first.push_back("variant " + std::to_string(variant) + " (" + grid_.description(variant) +
                            "): " + fault);
    return all;
  }

 private:
  const SweepGrid& grid_;
  std::mutex mutex_;
  std::uint64_t count_ = 0;
  std::map<std::string, std::uint64_t> first_;
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
          if (!v.fault.empty()) failures.add(v);
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
