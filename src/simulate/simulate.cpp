#include "qerr/simulate/simulate.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <mutex>
#include <optional>

#include "qerr/core/error.hpp"
#include "qerr/core/parallel.hpp"
#include "qerr/core/quantity.hpp"
#include "qerr/core/random.hpp"
#include "qerr/filter/filter_bank.hpp"
#include "run_statistics.hpp"
#include "theory_along_path.hpp"
#include "tip_error.hpp"

namespace qerr {

namespace {

constexpr std::uint64_t displacement_stream = 0x7068617365;

/// What is filtered of every coordinate: the exact error, its linear part, the part of every encoder in that,
/// and, where errors have a mean, what the Jacobian makes of it along the path.
struct Channels {
  Eigen::Index coordinates, encoders;
  bool biased;

  explicit Channels(const OperationalModel& model)
      : coordinates(static_cast<Eigen::Index>(model.coordinates.size())),
        encoders(static_cast<Eigen::Index>(model.transmission.encoders.size())),
        biased((mean_errors(model.transmission).array() != 0).any() ||
               std::any_of(model.sources.begin(), model.sources.end(),
                           [](const ErrorSource& source) { return source.mean != 0; })) {}

  Eigen::Index count() const { return coordinates * (2 + encoders + (biased ? 1 : 0)); }
  Eigen::Index linear() const { return coordinates; }
  Eigen::Index part(Eigen::Index encoder) const { return coordinates * (2 + encoder); }
  Eigen::Index mean() const { return coordinates * (2 + encoders); }
};

/// One filter, and of how many samples of the motion it takes one.
struct Branch {
  FilterBank bank;
  std::uint64_t every;
};

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

/// Samples until transients have died to 1e-3, at the rate of the motion.
double settled_after(const Filter& filter, std::uint64_t every) {
  const double modulus = poles_max_modulus(filter);
  const double decay = modulus > 0 ? std::log(1e-3) / std::log(modulus) : 0;
  const auto order = static_cast<double>(2 * filter.sections.size() + filter.taps.size());
  return (1.5 * decay + order) * static_cast<double>(every);
}

struct Job {
  const OperationalModel& model;
  const std::vector<Filter>& filters;
  const Motion& motion;
  const std::vector<Effect>& effects;
  const SimulationOptions& options;
  std::uint64_t samples, settling, blocks;
  Eigen::VectorXd mean;  ///< of the error at the centre of the motion
};

/// Part of a count by which each encoder's path is displaced: uniform for every run, and spread evenly over
/// the runs, so that their mean converges faster than that of independent ones.
Eigen::VectorXd displacement(const Job& job, std::uint64_t run) {
  const Eigen::VectorXd steps = resolutions(job.model.transmission);
  Eigen::VectorXd d = Eigen::VectorXd::Zero(steps.size());
  if (!job.options.random_phase) return d;
  // x^(n+1) = x + 1: the powers of 1/x make the most even additive sequence in n dimensions (Roberts 2018).
  double x = 1.5;
  for (int i = 0; i < 60; ++i) x = std::pow(1 + x, 1.0 / static_cast<double>(d.size() + 1));
  double step = 1;
  for (Eigen::Index i = 0; i < d.size(); ++i) {
    step /= x;
    const double start =
        unit_interval(random_bits(job.options.seed, static_cast<std::uint64_t>(i), displacement_stream));
    const double phase = start + static_cast<double>(run) * step;
    d[i] = steps[i] * (phase - std::floor(phase) - 0.5);
  }
  return d;
}

/// What one run gives: statistics of the position, then of the filters, and theory at its samples.
struct Result {
  std::vector<RunStatistics> outputs;
  AlongPath path;
};

Result run(const Job& job, std::uint64_t index, const std::function<void()>& tick) {
  const Channels channels(job.model);
  Sensing sensing(
      job.model, job.motion, job.effects,
      {displacement(job, index), random_bits(job.options.seed, index, 0), index == 0 && job.options.visit});
  Result result{{RunStatistics(channels.count(), channels.coordinates, job.blocks)},
                {job.mean, channels.encoders}};
  std::vector<Branch> branches;
  for (const Filter& filter : job.filters) {
    branches.push_back({FilterBank(filter, channels.count()), divisor(filter, job.motion)});
    result.outputs.push_back(result.outputs.front());
  }
  const Eigen::VectorXd steps = resolutions(job.model.transmission);
  Eigen::ArrayXd inputs(channels.count()), signals(channels.count());
  for (std::uint64_t k = 0; k < job.samples; ++k) {
    const Reading& reading = sensing.read(k);
    if (index == 0 && job.options.visit) job.options.visit(reading);
    const bool counts = k >= job.settling;
    const double progress = (static_cast<double>(k) - static_cast<double>(job.settling)) /
                            static_cast<double>(job.samples - job.settling);
    const auto block = counts ? static_cast<std::uint64_t>(progress * static_cast<double>(job.blocks)) : 0;
    const OperationalError theory = operational_error(job.model, reading.joint);
    result.path.add(theory, progress);
    const Eigen::ArrayXd variance = theory.weighted.rowwise().squaredNorm().array() / 12;
    const Eigen::MatrixXd parts =
        theory.weighted * (reading.measured - reading.encoder).cwiseQuotient(steps).asDiagonal();
    const Eigen::Index m = channels.coordinates;
    inputs.head(m) =
        tip_error(job.model.coordinates, forward_kinematics(job.model.chain, reading.estimate), reading.tip);
    inputs.segment(channels.linear(), m) = parts.rowwise().sum();
    inputs.segment(channels.part(0), m * channels.encoders) = parts.reshaped();
    if (channels.biased) inputs.segment(channels.mean(), m) = theory.mean;
    if (counts) result.outputs[0].add(inputs, variance, block);
    for (std::size_t f = 0; f < branches.size(); ++f) {
      if (k % branches[f].every != 0) continue;
      // The first error stands for all before it: a constant one is no step.
      if (k == 0) branches[f].bank.settle(inputs);
      signals = inputs;
      branches[f].bank.step(signals);
      if (counts) result.outputs[f + 1].add(signals, variance, block);
    }
    if (k % 4096 == 0) tick();
  }
  return result;
}

/// NaN where one of them has no bound or is not known.
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
  // A mean that the Jacobian carries along the path is part of what theory knows.
  const double carried = channels.biased ? std::sqrt(s.variance(channels.mean() + coordinate)) : 0;
  const double ipqn_path = std::hypot(theory.ipqn_path, carried);
  const RunStatistics::Interval interval = s.sigma_interval(coordinate);
  r.sigma_simulated = std::sqrt(exact);
  r.sigma_lower = interval.lower;
  r.sigma_upper = interval.upper;
  r.mean_simulated = s.mean(coordinate);
  r.peak_simulated = s.peak(coordinate);
  r.sigma_ipqn = theory.ipqn;
  r.sigma_ipqn_path = ipqn_path;
  r.sigma_exact = std::hypot(theory.exact, carried);
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
  for (const Filter& filter : filters)
    settling = std::max(settling, settled_after(filter, divisor(filter, motion)));
  settling = std::min(settling, 0.5 * static_cast<double>(samples));
  if (motion.settling) settling = *motion.settling * motion.sample_rate;
  const OperationalError middle = operational_error(model, center(motion));
  Job job{model, filters, motion, effects, options, std::max<std::uint64_t>(samples, 1),
          std::min(static_cast<std::uint64_t>(std::ceil(settling)), samples == 0 ? 0 : samples - 1),
          // Runs differ in their phases, parts of one run do not.
          options.runs > 1 ? std::uint64_t{1} : std::uint64_t{20}, middle.mean};
  const Channels channels(model);

  // Runs are joined in their order, a wave at a time, so that memory does not grow with their number.
  constexpr std::uint64_t wave = 64;
  std::mutex guard;
  std::uint64_t done = 0;
  const auto tick = [&] {
    const std::lock_guard lock(guard);
    done += std::min<std::uint64_t>(4096, job.samples);
    if (options.progress)
      options.progress(std::min(done, job.samples * options.runs), job.samples * options.runs);
  };
  std::vector<RunStatistics> all(filters.size() + 1,
                                 RunStatistics(channels.count(), channels.coordinates, job.blocks));
  AlongPath path(job.mean, channels.encoders);
  for (std::uint64_t first = 0; first < options.runs; first += wave) {
    std::vector<std::optional<Result>> runs(std::min(wave, options.runs - first));
    parallel_for(runs.size(), options.threads, [&](std::size_t i) { runs[i] = run(job, first + i, tick); });
    for (const auto& one : runs) {
      for (std::size_t f = 0; f < all.size(); ++f) all[f].append(one->outputs[f]);
      path.append(one->path);
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
