#include "qerr/simulate/simulate.hpp"

#include <algorithm>
#include <cmath>
#include <mutex>
#include <utility>

#include "core/parallel.hpp"
#include "core/random.hpp"
#include "qerr/core/error.hpp"
#include "qerr/core/quantity.hpp"
#include "simulate/along_motion.hpp"
#include "simulate/run.hpp"
#include "simulate/unrounded_record.hpp"

namespace qerr {

std::uint64_t divisor_of(const Filter& filter, const Motion& motion) {
  constexpr double most_exact_whole = 9007199254740992;  // 2^53: a double has all neighbours up to it
  const double ratio = motion.sample_rate / filter.sample_rate, whole = std::round(ratio);
  if (whole < 1 || whole > most_exact_whole || std::abs(ratio - whole) > 1e-9 * whole)
    throw Error("motion.sample_rate", "the rate of a filter must divide the rate of the motion",
                shortest(filter.sample_rate) + " Hz of " + shortest(motion.sample_rate) + " Hz",
                "give both the same rate, or the motion a multiple");
  return static_cast<std::uint64_t>(whole);
}

namespace {

// Longer runs are distributed to threads one by one.
constexpr std::uint64_t most_samples_together = std::uint64_t{1} << 15;

/// over/under; NaN if one of them is infinite or NaN, 1 if `under` is zero.
double ratio(double over, double under) {
  if (!std::isfinite(over) || !std::isfinite(under)) return std::numeric_limits<double>::quiet_NaN();
  return under > 0 ? over / under : 1;
}

/// Sum of the variances that the errors of the encoders contribute to a coordinate.
double variance_of_parts(const RunStatistics& s, Eigen::Index coordinate, const Channels& channels) {
  double sum = 0;
  for (Eigen::Index i = 0; i < channels.encoders; ++i) sum += s.variance(channels.part(i) + coordinate);
  return sum;
}

/// @param exact_variance  of sigma_exact, but for the variation of the mean error
SimulatedSignal signal_of(const RunStatistics& s, const SignalTheory& theory, double exact_variance,
                          Eigen::Index coordinate, const Channels& channels) {
  SimulatedSignal r;
  const double exact = s.variance(coordinate), linear = s.variance(channels.linear() + coordinate);
  const double parts = variance_of_parts(s, coordinate, channels);
  // The variation of the mean error along the path is part of the theory.
  const double mean_variation = channels.biased ? std::sqrt(s.variance(channels.mean() + coordinate)) : 0;
  const double ipqn_path = std::hypot(theory.ipqn_path, mean_variation);
  const RunStatistics::Interval interval = s.sigma_interval(coordinate);
  r.sigma_simulated = std::sqrt(exact);
  r.sigma_lower = interval.lower;
  r.sigma_upper = interval.upper;
  r.mean_simulated = s.mean(coordinate);
  r.peak_simulated = s.peak(coordinate);
  r.sigma_ipqn = theory.ipqn;
  r.sigma_ipqn_path = ipqn_path;
  r.sigma_exact = std::hypot(std::sqrt(exact_variance), mean_variation);
  r.worst_case = theory.worst_case;
  r.worst_case_path = theory.worst_case_path;
  r.ladder = {ratio(ipqn_path, theory.ipqn), ratio(std::sqrt(parts), ipqn_path),
              ratio(std::sqrt(linear), std::sqrt(parts)), ratio(std::sqrt(exact), std::sqrt(linear))};
  return r;
}

/// Statistics of all runs: [0: the position itself, then the filters].
struct AllRuns {
  std::vector<RunStatistics> outputs;
  BoundsAlongPath bounds;
  std::vector<ErrorTrace> traces;
};

/// Runs are joined in their order, 64 at a time, so that memory does not grow with their number. Grouping
/// does not depend on the number of threads, hence neither do the results.
AllRuns run_all(const Job& job, const std::function<void()>& tick) {
  constexpr std::uint64_t wave = 64;
  const Channels channels(job.model);
  const std::uint64_t together = job.samples <= most_samples_together ? 8 : 1, runs = job.options.runs;
  AllRuns all;
  for (std::size_t f = 0; f <= job.filters.size(); ++f)
    all.outputs.emplace_back(channels.count(), channels.coordinates, 0, job.blocks,
                             select_kernels<SimulationKernels>(job.options.instructions));
  all.bounds = {Eigen::VectorXd::Zero(channels.coordinates), Eigen::VectorXd::Zero(channels.coordinates)};
  for (std::uint64_t first = 0; first < runs; first += wave) {
    const std::uint64_t count = std::min(wave, runs - first);
    std::vector<std::optional<RunsResult>> results((count + together - 1) / together);
    parallel_for(results.size(), job.options.threads, [&](std::size_t i) {
      results[i] = run_together(job, first + i * together, std::min(together, count - i * together), tick);
    });
    if (first == 0) all.traces = std::move(results.front()->traces);
    for (const auto& result : results) {
      for (const auto& outputs : result->outputs)
        for (std::size_t f = 0; f < all.outputs.size(); ++f) all.outputs[f].append(outputs[f]);
      all.bounds.include(result->bounds);
    }
  }
  return all;
}

/// Other runs that show how far the sigma of a few runs scatters; 0: there are enough runs, or they are so
/// long that each of them passes many counts, and their own scatter shows it.
std::uint64_t runs_of_scatter(const SimulationOptions& options, std::uint64_t samples) {
  constexpr std::uint64_t enough = 64, most = 128, least = 16, most_simulated = std::uint64_t{1} << 23;
  if (options.runs < 2 || options.runs >= enough) return 0;
  const std::uint64_t affordable = std::min(most_simulated / samples, most);
  return affordable < least ? 0 : affordable;
}

/// Sets figures to 0 that are the rounding of a zero: a coordinate that no joint moves, or a mean of errors
/// that cancel. Entries of a Jacobian that vanish are rounding errors of some 1e-16 times the reach, and n
/// errors that cancel leave about sqrt(n) 1e-16 of their magnitude, so that 1e-13 of the largest error of the
/// output in the same unit is above both; no two encoders of a robot differ as much.
void drop_rounding(const std::vector<Coordinate>& coordinates, std::vector<SimulatedSignal>& signals) {
  constexpr double rounding = 1e-13;
  for (std::size_t c = 0; c < signals.size(); ++c) {
    double largest = 0;
    for (std::size_t k = 0; k < signals.size(); ++k)
      if (info(coordinates[k]).unit == info(coordinates[c]).unit && std::isfinite(signals[k].peak_simulated))
        largest = std::max(largest, signals[k].peak_simulated);
    SimulatedSignal& s = signals[c];
    for (double* const figure :
         {&s.sigma_simulated, &s.sigma_lower, &s.sigma_upper, &s.mean_simulated, &s.peak_simulated})
      if (std::abs(*figure) <= rounding * largest) *figure = 0;
  }
}

/// Root mean square of a signal.
double rms(double mean, double variance) { return std::sqrt(mean * mean + variance); }

/// Adds the tracking errors of the filters. The position itself has none.
void add_tracking(const Job& job, Simulation& s) {
  const double settling = static_cast<double>(job.settling) / job.motion.sample_rate;
  for (std::size_t c = 0; c < s.results[0].size(); ++c) {
    SimulatedSignal& position = s.results[0][c];
    position.tracking_rms = position.tracking_peak = 0;
    position.total_rms = rms(position.mean_simulated, std::pow(position.sigma_simulated, 2));
  }
  parallel_for(job.filters.size(), job.options.threads, [&](std::size_t f) {
    const auto moments = tracking_along_motion(job.model, job.effects, job.motion, job.filters[f], settling);
    for (std::size_t c = 0; c < moments.size(); ++c) {
      const TrackingMoments& t = moments[c];
      SimulatedSignal& signal = s.results[f + 1][c];
      signal.tracking_rms = rms(t.mean, t.variance);
      signal.tracking_peak = t.peak;
      const double variance = std::pow(signal.sigma_simulated, 2) + t.variance + 2 * t.with_effects;
      signal.total_rms = rms(signal.mean_simulated + t.mean, std::max(0.0, variance));
    }
  });
}

}  // namespace

Simulation simulate(const OperationalModel& model, const std::vector<Filter>& filters,
                    const std::vector<Norms>& norms, const Motion& motion, const std::vector<Effect>& effects,
                    const SimulationOptions& options) {
  const auto samples = static_cast<std::uint64_t>(std::floor(motion.duration * motion.sample_rate + 0.5));
  std::vector<std::uint64_t> every;
  for (const Filter& filter : filters) every.push_back(divisor_of(filter, motion));
  const double settling = std::ceil(settling_time(motion, filters) * motion.sample_rate);
  const OperationalError middle = operational_error(model, center(motion));
  const Job job{
      model, filters, motion, effects, options, every, std::max<std::uint64_t>(samples, 1),
      static_cast<std::uint64_t>(std::min(settling, static_cast<double>(samples == 0 ? 0 : samples - 1))),
      // The interval of sigma is estimated between runs or, for a single run, between its parts.
      options.runs > 1 ? std::uint64_t{1} : std::uint64_t{20}, middle.mean};
  const Channels channels(model);

  // sigma_exact is a mean over the position of the encoders' zeros: runs of the same motion without effects,
  // as the Jacobian varies along it (sigma_along_motion knows only the encoders).
  OperationalModel nearest = model;
  nearest.sources.clear();
  for (Encoder& encoder : nearest.transmission.encoders) encoder.rounding = Rounding::nearest;
  const std::vector<Effect> none;
  SimulationOptions of_zeros = options;
  of_zeros.runs =
      filters.empty() || !options.exact
          ? 0
          : zeros_of_simulation(travels(nearest, none, UnroundedRecord(motion, motion.sample_rate, 0)),
                                job.samples);
  of_zeros.visit = {};
  of_zeros.traced = 0;
  const Job zeros{.model = nearest,
                  .filters = filters,
                  .motion = motion,
                  .effects = none,
                  .options = of_zeros,
                  .every = every,
                  .samples = job.samples,
                  .settling = job.settling,
                  .blocks = 1,
                  .mean = Eigen::VectorXd::Zero(middle.mean.size()),
                  .every_zero = true};

  SimulationOptions of_scatter = options;
  of_scatter.runs = runs_of_scatter(options, job.samples);
  of_scatter.seed = stream_seed(options.seed, "scatter of the runs");
  of_scatter.visit = {};
  of_scatter.traced = 0;
  const Job scatter{model, filters,     motion,       effects,    of_scatter,
                    every, job.samples, job.settling, job.blocks, job.mean};

  std::mutex guard;
  std::uint64_t done = 0;
  const std::uint64_t total = job.samples * (options.runs + of_zeros.runs + of_scatter.runs);
  const auto tick = [&] {
    const std::lock_guard lock(guard);
    done += std::min(tick_samples, job.samples);
    if (options.progress) options.progress(std::min(done, total), total);
  };
  AllRuns all = run_all(job, tick);
  const AllRuns exact = run_all(zeros, tick), others = run_all(scatter, tick);
  Eigen::VectorXd squares(channels.coordinates);
  for (Eigen::Index c = 0; c < squares.size(); ++c) squares[c] = all.outputs[0].expected(c);
  const auto theory = theory_along_path(middle, norms, squares, all.bounds);
  Simulation result{options.runs, job.samples, job.settling, {}, std::move(all.traces)};
  for (std::size_t f = 0; f < all.outputs.size(); ++f) {
    auto& row = result.results.emplace_back();
    for (Eigen::Index c = 0; c < channels.coordinates; ++c) {
      // Infinite if the path meets the gimbal lock, even where the error of an encoder at rest is 0.
      const bool ipqn = f == 0 || !std::isfinite(squares[c]);
      double exact_variance = std::numeric_limits<double>::quiet_NaN();
      if (ipqn)
        exact_variance = squares[c] / 12;
      else if (of_zeros.runs > 0)
        exact_variance = variance_of_parts(exact.outputs[f], c, Channels(nearest));
      row.push_back(signal_of(all.outputs[f], theory[f][c], exact_variance, c, channels));
      if (of_scatter.runs == 0) continue;
      const RunStatistics::Interval interval =
          others.outputs[f].sigma_interval_of(options.runs, all.outputs[f].variance(c), c);
      row.back().sigma_lower = interval.lower;
      row.back().sigma_upper = interval.upper;
    }
    drop_rounding(model.coordinates, row);
  }
  if (options.tracking) add_tracking(job, result);
  return result;
}

}  // namespace qerr
