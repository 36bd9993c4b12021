// Compares `simulate` with a straightforward simulation (plain_simulation.hpp), for the nominal and the
// calibrated arm of configs/kuka_lwr, along sines in all joints.
//
//   cmake -S . -B build -G Ninja -DQERR_BENCH=ON && ninja -C build bench_simulate &&
//   build/tests/bench/bench_simulate
//
// One thread, interleaved, CPU time. First the results of both are compared. `ratio` is the median over the
// iterations of plain time over qerr's; the others are the best samples per second. The theory of every
// filter along the path (sigma_exact) is part of both: runs at many positions of the encoders' zeros.

#include "qerr/simulate/simulate.hpp"

#include <benchmark/benchmark.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <numbers>

#include "core/random.hpp"
#include "cpu_time.hpp"
#include "plain_simulation.hpp"
#include "qerr/filter/norms.hpp"
#include "qerr/input/spec.hpp"
#include "simulate/along_motion.hpp"

namespace {

using namespace qerr;

struct Case {
  OperationalModel model;
  std::vector<Filter> filters;
  std::vector<Norms> norms;
  Motion motion;
  SimulationOptions options;
  std::vector<Eigen::VectorXd> displacements;
};

/// Rotates every fixed transform by up to 1 mrad and shifts it by up to 0.1 mm: no angle is a right angle.
void calibrate(Chain& chain) {
  std::uint64_t drawn = 0;
  const auto off = [&] { return 2 * unit_interval(random_bits(1, drawn++, 5)) - 1; };
  const auto perturb = [&](Eigen::Isometry3d& t) {
    t.translate(1e-4 * Eigen::Vector3d(off(), off(), off()));
    t.rotate(Eigen::AngleAxisd(1e-3 * off(), Eigen::Vector3d(off(), off(), off()).normalized()));
  };
  for (ChainJoint& joint : chain.joints) perturb(joint.origin);
  perturb(chain.tip_offset);
}

/// The displacements of `simulate`: an additive recurrence with a random start from the seed.
std::vector<Eigen::VectorXd> displacements(const SimulationOptions& o, const Eigen::VectorXd& steps) {
  std::vector<Eigen::VectorXd> all(o.runs, Eigen::VectorXd::Zero(steps.size()));
  if (!o.random_phase) return all;
  double x = 1.5;
  for (int i = 0; i < 60; ++i) x = std::pow(1 + x, 1.0 / static_cast<double>(steps.size() + 1));
  for (std::uint64_t run = 0; run < o.runs; ++run) {
    double step = 1;
    for (Eigen::Index i = 0; i < steps.size(); ++i) {
      step /= x;
      const double phase = unit_interval(random_bits(o.seed, static_cast<std::uint64_t>(i), 0x7068617365)) +
                           static_cast<double>(run) * step;
      all[run][i] = steps[i] * (phase - std::floor(phase) - 0.5);
    }
  }
  return all;
}

Case make_case(bool calibrated, std::size_t coordinates, std::uint64_t runs, std::size_t filters) {
  Spec spec = read_spec(QERR_SOURCE_DIR "/configs/kuka_lwr/spec.yaml");
  Case c{spec.model, designed_filters(spec), {}, {}, {}, {}};
  if (calibrated) calibrate(c.model.chain);
  c.model.coordinates.resize(coordinates);
  c.filters.resize(filters);
  for (const Filter& filter : c.filters) c.norms.push_back(norms(filter));
  c.motion.sample_rate = 1000;
  c.motion.duration = runs == 1 ? 128 : 2;
  c.motion.settling = 0.25;
  for (std::size_t i = 0; i < c.model.chain.independent.size(); ++i) {
    const auto n = static_cast<double>(i);
    c.motion.joints.push_back({0.1 * n - 0.3, 0, {{0.3 + 0.03 * n, 0.31 + 0.17 * n, 0.4 * n}}, {}});
  }
  c.options.runs = runs;
  c.options.random_phase = runs > 1;
  c.options.threads = 1;
  c.displacements = displacements(c.options, resolutions(c.model.transmission));
  return c;
}

std::uint64_t settling(const Case& c) {
  return static_cast<std::uint64_t>(std::ceil(*c.motion.settling * c.motion.sample_rate));
}

Simulation by_qerr(const Case& c) { return simulate(c.model, c.filters, c.norms, c.motion, {}, c.options); }

struct Plain {
  plain::Result result;
  plain::Result of_zeros;  // runs at equally spaced positions of the encoders' zeros, for sigma_exact
};

Plain plainly(const Case& c) {
  const auto simulate_at = [&](const std::vector<Eigen::VectorXd>& displacements) {
    return plain::Simulator(c.model, c.filters, c.motion, settling(c))(displacements);
  };
  Plain all{simulate_at(c.displacements), {}};
  if (c.filters.empty()) return all;
  std::vector<Eigen::VectorXd> zeros;
  const double count = static_cast<double>(
      zeros_of_simulation(travels(c.model, {}, UnroundedRecord(c.motion, c.motion.sample_rate, 0)),
                          static_cast<std::uint64_t>(c.motion.duration * c.motion.sample_rate)));
  for (double k = 0; k < count; ++k)
    zeros.push_back(resolutions(c.model.transmission) * ((k + 0.5) / count - 0.5));
  all.of_zeros = simulate_at(zeros);
  return all;
}

/// The largest relative difference between both.
double difference(const Case& c) {
  const Simulation ours = by_qerr(c);
  const Plain both = plainly(c);
  const plain::Result& theirs = both.result;
  double worst = 0;
  const auto compare = [&](double a, double b) { worst = std::max(worst, std::abs(a - b) / std::abs(b)); };
  for (std::size_t o = 0; o < ours.results.size(); ++o)
    for (std::size_t i = 0; i < c.model.coordinates.size(); ++i) {
      const SimulatedSignal& a = ours.results[o][i];
      const plain::Signal& b = theirs.signals[o][i];
      compare(a.sigma_simulated, b.sigma);
      // The mean is a small difference of values with standard deviation sigma.
      worst = std::max(worst, std::abs(a.mean_simulated - b.mean) / b.sigma);
      compare(a.peak_simulated, b.peak);
      compare(a.ladder.nonlinear, b.sigma / b.linear);
      compare(a.ladder.correlated_joints, b.linear / b.parts);
      const auto row = static_cast<Eigen::Index>(i);
      const double h2 = o == 0 ? 1 : c.norms[o - 1].h2;
      compare(a.sigma_ipqn_path, h2 * std::sqrt(theirs.path_squares.row(row).sum() / 12));
      if (o > 0) compare(a.sigma_exact, both.of_zeros.signals[o][i].parts);
      if (o == 0) compare(a.worst_case_path, theirs.rigorous[row]);
    }
  return worst;
}

void side_by_side(benchmark::State& state, bool calibrated) {
  const auto runs = static_cast<std::uint64_t>(state.range(1));
  const Case c = make_case(calibrated, static_cast<std::size_t>(state.range(0)), runs,
                           static_cast<std::size_t>(state.range(2)));
  if (const double d = difference(c); !(d < 1e-11)) {
    std::fprintf(stderr, "qerr and the plain simulation differ by %.2g\n", d);
    std::exit(1);
  }
  std::vector<double> ours, theirs, ratios;
  for (auto _ : state) {
    theirs.push_back(bench::cpu_seconds([&] { return plainly(c); }));
    ours.push_back(bench::cpu_seconds([&] { return by_qerr(c); }));
    ratios.push_back(theirs.back() / ours.back());
    state.SetIterationTime(ours.back());
  }
  const double samples = c.motion.duration * c.motion.sample_rate * static_cast<double>(runs);
  const auto best = [&](const std::vector<double>& t) {
    return samples / *std::min_element(t.begin(), t.end());
  };
  std::sort(ratios.begin(), ratios.end());
  state.counters["plain"] = best(theirs);
  state.counters["qerr"] = best(ours);
  state.counters["ratio"] = ratios[ratios.size() / 2];
}

void cases(benchmark::internal::Benchmark* b) {
  b->ArgNames({"coordinates", "runs", "filters"})->ArgsProduct({{3, 6}, {1, 64}, {2, 0}});
  b->UseManualTime()->Iterations(7)->Unit(benchmark::kMillisecond);
}

BENCHMARK_CAPTURE(side_by_side, kuka_lwr, false)->Apply(cases);
BENCHMARK_CAPTURE(side_by_side, calibrated, true)->Apply(cases);

}  // namespace

BENCHMARK_MAIN();
