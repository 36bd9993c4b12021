// Compares the surrogates of `diagnose` and the statistics of their residuals with plain code, row by row
// (reference_residuals.hpp): 99 surrogates of a record of one joint.
//
//   cmake -S . -B build -G Ninja -DQERR_BENCH=ON && ninja -C build bench_surrogates &&
//   build/tests/bench/bench_surrogates
//
// One thread, interleaved, CPU time. First the results of both are compared. `ratio` is the median over the
// iterations of plain time over qerr's; the others are the best readings of surrogates per second. The
// preparation per joint is part of both. `set` is the instruction set: 0 portable, 1 avx2, 2 avx512.

#include <benchmark/benchmark.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>

#include "cpu_time.hpp"
#include "qerr/input/spec.hpp"
#include "support/random_evidence.hpp"
#include "support/reference_residuals.hpp"

namespace {

using namespace qerr;

constexpr Eigen::Index surrogates = 99;

double difference(const std::vector<ResidualStatistic>& ours, const std::vector<ResidualStatistic>& theirs) {
  double worst = ours.size() == theirs.size() ? 0 : 1;
  for (std::size_t i = 0; i < std::min(ours.size(), theirs.size()); ++i)
    worst = std::max(worst, (ours[i].values - theirs[i].values).abs().maxCoeff());
  return worst;
}

void side_by_side(benchmark::State& state) {
  const InstructionSet set = static_cast<InstructionSet>(state.range(0));
  const auto& available = available_instruction_sets();
  if (std::find(available.begin(), available.end(), set) == available.end())
    return state.SkipWithError("not supported by this processor");
  testing::Dice dice(1);
  testing::EvidenceMix mix;
  mix.rows = state.range(1);
  mix.effort = true;
  const Evidence e = testing::random_evidence(dice, mix);
  std::vector<Filter> filters = designed_filters(read_spec(QERR_SOURCE_DIR "/configs/kuka_lwr/spec.yaml"));
  const auto ours = [&] { return residual_statistics(e, filters, surrogates, 1, 1, set); };
  const auto theirs = [&] { return testing::reference_statistics(e, filters, surrogates, 1); };
  if (const double d = difference(ours(), theirs()); !(d < 1e-11)) {
    std::fprintf(stderr, "qerr and the plain surrogates differ by %.2g\n", d);
    std::exit(1);
  }
  std::vector<double> our_times, their_times, ratios;
  for (auto _ : state) {
    their_times.push_back(bench::cpu_seconds(theirs));
    our_times.push_back(bench::cpu_seconds(ours));
    ratios.push_back(their_times.back() / our_times.back());
    state.SetIterationTime(our_times.back());
  }
  const auto best = [&](const std::vector<double>& t) {
    return static_cast<double>(mix.rows * (surrogates + 1)) / *std::min_element(t.begin(), t.end());
  };
  std::sort(ratios.begin(), ratios.end());
  state.counters["plain"] = best(their_times);
  state.counters["qerr"] = best(our_times);
  state.counters["ratio"] = ratios[ratios.size() / 2];
}

BENCHMARK(side_by_side)
    ->ArgNames({"set", "rows"})
    ->ArgsProduct({{0, 1, 2}, {4000, 65536}})
    ->UseManualTime()
    ->Iterations(9)
    ->Unit(benchmark::kMillisecond);

}  // namespace

BENCHMARK_MAIN();
