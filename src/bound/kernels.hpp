#pragma once

#include <cstddef>
#include <cstdint>

#include "kinematics/kernels.hpp"
#include "lanes/select_kernels.hpp"

namespace qerr {

/// Histogram bins: the leading bits of a double (exponent and 10 bits of the mantissa), so that a bin's width
/// is about 2^-10 of the value. Without containers, for the batched kernels.
inline constexpr int bin_shift = 42;
inline constexpr std::size_t bin_count = std::size_t{1} << 16;  ///< 64 octaves

/// The bin of a value >= 0.
inline std::int32_t leading_bits(double value) {
  return static_cast<std::int32_t>(__builtin_bit_cast(std::int64_t, value) >> bin_shift);
}

/// Bins of a figure that are counted individually, by leading bits: [begin, end) and [top, infinity). Values
/// below `begin` and values in [end, top) are only counted in total.
struct CountedBins {
  static constexpr std::int32_t first = -(1 << (63 - bin_shift));  ///< below all doubles
  std::int32_t begin = first, end = first, top = first;            ///< default: all bins

  bool operator()(std::int32_t bin) const { return (bin >= begin && bin < end) || bin >= top; }
};

/// Maxima within this factor are equal up to rounding; the first configuration is reported.
inline constexpr double same_maximum = 1 + 1e-13;

/// Sum, minimum and maximum of one figure over some configurations. Without containers, and aligned, for the
/// batched kernels.
struct alignas(64) Tally {
  static constexpr double infinite = __builtin_inf();
  double sum[8] = {};  ///< [lane], as `min`
  double min[8] = {infinite, infinite, infinite, infinite, infinite, infinite, infinite, infinite};
  double max = -1;  ///< or the value that it had to exceed
  static constexpr std::uint64_t none = ~std::uint64_t{0};
  std::uint64_t at_max = none;  ///< index of the first configuration with it
};

/// Layout of the figures of a batch: figure i of configuration c at i * batch_size + c. Each member is the
/// index of the first coordinate's figure, the others follow. Figures that were not requested take no space.
struct FigureLayout {
  std::size_t coordinates = 0;  ///< all_signals of the model
  std::size_t worst_case = 0, sigma = 0, rigorous = 0;
  std::size_t filtered_worst = 0, filtered_sigma = 0, in_motion = 0;  ///< [filter][coordinate]
  std::size_t trace = 0;       ///< one: variance of the position, of all coordinates if there is no position
  std::size_t covariance = 0;  ///< [row][column <= row]
  std::size_t count = 0;       ///< of all figures
};

/// Layout of the sums over configurations. From `arms` on they are maxima.
struct SumLayout {
  std::size_t covariance = 0;                                  ///< [row][column <= row]
  std::size_t filtered = 0;                                    ///< the same behind every filter
  std::size_t variance_parts = 0, share = 0, worst_share = 0;  ///< [coordinate][encoder]
  std::size_t quantization_parts = 0;                          ///< [coordinate][encoder]; only beside sources
  std::size_t arms = 0;   ///< [encoder]: largest |dp/dx| of one axis [m/rad or 1]
  std::size_t pitch = 0;  ///< one: 1 - cos(pitch)
  std::size_t count = 0;
};

// Included by kernel sources: without Eigen and containers (see kinematics/kernels.hpp).

/// Half width over sigma of a uniform error: sqrt(3).
inline constexpr double half_width_of_sigma = 0x1.bb67ae8584caap+0;

/// A multiple of a moving joint's column of the Jacobian.
struct JointWeight {
  std::size_t joint;
  double weight;
};

/// One independent error, of an encoder or of an error source, in units of its scale s. Its spread is the
/// change of the coordinates by an error of s.
struct ErrorPart {
  const JointWeight *begin = nullptr, *end = nullptr;  ///< columns of its spread, times s
  std::size_t link = 0;  ///< displaced origin: 1 + index of the previous moving joint; 0: none, or the base
  double direction[3] = {};  ///< displaced origin: in the folded frame of the link (0: base), times s
  double sigma = 0, half_width = 0, mean = 0;  ///< divided by s
  double width = 0;                            ///< |mean| + half width, divided by s
  std::size_t owner = 0;                       ///< index of the encoder it is attributed to
  bool source = false;                         ///< an error source, not quantization
};

/// Input of the batched kernel, built from a model by PlannedError (batched_error.hpp). At most nine
/// coordinates.
struct ErrorPlan {
  FoldedPath chain;
  const double* column_scale;  ///< [moving joint]; null: 1, the scale is the length of the chain's axes
  bool direct;                 ///< the spread of part k is the scaled column k
  bool plain;  ///< all parts are encoders that round to nearest: sigma 1, half width sqrt(3), mean 0
  std::size_t parts, encoders, coordinates, filters;
  std::size_t moving_parts;  ///< the first ones; the others only rotate the tip
  const ErrorPart* part;
  const int* coordinate;  ///< values of qerr::Coordinate
  bool positions_first;   ///< the coordinates are x y z or x y z rx ry rz
  bool any_euler, any_position, tip_frame;
  bool keep_covariance;  ///< covariances are figures of every configuration
  bool shares, rigorous;
  bool quantization_parts;  ///< sum the encoders' contributions without those of sources, too
  const double* arm;        ///< [encoder]: 1/s, for its largest |dp/dx|
  /// Position: rho = remainder + sum_k per_column[k] |linear column k|; rotation: min(linear +
  /// angle_remainder, angle).
  double remainder, angle_remainder, angle;
  const double* per_column;
  bool filtered_worst, filtered_sigma;
  const double *l1, *dc_gain;    ///< [filter]
  const double* ratio_squares;   ///< [filter][part]: variance behind the filter over s^2
  const double* motion_squares;  ///< [filter][part]: the same in motion; negative: unknown
  FigureLayout figures;
  SumLayout sums;
};

/// Bins of one figure, appended by a kernel.
struct alignas(64) BinList {
  std::int32_t below[16] = {};  ///< [lane]: number of values below the counted bins
  CountedBins counted;
  std::int32_t* next = nullptr;  ///< end of the list; a kernel writes up to 16 numbers beyond
};

struct Statistic;

/// A figure of a signal as a function of the columns A of its errors (error_columns.hpp):
///   min(sum |A_k| weight_k + |sum A_k mean_k| + added, most), or sqrt(sum A_k^2 weight_k + added).
struct ColumnForm {
  const double* weights = nullptr;  ///< [column], not negative
  std::size_t columns = 0;          ///< the first ones
  double added = 0;
  Statistic* statistic = nullptr;  ///< receives the result, without `at_max`
  bool squared = false;
  const double* means = nullptr;  ///< [column]; null: 0
  double most = __builtin_inf();
};

struct BoundKernels {
  std::size_t lanes;
  /// Doubles of scratch memory that `errors` needs.
  std::size_t (*scratch)(const ErrorPlan&);
  /// Computes the figures of a batch and adds to the sums.
  void (*errors)(const ErrorPlan&, const double* q, double* figures, double* sums, double* scratch);
  /// Adds a batch of every figure to the tallies and, unless null, to the lists of bins.
  void (*tally)(std::size_t count, const double* figures, std::uint64_t first, Tally*, BinList*);
  /// Values of forms at a batch; those side by side that have one shape take less time.
  /// @param columns  [column]: its numbers of the batch
  /// @param rooted   false: squared forms without the square root
  /// @param figures  receives [form][batch_size]
  void (*forms)(const double* const* columns, std::size_t count, const ColumnForm*, bool rooted,
                double* figures);
  /// Appends those of a batch that are larger.
  /// @param to  end of the list; up to batch_size numbers are written
  /// @returns the new end
  double* (*append_larger)(const double* values, double least, double* to);
  /// The largest length of m + sum s_i g_i over all signs s_i = +-1, of the first `count` configurations of a
  /// batch: the farthest corner of a box that is mapped linearly to space.
  ///
  /// The farthest point of a zonotope is a vertex. Up to 12 generators all signs are tried. Beyond, the
  /// vertices are enumerated: each lies at an edge along some g_i of a face with the normal d = g_i x g_j,
  /// where the sign of g_k is that of its component along d; in the face, along d x g_i; along the edge,
  /// along g_i. That is O(n^3) for n generators. A vertex has edges in two directions, so that i < j will do.
  /// @param mean     [axis][batch_size]
  /// @param g        [generator][axis][batch_size]
  /// @param count    a multiple of `lanes`
  /// @param scratch  as many numbers as a vector of each generator has lanes
  void (*largest_corners)(std::size_t generators, const double* mean, const double* g, std::size_t count,
                          double* to, double* scratch);
};

}  // namespace qerr
