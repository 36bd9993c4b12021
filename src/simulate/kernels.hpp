#pragma once

#include <cstddef>

#include "kinematics/folded_path.hpp"
#include "lanes/dispatch.hpp"

// What the kernels of the simulation take; files that are compiled per instruction set include this (see
// folded_path.hpp for what they must not).
//
// Lanes are instants where nothing is remembered from sample to sample (motion, quantizers, kinematics), and
// channels where something is (filters). Runs would do for both, but most simulations are a single run.

namespace qerr {

/// amplitude sin(rate t + phase).
struct Oscillation {
  double amplitude, rate, phase;
};

/// center + velocity t + oscillations.
struct SinusoidPath {
  double center, velocity;
  const Oscillation* oscillations;
  std::size_t count;
};

/// An encoder's counts: floor(position/resolution + 1/2), or floor(position/resolution).
struct Quantizer {
  double resolution;
  bool down;
};

/// One joint's part in a column: a factor of the joint's column as `PathErrorPlan::scale` leaves it.
struct ColumnPart {
  std::size_t joint;
  double factor;
};

/// How the tip moves with an error: first of all encoders, then of what else errs.
struct ErrorColumn {
  std::size_t first, parts;  ///< of its ColumnParts; a single one of factor 1 is the joint's own column
  bool direct;
  bool origin;       ///< a displaced origin of a joint: `direction` in the axes behind joint `link - 1`, or
  std::size_t link;  ///< of link 0 in those of the base
  double direction[3];
  double mean, half_width;  ///< of an encoder in resolutions
};

/// What of the error along the path does not change from instant to instant.
struct PathErrorPlan {
  FoldedPath chain, built;  ///< as modelled, and as the robot is
  bool as_modelled;         ///< they are the same
  const double* scale;      ///< of each joint's column, with its axis' sign
  std::size_t encoders, sources;
  const ErrorColumn* columns;
  const ColumnPart* parts;
  const double* per_resolution;  ///< 1/Delta of each encoder
  std::size_t coordinates;
  const int* rows;  ///< 0..2 position, 3..5 rotation vector, 6..8 roll pitch yaw
  bool rotations, angles, biased;
  bool mixed;                ///< some columns are sums
  double remainder;          ///< of the position (remainder.hpp)
  double largest_remainder;  ///< a bound of it wherever the joints are; infinite where that is not known
  const double* per_column;  ///< of |scaled column|
  double rotation, rotation_angle;
  const double* center_mean;  ///< of each coordinate
  std::size_t width;          ///< of a row of channels: their count, filled up to whole lanes
  std::size_t squares_width;  ///< the same of the squares
};

/// Sums of channels about their first values: no digits are lost to a large mean. A number for each channel;
/// where lanes are instants, sum, squares and peak are a vector of each channel, a part of the instants in
/// each lane.
struct ChannelTally {
  double *shift, *sum, *squares, *peak;
};

/// Sine and cosine less 1 of a small angle, in numbers or lanes: the next terms are below 5e-18.
template <class Number>
struct SmallTurn {
  static constexpr double largest = 0x1p-8;  ///< [rad]
  Number sine, less;

