#pragma once

#include <cstddef>
#include <cstdint>

#include "bound/bins.hpp"
#include "bound/figure_layout.hpp"
#include "bound/tally.hpp"
#include "kinematics/folded_path.hpp"
#include "lanes/dispatch.hpp"

namespace qerr {

// As folded_path.hpp: without Eigen and containers, for files that are compiled per instruction set.

/// Half width over sigma of a uniform error: sqrt(3).
inline constexpr double half_width_of_sigma = 0x1.bb67ae8584caap+0;

/// A column of the Jacobian of a moving joint, as a part of an error takes it.
struct JointWeight {
  std::size_t joint;
  double weight;
};

/// One independent error: of an encoder, or of a source beside it. Its size is a common scale s; `spread` is
/// what the coordinates move by when it is s.
struct ErrorPart {
  const JointWeight *begin = nullptr, *end = nullptr;  ///< columns it moves by, times s
  std::size_t link = 0;      ///< of a displaced origin: behind which moving joint, plus 1; else 0
  double direction[3] = {};  ///< of that, in the folded frame there (0: the base's), times s
  double sigma = 0, half_width = 0, mean = 0;  ///< over s
  double width = 0;                            ///< over s: what it counts for among the worst cases
  std::size_t owner = 0;                       ///< index of the encoder it is counted with
  bool source = false;                         ///< beside the quantization
};

/// What the batched kernel works by (error_plan.hpp makes it from a model). At most nine coordinates.
struct ErrorPlan {
  FoldedPath chain;
  const double* column_scale;  ///< of every moving joint; null: the chain's axes have it
  bool direct;                 ///< part k moves by column k alone, which has its scale already
  bool plain;  ///< parts are encoders that round to nearest: sigma 1, half width sqrt(3), mean 0
  std::size_t parts, encoders, coordinates, filters;
  std::size_t moving_parts;  ///< the first ones, which move the tip; those behind only turn it
  const ErrorPart* part;
  const int* coordinate;  ///< values of qerr::Coordinate
  bool positions_first;   ///< the coordinates begin with x y z, and are these or these and rx ry rz
  bool any_euler, any_position;
  bool keep_covariance;  ///< of every configuration, as figures
  bool shares, rigorous;
  bool columns_again;  ///< whether linear columns are looked at after they have been summed
  const double* arm;   ///< of every encoder: 1/s, for its largest |dp/dx|
  /// rho = remainder + sum_k reach[k] |linear column k|; an angle's: linear + angle_remainder, at most angle.
  double remainder, angle_remainder, angle;
  const double* reach;
  bool filtered_worst, filtered_sigma;
  const double *l1, *dc_gain;    ///< [filter]
  const double* gain_squares;    ///< [filter][part]: of its variance behind the filter
  const double* motion_squares;  ///< [filter][part]: the same with the encoders' speeds; negative: unknown
  FigureLayout figures;
  SumLayout sums;
};

/// The bins of one figure, as a kernel comes across them.
struct alignas(64) BinList {
  std::int32_t below[16] = {};  ///< by lane: how many lie below the counted ones
  CountedBins counted;
  std::int32_t* next =
      nullptr;  ///< where the next counted ones go; up to 16 numbers from here are written to
};

struct BoundKernels {
  std::size_t lanes;
  /// Numbers of room that `errors` works in.
  std::size_t (*room)(const ErrorPlan&);
  /// Figures of 64 configurations, and their sums added to those before.
  void (*errors)(const ErrorPlan&, const double* q, double* figures, double* sums, double* room);
  /// 64 values of every figure into their tallies and, unless it is null, the lists of their bins.
  void (*tally)(std::size_t count, const double* figures, std::uint64_t first, Tally*, BinList*);
};

}  // namespace qerr
