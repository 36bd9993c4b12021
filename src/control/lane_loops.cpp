#include "control/kernels.hpp"
#include "lanes/select_kernels.hpp"

namespace qerr::lanes {
namespace {

template <class L>
[[gnu::always_inline]] inline L row_of(const double* rows, std::size_t row) {
  return load<L>(rows + row * loops_of_run);
}

template <class L>
[[gnu::always_inline]] inline void set_row(double* rows, std::size_t row, const L& value) {
  store(rows + row * loops_of_run, value);
}

template <bool second, class L>
[[gnu::always_inline]] inline L section(const NormalizedSection<double>& s, const L& x, double* states) {
  SectionState<L> state{row_of<L>(states, 0), row_of<L>(states, 1)};
  const L y = output<second>(broadcast<L>(s.b0), broadcast<L>(s.b1), broadcast<L>(s.b2),
                             advance<second>(broadcast<L>(s.k0), broadcast<L>(s.k1), x, state));
  set_row(states, 0, state.s1);
  set_row(states, 1, state.s2);
  return y;
}

/// The velocity filter. @param states  of its sections, then its past inputs, the newest at `newest`
template <class L>
[[gnu::always_inline]] inline L velocity(const LoopPlan& p, L x, double* states, std::size_t newest) {
  for (std::size_t i = 0; i < p.section_count; ++i)
    x = p.sections[i].second ? section<true>(p.sections[i], x, states + 2 * i * loops_of_run)
                             : section<false>(p.sections[i], x, states + 2 * i * loops_of_run);
  if (p.tap_count == 0) return x;
  double* const past = states + 2 * p.section_count * loops_of_run;
  set_row(past, newest, x);
  L sum{};
  std::size_t at = newest;
  for (std::size_t k = 0; k < p.tap_count; ++k) {
    sum = fma(broadcast<L>(p.taps[k]), row_of<L>(past, at), sum);
    at = at + 1 == p.tap_count ? 0 : at + 1;
  }
  return sum;
}

template <class L>
[[gnu::always_inline]] inline void move(const L (&s)[4], const L& u, L& q, L& v) {
  q += s[0] * v + s[1] * u;
  v = s[2] * v + s[3] * u;
}

/// As many loops as `group` vectors hold: their recursions overlap in the pipeline.
template <int group, class L>
[[gnu::always_inline]] inline void run_group(const LoopPlan& p, double* rows, std::size_t first,
                                             std::size_t done, std::size_t samples) {
  L q[group], v[group], error[group], sums[group][6], before[group][4], after[group][4];
#pragma GCC unroll 4
  for (int g = 0; g < group; ++g) {
    double* const own = rows + first + static_cast<std::size_t>(g) * lane_count<L>;
    q[g] = row_of<L>(own, LoopRows::q);
    v[g] = row_of<L>(own, LoopRows::v);
    error[g] = row_of<L>(own, LoopRows::error);
    for (std::size_t i = 0; i < 6; ++i) sums[g][i] = row_of<L>(own, LoopRows::sums + i);
    for (std::size_t i = 0; i < 4; ++i) {
      before[g][i] = row_of<L>(p.before + (own - rows), i);
      after[g][i] = row_of<L>(p.after + (own - rows), i);
    }
  }
  const std::size_t torques = p.whole_delay + 2;
  std::size_t newest = done % torques, tap = p.tap_count == 0 ? 0 : p.tap_count - 1 - done % p.tap_count;
  for (std::size_t k = 0; k < samples; ++k) {
    const std::size_t oldest = newest + 1 == torques ? 0 : newest + 1;
    const std::size_t due = oldest + 1 == torques ? 0 : oldest + 1;  // `whole_delay` before the newest
#pragma GCC unroll 4
    for (int g = 0; g < group; ++g) {
      double* const own = rows + first + static_cast<std::size_t>(g) * lane_count<L>;
      double* const past = own + LoopRows::torques * loops_of_run;
      const L reading = q[g] + error[g];
      error[g] = L{};
      L u = -p.kp * reading;
      if (p.kd != 0) u -= p.kd * velocity<L>(p, reading, past + torques * loops_of_run, tap);
      set_row(past, newest, u);
      sums[g][0] += abs(q[g]);
      sums[g][1] += q[g] * q[g];
      sums[g][2] += q[g];
      sums[g][3] += abs(u);
      sums[g][4] += u * u;
      sums[g][5] += u;
      if (p.late) move(before[g], row_of<L>(past, oldest), q[g], v[g]);
      move(after[g], row_of<L>(past, due), q[g], v[g]);
    }
    newest = oldest;
    tap = tap == 0 ? p.tap_count - (p.tap_count > 0) : tap - 1;
  }
#pragma GCC unroll 4
  for (int g = 0; g < group; ++g) {
    double* const own = rows + first + static_cast<std::size_t>(g) * lane_count<L>;
    set_row(own, LoopRows::q, q[g]);
    set_row(own, LoopRows::v, v[g]);
    set_row(own, LoopRows::error, error[g]);
    for (std::size_t i = 0; i < 6; ++i) set_row(own, LoopRows::sums + i, sums[g][i]);
  }
}

template <class L>
void run(const LoopPlan& p, double* rows, std::size_t done, std::size_t samples) {
  in_groups<2, L>(0, loops_of_run,
                  [&]<int group>(std::size_t first) { run_group<group, L>(p, rows, first, done, samples); });
}

}  // namespace
}  // namespace qerr::lanes

namespace qerr {

template <>
const LoopKernels& compiled_kernels<LoopKernels, lanes::compiled_set>() {
  static constexpr LoopKernels kernels{lanes::run<lanes::CompiledLanes>};
  return kernels;
}

}  // namespace qerr
