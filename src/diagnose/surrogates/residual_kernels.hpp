#pragma once

#include <cstddef>
#include <cstdint>

#include "lanes/dispatch.hpp"

// What the kernels of the surrogates take; files that are compiled per instruction set include this, and
// nothing that has code of its own.
//
// Lanes are surrogates: noise and filters remember their past from row to row, and all that is known of a row
// is the same for all surrogates. Numbers of lanes stand in rows, `width` of them:
// a multiple of 8.

namespace qerr {

/// What all surrogates of a record share in a row of it [counts].
struct SurrogateRow {
  enum class Rest : std::int32_t { none, begins, goes_on };
  double place;        ///< of the path in its count; less half a count where the encoder rounds down
  double reference;    ///< from where that count begins
  double chance;       ///< standard deviation of what the model itself leaves to chance
  double level;        ///< where a rest begins: standard deviation of what its position is known to
  Rest rest;           ///< of the joint
  std::int32_t whole;  ///< the count, modulo four
};

/// The noise of a path: normal numbers behind two low-passes (1 - pole)/(1 - pole z^-1).
struct PathNoise {
  double pole;
  double sigma;  ///< before them [counts]
  bool chance;   ///< rows have some
};

/// Where the surrogates stand, a number of each lane.
struct SurrogateLanes {
  std::uint64_t* generator;  ///< of SplitMix64
  double* phase;             ///< from the encoder's zero to the edge of a count [counts]
  double *first, *second;    ///< outputs of the low-passes [counts]
  double* level;             ///< of the rest [counts]
};

/// Sums over rows, a number of each lane.
struct MomentLanes {
  double *sum, *square;
  double *lagged, *last;  ///< of the products of neighbours; and the row before, 0 where there is none
};

/// A filter's section as trapezoidal integrators, solved for its highest derivative (FilterBank):
/// high = in x - k1 s1 - k0 s2, of first order in x - k0 s1.
struct ResidualSection {
  bool second;
  double in, k0, k1, b0, b1, b2;
};

/// Bins of a distribution, over two counts about its middle; what is beyond counts in the outermost ones.
inline constexpr int residual_bins = 64;

struct ResidualKernels {
  std::size_t lanes;
  void (*sines)(const double* angle, std::size_t count, double* sine, double* cosine);
  /// The noise of some rows that nobody looks at.
  void (*draw)(const PathNoise&, std::size_t draws, std::size_t width, const SurrogateLanes&);
  /// What the encoders read: residual [counts], and the reading's count modulo four.
  void (*read)(const PathNoise&, const SurrogateRow*, std::size_t rows, std::size_t width,
               const SurrogateLanes&, double* residual, double* state);
  void (*moments)(const double* in, std::size_t rows, std::size_t width, const MomentLanes&);
  /// Means over each `each` rows.
  void (*means)(const double* in, std::size_t rows, std::size_t each, std::size_t width, double* out);
  /// sums += column' in: a number of the column for each row.
  void (*project)(const double* column, const double* in, std::size_t rows, std::size_t width, double* sums);
  /// Adds the rows to those of their state: sums[4][width], and how many there were.
  void (*by_state)(const double* in, const double* state, std::size_t rows, std::size_t width, double* sums,
                   double* counts);
  /// @param bins  [lane][residual_bins]
  /// @param places  room for the bin of every number
  void (*distribute)(const double* in, double middle, std::size_t rows, std::size_t width,
                     std::int32_t* places, std::uint32_t* bins);
  /// Rows through a section. @param out  may be `in`  @param state  [2][width]
  void (*section)(const ResidualSection&, const double* in, std::size_t rows, std::size_t width,
                  double* state, double* out);
  /// @param in  the row of the first output; those before it stand before it
  void (*taps)(const double* taps, std::size_t count, const double* in, std::size_t rows, std::size_t width,
               double* out);
};

}  // namespace qerr
