#pragma once

#include <utility>

#include "lane_pose_error.hpp"
#include "qerr/core/batch.hpp"
#include "qerr/kinematics/euler_rates.hpp"

namespace qerr::lanes {
namespace {

/// What the kernel works in: chains and channels may be of any number.
template <class L>
struct ErrorRoom {
  SineCosine<L>* moved;  // [moving joint]
  JointRoom<L>* joints;  // [moving joint]
  L (*mixed)[6];         // [column]: those that are not a joint's own
  L* channels;           // [width]
  L* missed;             // [encoder]: its error over its resolution
  L* squares;            // [squares_width]
  L* worst;              // [coordinate][2]: linear bound, and that of the difference from the mean
  L* pose;               // [9]: error of the pose
};

inline std::size_t joints_of(const PathErrorPlan& p) {
  return p.chain.count > p.built.count ? p.chain.count : p.built.count;
}

template <class L>
std::size_t errors_room(const PathErrorPlan& p) {
  return joints_of(p) * room_per_joint<L> +
         ((p.encoders + p.sources) * 6 + p.width + p.squares_width + p.encoders + 2 * p.coordinates + 9) *
             lane_count<L>;
}

template <class L>
ErrorRoom<L> furnished(const PathErrorPlan& p, double* room) {
  ErrorRoom<L> r;
  r.moved = reinterpret_cast<SineCosine<L>*>(room);
  r.joints = reinterpret_cast<JointRoom<L>*>(r.moved + joints_of(p));
  r.mixed = reinterpret_cast<L(*)[6]>(r.joints + joints_of(p));
  r.channels = reinterpret_cast<L*>(r.mixed + p.encoders + p.sources);
  r.missed = r.channels + p.width;
  r.squares = r.missed + p.encoders;
  r.worst = r.squares + p.squares_width;
  r.pose = r.worst + 2 * p.coordinates;
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

/// Lanes and channels of a square change places.
template <class L>
[[gnu::always_inline]] inline void turn_square(const L* channels, L (&square)[lane_count<L>]) {
  constexpr auto n = lane_count<L>;
#pragma GCC unroll 8
  for (std::size_t i = 0; i < n; ++i) square[i] = channels[i];
  cross_rows<n / 2>(square);
}

/// Channels of these instants into their rows.
template <class L>
[[gnu::always_inline]] inline void into_rows(const L* channels, std::size_t width, double* rows) {
  constexpr auto n = lane_count<L>;
  for (std::size_t c = 0; c < width; c += n) {
    L square[n];
    turn_square(channels + c, square);
#pragma GCC unroll 8
    for (std::size_t i = 0; i < n; ++i) store(rows + i * width + c, square[i]);
  }
}

/// The sum over the lanes of every channel.
template <class L>
[[gnu::always_inline]] inline void add_lanes(const L* channels, std::size_t width, double* sums) {
  constexpr auto n = lane_count<L>;
  for (std::size_t c = 0; c < width; c += n) {
    L square[n];
    turn_square(channels + c, square);
#pragma GCC unroll 8
    for (std::size_t i = 1; i < n; ++i) square[0] += square[i];
    store(sums + c, square[0]);
  }
}

/// Columns that are sums of several joints', or another factor of one; of displaced origins their shift.
template <class L>
[[gnu::always_inline]] inline void mix_columns(const PathErrorPlan& p, const ErrorRoom<L>& room) {
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
[[gnu::always_inline]] inline void shift_origins(const PathErrorPlan& p, std::size_t link, const Frame<L>& f,
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

/// Takes the bounds of these instants into the largest ones.
template <class L>
[[gnu::noinline]] void raise_bounds(const PathErrorPlan& p, const PathErrorBatch& b,
                                    const ErrorRoom<L>& room) {
  const L of_position = p.remainder + weighted_arms(p.chain, p.per_column, room.joints);
  for (std::size_t c = 0; c < p.coordinates; ++c) {
    if (p.rows[c] >= 6) continue;
    const L worst = room.worst[2 * c], less = worst - room.worst[2 * c + 1];
    const L bound =
        p.rows[c] < 3 ? worst + of_position : min(worst + p.rotation, broadcast<L>(p.rotation_angle));
    double* const rigorous = b.rigorous + c * lane_count<L>;
    double* const deviation = b.deviation + c * lane_count<L>;
    store(rigorous, max(load<L>(rigorous), bound));
    store(deviation, max(load<L>(deviation), bound - less));
  }
}

/// One coordinate at some instants: its rate along any column, and what is unbounded of it.
template <class L>
struct Row {
  int of;  ///< of the Jacobian; of Euler angles none
  const L* rate;
  const Bits<L>* unbounded;

  [[gnu::always_inline]] L along(const L* column) const {
    if (!rate) return column[of];
    return fma(rate[2], column[5], fma(rate[1], column[4], rate[0] * column[3]));
  }
};

template <class L>
[[gnu::always_inline]] inline const L* column_of(const PathErrorPlan& p, const ErrorRoom<L>& room,
                                                 std::size_t e) {
  const ErrorColumn& column = p.columns[e];
  return column.direct ? room.joints[p.parts[column.first].joint].column : room.mixed[e];
}

/// Parts of all encoders in one coordinate, their sum and the sum of their sizes.
///
/// @tparam summed  squares are summed up over the batch, else kept of every instant
template <bool summed, class L>
[[gnu::always_inline]] inline L encoder_parts(const PathErrorPlan& p, std::size_t c, const Row<L>& row,
                                              const ErrorRoom<L>& room) {
  const std::size_t m = p.coordinates;
  L linear{}, sizes{};
  for (std::size_t e = 0; e < p.encoders; ++e) {
    L weighted = row.along(column_of(p, room, e));
    sizes += abs(weighted);
    if (row.unbounded) weighted = *row.unbounded ? broadcast<L>(__builtin_inf()) : weighted;
    const L part = weighted * room.missed[e], square = weighted * weighted;
    room.channels[m * (2 + e) + c] = part;
    linear += part;
    L& squares = room.squares[e * m + c];
    squares = summed ? squares + square : square;
  }
  room.channels[m + c] = linear;
  return sizes;
}

/// The Jacobian's part of the errors at the instants from `i`, and bounds along the path.
template <bool summed, class L>
[[gnu::always_inline]] inline void linear_errors(const PathErrorPlan& p, const PathErrorBatch& b,
                                                 std::size_t i, const EulerRates<L>& rates,
                                                 const ErrorRoom<L>& room) {
  const std::size_t m = p.coordinates;
  for (std::size_t e = 0; e < p.encoders; ++e) {
    const std::size_t at = e * batch_size + i;
    room.missed[e] = (load<L>(b.measured + at) - load<L>(b.encoder + at)) * p.per_resolution[e];
  }
  Bits<L> higher{};
  for (std::size_t c = 0; c < m; ++c) {
    const int of = p.rows[c];
    const bool angle = of >= 6;
    const Row<L> row{of, angle ? rates.of[of - 6] : nullptr, angle && of != 7 ? &rates.unbounded : nullptr};
    L worst = 0.5 * encoder_parts<summed>(p, c, row, room), mean{};
    if (p.biased || p.sources > 0) {
      for (std::size_t e = 0; e < p.encoders; ++e)
        mean = fma(p.columns[e].mean, row.along(column_of(p, room, e)), mean);
      for (std::size_t s = p.encoders; s < p.encoders + p.sources; ++s) {
        const L along = row.along(column_of(p, room, s));
        mean = fma(p.columns[s].mean, along, mean);
        worst = fma(p.columns[s].half_width, abs(along), worst);
      }
      worst += abs(mean);
    }
    if (p.biased) room.channels[m * (2 + p.encoders) + c] = mean;
    if (angle) continue;
    const L deviation = worst - abs(mean) + abs(mean - p.center_mean[c]);
    room.worst[2 * c] = worst;
    room.worst[2 * c + 1] = deviation;
    const double most = of < 3 ? p.largest_remainder : p.rotation;
    higher |= (worst + most > load<L>(b.rigorous + c * lane_count<L>)) |
              (deviation + most > load<L>(b.deviation + c * lane_count<L>));
  }
  // Records are rare, and the roots of the remainder dear.
  if (any<L>(higher)) raise_bounds(p, b, room);
}

/// Estimate minus truth of the pose: positions; the rotation vector of R_hat R^T; Euler angles.
template <class L>
[[gnu::always_inline]] inline void pose_error(const PathErrorPlan& p, const Frame<L>& estimate,
                                              const Frame<L>& truth, L* error) {
#pragma GCC unroll 3
  for (int k = 0; k < 3; ++k) error[k] = estimate.o[k] - truth.o[k];
  if (!p.rotations && !p.angles) return;
  Axes<L> seen, real;
  if (p.as_modelled && !p.angles) {
    // The constant turn behind the last joint drops out of R_hat R^T.
    seen = axes_of(estimate);
    real = axes_of(truth);
  } else {
    seen = axes_of(estimate, p.chain.tip_axes);
    real = axes_of(truth, p.built.tip_axes);
  }
  L three[3];
  if (p.rotations) {
    rotation_vector(seen, real, three);
#pragma GCC unroll 3
    for (int k = 0; k < 3; ++k) error[3 + k] = three[k];
  }
  if (p.angles) {
    roll_pitch_yaw(seen, real, three);
#pragma GCC unroll 3
    for (int k = 0; k < 3; ++k) error[6 + k] = three[k];
  }
}

/// Errors of a batch of instants: of the pose, and what the Jacobian makes of those of the encoders
/// (operational_error).
template <bool summed, class L>
void errors_of(const PathErrorPlan& p, const PathErrorBatch& b) {
  const ErrorRoom<L> room = furnished<L>(p, b.room);
  shift_origins(p, 0, base_frame<L>(), room);
  for (std::size_t c = p.coordinates; c < p.width; ++c) room.channels[c] = L{};
  for (std::size_t k = 0; k < p.squares_width; ++k) room.squares[k] = L{};
  EulerRates<L> rates;
  begin_columns(p.chain, p.scale, room.joints);
  for (std::size_t i = 0; i < batch_size; i += lane_count<L>) {
    const Frame<L> estimate = walk<L>(p.chain, b.estimate + i, batch_size, room.moved, PassBy{}, PassBy{});
    const Frame<L> modelled = columns<L>(
        p.chain, p.scale, b.joint + i, batch_size, room.moved, room.joints,
        [&](std::size_t k, const Frame<L>& f) {
          if (p.sources > 0) shift_origins(p, k + 1, f, room);
        },
        KeepColumns<L>{room.joints});
    if (p.mixed) mix_columns(p, room);
    if (p.as_modelled)
      pose_error(p, estimate, modelled, room.pose);
    else
      pose_error(p, estimate, walk<L>(p.built, b.built_joint + i, batch_size, room.moved, PassBy{}, PassBy{}),
                 room.pose);
    if (p.angles) rates = euler_rates(axes_of(modelled, p.chain.tip_axes).x);
    for (std::size_t c = 0; c < p.coordinates; ++c) room.channels[c] = room.pose[p.rows[c]];
    linear_errors<summed>(p, b, i, rates, room);
    into_rows(room.channels, p.width, b.rows + i * p.width);
    if (!summed) into_rows(room.squares, p.squares_width, b.squares + i * p.squares_width);
  }
  if (summed) add_lanes(room.squares, p.squares_width, b.squares);
}

template <class L>
void errors(const PathErrorPlan& p, const PathErrorBatch& b) {
  b.summed ? errors_of<true, L>(p, b) : errors_of<false, L>(p, b);
}

}  // namespace
}  // namespace qerr::lanes
