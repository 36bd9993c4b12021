#include "race.hpp"

#include <time.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <thread>

#include "qerr/bound/workspace.hpp"

namespace qerr::bench {

namespace {

double seconds(clockid_t clock) {
  timespec t{};
  clock_gettime(clock, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

/// Work that can be repeated any number of times, and its measured rates.
class Timed {
 public:
  /// @param work   performs `count` repetitions
  /// @param limit  the maximum number of repetitions per call; more are split into several calls
  Timed(clockid_t clock, std::uint64_t limit, std::function<void(std::uint64_t)> work)
      : clock_(clock), limit_(limit), work_(std::move(work)) {}

  /// Determines the number of repetitions per slice; also a warm-up.
  void fit(double slice) {
    for (count_ = std::min<std::uint64_t>(256, limit_);; count_ *= 4) {
      const double taken = time();
      if (taken < slice / 20) continue;
      const double fitting = static_cast<double>(count_) * slice / taken;
      count_ = std::max<std::uint64_t>(1, static_cast<std::uint64_t>(fitting));
      // An integer number of calls, so that each evaluates the same configurations.
      if (count_ > limit_) count_ = (count_ + limit_ / 2) / limit_ * limit_;
      return;
    }
  }
  void measure() {
    const double before = seconds(CLOCK_PROCESS_CPUTIME_ID);
    const double taken = time();
    const double rate = static_cast<double>(count_) / taken;
    if (rates_.empty() || rate > *std::max_element(rates_.begin(), rates_.end()))
      cores_ = (seconds(CLOCK_PROCESS_CPUTIME_ID) - before) / taken;
    rates_.push_back(rate);
  }

  /// Number of cores used by all threads in the best round.
  double cores() const { return cores_; }

  Rate rate() const {
    std::vector<double> sorted = rates_;
    std::sort(sorted.begin(), sorted.end());
    const std::size_t n = sorted.size();
    return {sorted.back(), (sorted[(n - 1) / 2] + sorted[n / 2]) / 2};
  }

 private:
  double time() const {
    const double start = seconds(clock_);
    for (std::uint64_t rest = count_; rest > 0;) {
      const std::uint64_t now = std::min(rest, limit_);
      work_(now);
      rest -= now;
    }
    return seconds(clock_) - start;
  }

  clockid_t clock_;
  std::uint64_t limit_, count_ = 0;
  std::function<void(std::uint64_t)> work_;
  std::vector<double> rates_;
  double cores_ = 0;
};

constexpr std::uint64_t unlimited = std::uint64_t{1} << 40;

Timed timed_contestant(const Contestant& c, const Problem& p, Stage stage) {
  const auto points = static_cast<std::uint64_t>(p.points.cols());
  return {CLOCK_THREAD_CPUTIME_ID, c.draws_itself ? unlimited : points,
          [run = c.prepare(p), stage](std::uint64_t count) { run(stage, count, nullptr); }};
}

/// workspace() with a number of threads, by wall time.
Timed timed_threads(const Problem& p, unsigned threads) {
  return {CLOCK_MONOTONIC, unlimited, [&p, threads](std::uint64_t count) {
            Configurations configurations = p.configurations;
            configurations.count = count;
            const Workspace all = workspace(p.model, {}, configurations, {.threads = threads});
            observe(&all);
          }};
}

Timed timed_peak(const FmaPeak& peak) {
  return {CLOCK_THREAD_CPUTIME_ID, unlimited, [chains = peak.chains](std::uint64_t rounds) {
            const double sum = chains(rounds);
            observe(&sum);
          }};
}

/// All timed work, in the order of execution.
struct Course {
  struct Entry {
    std::size_t problem, contestant, stage;
    Timed timed;
  };
  struct Threads {
    std::size_t problem;
    Timed one, two;
  };
  std::vector<Entry> entries;
  std::vector<Threads> threads;
  std::vector<Timed> peaks;

  void fit(double slice) {
    for (Entry& e : entries) e.timed.fit(slice);
    // Wall time includes other processes and the start of threads: a longer slice reduces their influence.
    for (Threads& t : threads) t.one.fit(3 * slice), t.two.fit(3 * slice);
    for (Timed& peak : peaks) peak.fit(slice);
  }
  void round() {
    for (Entry& e : entries) e.timed.measure();
    for (Threads& t : threads) t.one.measure(), t.two.measure();
    for (Timed& peak : peaks) peak.measure();
  }
};

Course course(const std::vector<Problem>& problems, const std::vector<Contestant>& rows,
              const Results& results) {
  Course c;
  for (std::size_t p = 0; p < problems.size(); ++p) {
    for (std::size_t s = 0; s < stages.size(); ++s)
      for (std::size_t i = 0; i < rows.size(); ++i)
        if (rows[i].does(stages[s]))
          c.entries.push_back({p, i, s, timed_contestant(rows[i], problems[p], stages[s])});
    if (std::thread::hardware_concurrency() > 1)
      c.threads.push_back({p, timed_threads(problems[p], 1), timed_threads(problems[p], 2)});
  }
  for (const PeakResult& peak : results.peaks) c.peaks.push_back(timed_peak(peak.peak));
  return c;
}

void set_fractions(const Contestant& row, const Problem& p, const std::vector<PeakResult>& peaks,
                   ContestantResult& result) {
  if (!row.fma_pipe_operations) return;
  const auto peak = std::find_if(peaks.begin(), peaks.end(), [&](const PeakResult& r) {
    return r.peak.instruction_set == row.instruction_set;
  });
  for (std::size_t s = 0; s < stages.size(); ++s) {
    if (!result.rates[s]) continue;
    const double operations = row.fma_pipe_operations(p, stages[s]);
    result.fma_pipe_operations[s] = operations;
    if (peak != peaks.end())
      result.fraction_of_bound[s] = result.rates[s]->best * operations / (peak->rate.best * peak->peak.lanes);
  }
}

}  // namespace

void race(const std::vector<Problem>& problems, const std::vector<Contestant>& rows,
          const RaceOptions& options, Results& results) {
  Course c = course(problems, rows, results);
  c.fit(options.slice);
  for (unsigned round = 0; round < options.rounds; ++round) c.round();

  for (const Course::Entry& e : c.entries)
    results.problems[e.problem].contestants[e.contestant].rates[e.stage] = e.timed.rate();
  for (const Course::Threads& t : c.threads)
    results.problems[t.problem].two_threads = {t.two.rate().best / t.one.rate().best, t.two.cores()};
  for (std::size_t i = 0; i < c.peaks.size(); ++i) {
    results.peaks[i].rate = c.peaks[i].rate();
    results.peaks[i].rate.best *= FmaPeak::per_round;
    results.peaks[i].rate.median *= FmaPeak::per_round;
  }
  for (std::size_t p = 0; p < problems.size(); ++p)
    for (std::size_t i = 0; i < rows.size(); ++i)
      set_fractions(rows[i], problems[p], results.peaks, results.problems[p].contestants[i]);
}

}  // namespace qerr::bench