  [[gnu::always_inline]] explicit SmallTurn(const Number& angle) {
    const Number square = angle * angle;
    sine = angle + angle * square * (square * (1.0 / 120) - 1.0 / 6);
    less = square * (square * (1.0 / 24) - 0.5);
  }
};

/// How far a run is displaced along a joint: the turn, or the slide in place of its sine.
using Displacement = SmallTurn<double>;

/// Of a batch of instants: inputs channel-major, as is what is summed up later; channels of the filters in
/// rows.
struct PathErrorBatch {
  const double *joint, *built_joint, *estimate;  ///< independent joints
  const double *encoder, *measured;              ///< true and as read
  const double* path_sines;                      ///< of all runs' path, as `sines` gives them; or null
  const Displacement* turns;                     ///< [moving joint]: of this run from there
  double* rows;               ///< [instant][width]: error, its linear part, parts of the encoders, and mean;
                              ///< or null
  const ChannelTally* tally;  ///< of those channels in lanes of instants, the peak of the error; or null
  bool fresh;                 ///< nothing has been added to the tally yet: it needs its shifts
  bool bounds_only;           ///< of all that follows `rigorous` and `deviation` alone are wanted
  bool each;                  ///< the variance is wanted of each instant, not only its sum over the batch
  double* variance;           ///< [coordinate]: sum of (J C Delta)^2 over the encoders; or a vector of sums
  double* squares;            ///< [encoder][coordinate], added to: (J C Delta)^2; or null
  double* summed;             ///< the same, a vector of sums of each; or null
  double* rigorous;           ///< [coordinate]: largest bound so far
  double* deviation;          ///< [coordinate]: and of the difference from the mean at the centre
  double* room;
};

/// A section of a filter as trapezoidal integrators (FilterBank), solved for its highest derivative. The last
/// one of a filter multiplies by what all of them are to be multiplied with.
struct SectionPlan {
  /// Which of b0, b1, b2 are not 0; of a single one that stands for 1, or is multiplied with.
  enum class Output { low, band, high, scaled_low, scaled_band, scaled_high, all };
  bool second;
  Output output;
  double k0, k1;  ///< high = x - k1 s1 - k0 s2; of first order x - k0 s1
  double b0, b1, b2;
};

/// A section in the fewest operations, its output a sum of its states (TalliedFilter):
///
///     first    s' = x + e s          y = s' + a s
///     rise     the same              y = s' - s
///     lag      the same              y = s'
///     second   s' = x + e s - k r    y = s' + a s + b r    r' = r + s'
///     low      the same              y = (s' - s)/4 + r
struct TightSection {
  enum class Kind { none, first, rise, lag, second, low };
  Kind kind;
  double e, k, a, b;
};

/// Differences of inputs that follow each other, then one or two sections.
struct TightFilter {
  int differences;
  TightSection sections[2];  ///< the second one may be none
};

/// Whether there is a kernel for such a filter.
constexpr bool is_tight(int differences, TightSection::Kind one, TightSection::Kind two) {
  if (differences > 2) return false;
  if (one == TightSection::Kind::first)
    return two == TightSection::Kind::second ||
           (differences == 0 && (two == TightSection::Kind::none || two == one));
  if (one == TightSection::Kind::rise) return differences == 0 && two == TightSection::Kind::lag;
  if (one == TightSection::Kind::low) return two == one;
  return one == TightSection::Kind::second &&
         (two == TightSection::Kind::none || (differences == 0 && two == one));
}

inline constexpr std::size_t lags_at_once = 32;

struct SimulationKernels {
  std::size_t lanes;
  std::size_t (*errors_room)(const PathErrorPlan&);  ///< numbers
  /// (first + i)/rate at 64 instants i, but those from `count` on are that of the last one before.
  void (*times)(double first, std::size_t count, double rate, double* to);
  void (*positions)(const SinusoidPath&, const double* time, double* to);
  /// A row of 64 instants and a shift.
  void (*displace)(const double* row, double shift, double* to);
  /// to = matrix from: rows of 64 instants, the matrix row by row.
  void (*mix)(std::size_t n, const double* matrix, const double* from, double* to);
  /// Counts and counts * resolution of one encoder. @returns whether all of them are whole within 2^53
  bool (*quantize)(const Quantizer&, const double* position, double* counts, double* measured);
  /// Whether |factor x| <= limit for all numbers of a row of 64.
  bool (*within)(const double* row, double factor, double limit);
  /// Sines and cosines of the moving joints, or their slides, along a path: of as many instants as there are
  /// lanes, then of the next ones; 2 numbers for each joint and instant.
  void (*sines)(const FoldedPath&, const double* joint, double* to);
  void (*errors)(const PathErrorPlan&, const PathErrorBatch&);
  /// `width` channels of 64 instants into rows of them; the channels are 0 afterwards.
  void (*turn)(double* channels, std::size_t width, double* rows);
  /// Adds the rows first .. last - 1.
  void (*add_rows)(const double* rows, std::size_t width, std::size_t first, std::size_t last, double* to);
  /// The sum of the numbers first .. last - 1 of a row.
  double (*sum_between)(const double* row, std::size_t first, std::size_t last);
  /// Rows `stride` apart through a section, into rows side by side.
  void (*section)(const SectionPlan&, const double* in, std::size_t stride, std::size_t rows,
                  std::size_t width, double* state, double* out);
  /// @param in  the row of the first output; those before it stand before it
  void (*taps)(const double* taps, std::size_t count, const double* in, std::size_t rows, std::size_t width,
               double* out);
  /// @param peaks  of how many channels the peak is asked for
  /// @param fresh  nothing has been added to the tally yet
  void (*tally)(const double* in, std::size_t stride, std::size_t rows, std::size_t width, std::size_t peaks,
                bool fresh, const ChannelTally&);
  /// Rows through a filter and into the tally at once.
  /// @pre `is_tight` of its differences and sections
  /// @param state  [section][s, r][width], then [difference][width]
  void (*filter_and_tally)(const TightFilter&, const double* in, std::size_t stride, std::size_t rows,
                           std::size_t width, std::size_t peaks, bool fresh, double* state,
                           const ChannelTally&);
  /// A row of 64 numbers less the whole numbers nearest to them.
  void (*drop_whole)(double* row);
  /// sum_n r[n] sum_k {s}(1 - {s}), s = x[k] - x[k - n], n = 1 .. lags, k = 0 .. count - 1.
  /// @param weights  r[lags], ..., r[1]
  /// @param x        within half a count of 0, as `drop_whole` leaves them
  /// @pre lags is a multiple of `lags_at_once`
  double (*losses)(const double* weights, std::size_t lags, const double* x, std::size_t count);
};

}  // namespace qerr
