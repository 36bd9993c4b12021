#include "report/sweep/run_sweep.hpp"

#include <algorithm>
#include <map>
#include <mutex>

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
    const auto known = first_.find(v.fault);
    if (known != first_.end())
      known->second = std::min(known->second, v.variant);
    else if (first_.size() < most_faults)
      first_.emplace(v.fault, v.variant);
  }

  std::vector<std::string> some() const {
    std::vector<std::string> some;
    std::map<std::uint64_t, std::string> by_variant;
    for (const auto& [fault, variant] : first_) by_variant.emplace(variant, fault);
    for (const auto& [variant, fault] : by_variant)
      if (some.size() < named_faults)
        some.push_back("variant " + std::to_string(variant) + " (" + grid_.description(variant) +
                       "): " + fault);
    return some;
  }

 private:
  const SweepGrid& grid_;
  std::mutex mutex_;
  std::map<std::string, std::uint64_t> first_;
};

constexpr char end_of_verdicts = ' ';  // between those of a batch and its text

}  // namespace

char verdict_of(const SweptVariant& v, bool judged) {
  if (!v.fault.empty()) return 'e';
  if (!judged) return 'u';
  return v.check->all_met() ? 'y' : 'n';
}

bool count_verdict(SweepCounts& counts, char verdict) {
  ++counts.variants;
  counts.failed += verdict == 'e';
  counts.unmet += verdict == 'n';
  counts.unjudged += verdict == 'u';
  return std::string_view("enuy").find(verdict) != std::string_view::npos;
}

SweepRun::SweepRun(SweepJob job)
    : job_(std::move(job)), engine_(job_.variants, job_.grid, job_.judged, job_.statistics, job_.threads) {}

SweepOutcome SweepRun::run(const SweepCounts& before,
                           const std::function<void(const std::string&, const SweepCounts&)>& write,
                           const std::function<void(std::uint64_t, std::uint64_t)>& progress) const {
  const std::uint64_t begin = before.variants, total = job_.size(), count = total > begin ? total - begin : 0;
  const std::uint64_t threads = thread_count(job_.threads);
  // The variants of a batch are spread over all threads where they are few.
  const std::uint64_t batch = std::clamp<std::uint64_t>(count / threads, 1, engine_.batch());
  const std::uint64_t batches = (count + batch - 1) / batch;
  Failures failures(job_.grid);
  SweepOutcome outcome{before, {}};
  const auto inner_threads = static_cast<unsigned>(threads / std::clamp<std::uint64_t>(batches, 1, threads));
  texts_in_order(
      batches, static_cast<unsigned>(threads),
      [&](std::uint64_t i) {
        std::vector<std::uint64_t> variants;
        for (std::uint64_t v = i * batch; v < std::min(count, (i + 1) * batch); ++v)
          variants.push_back(job_.shard.variant(begin + v));
        std::string verdicts, text;
        for (const SweptVariant& v : engine_.evaluate(variants, inner_threads)) {
          if (!v.fault.empty()) failures.add(v);
          verdicts += verdict_of(v, job_.judged);
          text += job_.text(v);
        }
        return verdicts + end_of_verdicts + text;
      },
      [&](std::uint64_t i, const std::string& batch_text) {
        const std::size_t end = batch_text.find(end_of_verdicts);
        for (const char verdict : batch_text.substr(0, end)) count_verdict(outcome.counts, verdict);
        write(batch_text.substr(end + 1), outcome.counts);
        if (progress) progress(std::min(total, begin + (i + 1) * batch), total);
      });
  outcome.faults = failures.some();
  return outcome;
}

}  // namespace qerr
