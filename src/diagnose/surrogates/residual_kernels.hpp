#pragma once

#include <cstddef>
#include <cstdint>

#include "lanes/select_kernels.hpp"

// Interface of the kernels of the surrogates. Files that are compiled per instruction set include this, and
// nothing that contains code of its own.
//
// A lane is one surrogate: noise and filters depend on the previous rows, while the data of a row are the
// same for all surrogates. Arrays are [row][lane], with `width` lanes, a multiple of 8.

namespace qerr {

/// Data of one row that are common to all surrogates of a record [counts].
struct SurrogateRow {
  enum class Standstill : std::int32_t { none, begins, continues };
  double offset;            ///< of the path from the edge of its count; minus 1/2 if the encoder rounds down
  double reference;         ///< from the same edge
  double random_sigma;      ///< standard deviation of the model's random effects
  double standstill_sigma;  ///< where a standstill begins: standard deviation of its mean position
  Standstill standstill;    ///< of the joint
  std::int32_t count;       ///< of the path, modulo four
};

/// Noise of a path: normal numbers after two low-pass filters (1 - pole)/(1 - pole z^-1).
struct PathNoise {
  double pole;
  double sigma;         ///< before the filters [counts]
  bool random_effects;  ///< some rows have a random_sigma
};

/// State of the surrogates, one number per lane.
struct SurrogateLanes {
  std::uint64_t* generator;  ///< of SplitMix64
  double* phase;             ///< from the encoder's zero to the edge of a count [counts]
  double *first, *second;    ///< outputs of the low-pass filters [counts]
  double* standstill;        ///< error of the present standstill's position [counts]
};

/// Sums over rows, one number per lane.
struct MomentLanes {
  double *sum, *square;
  double *lagged, *last;  ///< sum of the products of neighbours; the previous row, 0 before the first
};

/// Bins of a histogram over two counts about its centre; the outermost bins include the values beyond.
inline constexpr int residual_bins = 64;

struct ResidualKernels {
  std::size_t lanes;
  void (*sines)(const double* angle, std::size_t count, double* sine, double* cosine);
  /// Advances the noise by some rows.
  void (*draw)(const PathNoise&, std::size_t draws, std::size_t width, const SurrogateLanes&);
  /// Readings of the encoders: residual [counts], and count modulo four.
  void (*read)(const PathNoise&, const SurrogateRow*, std::size_t rows, std::size_t width,
               const SurrogateLanes&, double* residual, double* state);
  void (*moments)(const double* in, std::size_t rows, std::size_t width, const MomentLanes&);
  /// Means over groups of `each` rows.
  void (*means)(const double* in, std::size_t rows, std::size_t each, std::size_t width, double* out);
  /// sums += column^T in.
  void (*project)(const double* column, const double* in, std::size_t rows, std::size_t width, double* sums);
  /// Adds the rows to the sums of their states, sums[4][width], and counts them.
  void (*by_state)(const double* in, const double* state, std::size_t rows, std::size_t width, double* sums,
                   double* counts);
  /// @param bins  [lane][residual_bins]
  /// @param places  scratch memory, one number per value
  void (*distribute)(const double* in, double middle, std::size_t rows, std::size_t width,
                     std::int32_t* places, std::uint32_t* bins);
};

}  // namespace qerr
