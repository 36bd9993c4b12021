#pragma once

#include <utility>

#include "lane_pose_error.hpp"
#include "qerr/core/batch.hpp"

namespace qerr::lanes {
namespace {

/// What the kernel works in: chains and channels may be of any number.
template <class L>
struct ErrorRoom {
  SineCosine<L>* moved;  // [moving joint]
  JointRoom<L>* joints;  // [moving joint]
  L (*mixed)[6];         // [column]: those that are not a joint's own
  L* channels;           // [width]
};

inline std::size_t joints_of(const ErrorPlan& p) {
  return p.chain.count > p.built.count ? p.chain.count : p.built.count;
}

template <class L>
std::size_t errors_room(const ErrorPlan& p) {
  return joints_of(p) * room_per_joint<L> + ((p.encoders + p.sources) * 6 + p.width) * lane_count<L>;
}

template <class L>
ErrorRoom<L> furnished(const ErrorPlan& p, double* room) {
  ErrorRoom<L> r;
  r.moved = reinterpret_cast<SineCosine<L>*>(room);
  r.joints = reinterpret_cast<JointRoom<L>*>(r.moved + joints_of(p));
  r.mixed = reinterpret_cast<L(*)[6]>(r.joints + joints_of(p));
  r.channels = reinterpret_cast<L*>(r.mixed + p.encoders + p.sources);
  return r;
}

/// One step of turning a square of lanes: of `a` and `b`, rows `distance` apart, the halves that must cross.
template <std::size_t distance, class L, std::size_t... i>
[[gnu::always_inline]] inline void cross_over(L& a, L& b, std::index_sequence<i...>) {
  constexpr auto n = sizeof...(i);
  const L first = __builtin_shufflevector(a, b, (i & distance ? n + i - distance : i)...);
  b = __builtin_shufflevector(a, b, (i & distance ? n + i : i + distance)...);
  a = first;
}

template <std::size_t distance, class L>
[[gnu::always_inline]] inline void cross_rows(L* rows) {
  constexpr auto n = lane_count<L>;
#pragma GCC unroll 8
  for (std::size_t row = 0; row < n; ++row)
    if (!(row & distance))
      cross_over<distance>(rows[row], rows[row + distance], std::make_index_sequence<n>{});
  if constexpr (distance > 1) cross_rows<distance / 2>(rows);
}

/// Channels of these instants into their rows.
template <class L>
[[gnu::always_inline]] inline void into_rows(const L* channels, std::size_t width, double* rows) {
  constexpr auto n = lane_count<L>;
  for (std::size_t c = 0; c < width; c += n) {
    L square[n];
#pragma GCC unroll 8
    for (std::size_t i = 0; i < n; ++i) square[i] = channels[c + i];
    cross_rows<n / 2>(square);
#pragma GCC unroll 8
    for (std::size_t i = 0; i < n; ++i) store(rows + i * width + c, square[i]);
  }
}

/// Columns that are sums of several joints', or another factor of one; of displaced origins their shift.
template <class L>
[[gnu::always_inline]] inline void mix_columns(const ErrorPlan& p, const ErrorRoom<L>& room) {
  for (std::size_t e = 0; e < p.encoders + p.sources; ++e) {
    const ErrorColumn& column = p.columns[e];
    if (column.direct || column.origin) continue;
    L sum[6] = {};
    for (std::size_t i = column.first; i < column.first + column.parts; ++i) {
      const L(&joint)[6] = room.joints[p.parts[i].joint].column;
#pragma GCC unroll 6
      for (int row = 0; row < 6; ++row) sum[row] = fma(p.parts[i].factor, joint[row], sum[row]);
    }
#pragma GCC unroll 6
    for (int row = 0; row < 6; ++row) room.mixed[e][row] = sum[row];
  }
}

/// Shifts of the origins that stand behind joint `link - 1`.
template <class L>
[[gnu::always_inline]] inline void shift_origins(const ErrorPlan& p, std::size_t link, const Frame<L>& f,
                                                 const ErrorRoom<L>& room) {
  for (std::size_t s = p.encoders; s < p.encoders + p.sources; ++s) {
    const ErrorColumn& source = p.columns[s];
    if (!source.origin || source.link != link) continue;
    const double* d = source.direction;
#pragma GCC unroll 3
    for (int i = 0; i < 3; ++i) {
      room.mixed[s][i] = fma(d[2], f.z[i], fma(d[1], f.y[i], d[0] * f.x[i]));
      room.mixed[s][3 + i] = L{};
    }
  }
}

template <class L>
[[gnu::always_inline]] inline Frame<L> base_frame() {
  Frame<L> f{};
  f.x[0] = f.y[1] = f.z[2] = broadcast<L>(1);
  return f;
}

/// The Jacobian's part of the errors at the instants from `i`: linear parts, and bounds along the path.
template <class L>
[[gnu::always_inline]] inline void linear_errors(const ErrorPlan& p, const ErrorBatch& b, std::size_t i,
                                                 const EulerRates<L>& rates, const ErrorRoom<L>& room) {
  const std::size_t m = p.coordinates;
  L of_position = broadcast<L>(p.remainder);
  if (p.positions)
    for (std::size_t k = 0; k < p.chain.count; ++k) {
      const L(&column)[6] = room.joints[k].column;
      const L norm2 = fma(column[2], column[2], fma(column[1], column[1], column[0] * column[0]));
      if (p.per_column[k] != 0) of_position = fma(p.per_column[k], sqrt(norm2), of_position);
    }
  for (std::size_t c = 0; c < m; ++c) {
    const int row = p.rows[c];
    const bool angle = row >= 6;
    const auto entry = [&](std::size_t e) [[gnu::always_inline]] {
      const ErrorColumn& column = p.columns[e];
      const L(&of)[6] = column.direct ? room.joints[p.parts[column.first].joint].column : room.mixed[e];
      if (!angle) return of[row];
      const L(&rate)[3] = rates.of[row - 6];
      return fma(rate[2], of[5], fma(rate[1], of[4], rate[0] * of[3]));
    };
    L linear{}, variance{}, sum{}, mean{};
    for (std::size_t e = 0; e < p.encoders; ++e) {
      L weighted = entry(e);
      sum += abs(weighted);
      mean = fma(p.columns[e].mean, weighted, mean);
      if (angle && row != 7) weighted = rates.unbounded ? broadcast<L>(__builtin_inf()) : weighted;
      const std::size_t at = e * batch_size + i;
      const L miss = (load<L>(b.measured + at) - load<L>(b.encoder + at)) * p.per_resolution[e];
      const L part = weighted * miss, square = weighted * weighted;
      room.channels[m * (2 + e) + c] = part;
      store(b.squares + (e * m + c) * batch_size + i, square);
      linear += part;
      variance += square;
    }
    room.channels[m + c] = linear;
    store(b.variance + c * batch_size + i, variance);
    L half = 0.5 * sum;
    for (std::size_t s = p.encoders; s < p.encoders + p.sources; ++s) {
      const L column = entry(s);
      mean = fma(p.columns[s].mean, column, mean);
      half = fma(p.columns[s].half_width, abs(column), half);
    }
    if (p.biased) room.channels[m * (2 + p.encoders) + c] = mean;
    if (angle) continue;
    const L worst = half + abs(mean);
    const L bound = row < 3 ? worst + of_position : min(worst + p.rotation, broadcast<L>(p.rotation_angle));
    const std::size_t at = c * lane_count<L>;
    store(b.rigorous + at, max(load<L>(b.rigorous + at), bound));
    const L deviation = bound - abs(mean) + abs(mean - p.center_mean[c]);
    store(b.deviation + at, max(load<L>(b.deviation + at), deviation));
  }
}

/// Errors of a batch of instants: of the pose (tip_error), and what the Jacobian makes of those of the
/// encoders (operational_error).
template <class L>
void errors(const ErrorPlan& p, const ErrorBatch& b) {
  const ErrorRoom<L> room = furnished<L>(p, b.room);
  const bool turned = p.rotations || p.angles;
  shift_origins(p, 0, base_frame<L>(), room);
  for (std::size_t c = p.coordinates; c < p.width; ++c) room.channels[c] = L{};
  for (std::size_t i = 0; i < batch_size; i += lane_count<L>) {
    const auto pass_by = [](std::size_t, const Frame<L>&) {};
    const Frame<L> estimate = walk<L>(p.chain, b.estimate + i, batch_size, room.moved, pass_by, pass_by);
    const Frame<L> modelled = columns<L>(p.chain, p.scale, b.joint + i, batch_size, room.moved, room.joints,
                                         [&](std::size_t k, const Frame<L>& f) {
                                           if (p.sources > 0) shift_origins(p, k + 1, f, room);
                                         });
    mix_columns(p, room);
    const Frame<L> truth =
        p.as_modelled ? modelled
                      : walk<L>(p.built, b.built_joint + i, batch_size, room.moved, pass_by, pass_by);
    L error[9] = {};
#pragma GCC unroll 3
    for (int k = 0; k < 3; ++k) error[k] = estimate.o[k] - truth.o[k];
    EulerRates<L> rates;
    if (turned) {
      const Axes<L> seen = axes_of(estimate, p.chain.tip_axes), real = axes_of(truth, p.built.tip_axes);
      if (p.rotations) {
        L vector[3];
        rotation_vector(seen, real, vector);
#pragma GCC unroll 3
        for (int k = 0; k < 3; ++k) error[3 + k] = vector[k];
      }
      if (p.angles) {
        L angles[3];
        roll_pitch_yaw(seen, real, angles);
#pragma GCC unroll 3
        for (int k = 0; k < 3; ++k) error[6 + k] = angles[k];
        rates = euler_rates(axes_of(modelled, p.chain.tip_axes));
      }
    }
    for (std::size_t c = 0; c < p.coordinates; ++c) room.channels[c] = error[p.rows[c]];
    linear_errors(p, b, i, rates, room);
    into_rows(room.channels, p.width, b.rows + i * p.width);
  }
}

}  // namespace
}  // namespace qerr::lanes
