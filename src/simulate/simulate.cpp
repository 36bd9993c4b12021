#include "qerr/simulate/simulate.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <mutex>
#include <optional>

#include "core/parallel.hpp"
#include "qerr/core/error.hpp"
#include "qerr/core/quantity.hpp"
#include "simulate/run.hpp"

namespace qerr {

namespace {

constexpr std::size_t most_stretches = 512;
// Longer runs are distributed to threads one by one.
constexpr std::uint64_t most_samples_together = std::uint64_t{1} << 15;

std::uint64_t divisor(const Filter& filter, const Motion& motion) {
  const double ratio = motion.sample_rate / filter.sample_rate, whole = std::round(ratio);
  if (whole < 1 || std::abs(ratio - whole) > 1e-9 * whole)
    throw Error({{},
                 "motion.sample_rate",
                 "the rate of a filter must divide the rate of the motion",
                 shortest(filter.sample_rate) + " Hz of " + shortest(motion.sample_rate) + " Hz",
                 "give both the same rate, or the motion a multiple"});
  return static_cast<std::uint64_t>(whole);
}

/// Samples until transients have decayed to 1e-3, at the rate of the motion. The factor 1.5 allows for the
/// polynomial factors of repeated poles.
double settled_after(const Filter& filter, std::uint64_t every) {
  const double modulus = poles_max_modulus(filter);
  const double decay = modulus > 0 ? std::log(1e-3) / std::log(modulus) : 0;
  const auto order = static_cast<double>(2 * filter.sections.size() + filter.taps.size());
  return (1.5 * decay + order) * static_cast<double>(every);
}

/// over/under; NaN if one of them is infinite or NaN, 1 if `under` is zero.
double ratio(double over, double under) {
  if (!std::isfinite(over) || !std::isfinite(under)) return std::numeric_limits<double>::quiet_NaN();
  return under > 0 ? over / under : 1;
}

SimulatedSignal signal_of(const RunStatistics& s, const SignalTheory& theory, Eigen::Index coordinate,
                          const Channels& channels) {
  SimulatedSignal r;
  const double exact = s.variance(coordinate), linear = s.variance(channels.linear() + coordinate);
  double parts = 0;
  for (Eigen::Index i = 0; i < channels.encoders; ++i) parts += s.variance(channels.part(i) + coordinate);
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
  r.sigma_exact = std::hypot(theory.exact, mean_variation);
  r.worst_case = theory.worst_case;
  r.worst_case_path = theory.worst_case_path;
  r.ladder = {ratio(ipqn_path, theory.ipqn), ratio(std::sqrt(parts), ipqn_path),
              ratio(std::sqrt(linear), std::sqrt(parts)), ratio(std::sqrt(exact), std::sqrt(linear))};
  return r;
}

}  // namespace

Simulation simulate(const OperationalModel& model, const std::vector<Filter>& filters,
                    const std::vector<Norms>& norms, const Motion& motion, const std::vector<Effect>& effects,
                    const SimulationOptions& options) {
  const auto samples = static_cast<std::uint64_t>(std::floor(motion.duration * motion.sample_rate + 0.5));
  double settling = 0;
  std::vector<std::uint64_t> every;
  for (const Filter& filter : filters) {
    every.push_back(divisor(filter, motion));
    settling = std::max(settling, settled_after(filter, every.back()));
  }
  settling = std::min(settling, 0.5 * static_cast<double>(samples));
  if (motion.settling) settling = *motion.settling * motion.sample_rate;
  const OperationalError middle = operational_error(model, center(motion));
  Job job{model, filters, motion, effects, options, every, std::max<std::uint64_t>(samples, 1),
          std::min(static_cast<std::uint64_t>(std::ceil(settling)), samples == 0 ? 0 : samples - 1),
          // The interval of sigma is estimated between runs or, for a single run, between its parts.
          options.runs > 1 ? std::uint64_t{1} : std::uint64_t{20},
          // The speeds along the path matter only with filters.
          filters.empty() ? std::size_t{1} : most_stretches, middle.mean,
          even_spread(static_cast<Eigen::Index>(model.transmission.encoders.size()))};
  const Channels channels(model);

  // Runs are joined in their order, 64 at a time, so that memory does not grow with their number. Grouping
  // does not depend on the number of threads, hence neither do the results.
  constexpr std::uint64_t wave = 64;
  const std::uint64_t together = job.samples <= most_samples_together ? 8 : 1;
  std::mutex guard;
  std::uint64_t done = 0;
  const auto tick = [&] {
    const std::lock_guard lock(guard);
    done += std::min(tick_samples, job.samples);
    if (options.progress)
      options.progress(std::min(done, job.samples * options.runs), job.samples * options.runs);
  };
  const SimulationKernels& kernels = select_kernels<SimulationKernels>(options.instructions);
  std::vector<RunStatistics> all;
  for (std::size_t f = 0; f <= filters.size(); ++f)
    all.emplace_back(channels.count(), channels.coordinates, 0, job.blocks, kernels);
  AlongPath path(channels.coordinates, channels.encoders, job.stretches);
  for (std::uint64_t first = 0; first < options.runs; first += wave) {
    const std::uint64_t runs = std::min(wave, options.runs - first);
    std::vector<std::optional<RunsResult>> results((runs + together - 1) / together);
    parallel_for(results.size(), options.threads, [&](std::size_t i) {
      results[i] = run_together(job, first + i * together, std::min(together, runs - i * together), tick);
    });
    for (const auto& result : results) {
      for (const auto& outputs : result->outputs)
        for (std::size_t f = 0; f < all.size(); ++f) all[f].append(outputs[f]);
      path.append(result->path);
    }
  }

  const auto theory =
      theory_along_path(middle, model.transmission, filters, norms, motion, job.settling, path);
  Simulation result{options.runs, job.samples, job.settling, {}};
  for (std::size_t f = 0; f < all.size(); ++f) {
    auto& row = result.results.emplace_back();
    for (Eigen::Index c = 0; c < channels.coordinates; ++c)
      row.push_back(signal_of(all[f], theory[f][static_cast<std::size_t>(c)], c, channels));
  }
  return result;
}

}  // namespace qerr
