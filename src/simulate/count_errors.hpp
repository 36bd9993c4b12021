#pragma once

#include <map>
#include <vector>

#include "qerr/bound/operational_error.hpp"
#include "qerr/effect/effect_kind.hpp"

namespace qerr {

/// Effects of stage `decoder` on the counts of one encoder, which are defined for integers.
struct Decoder {
  std::vector<Action> actions;
  double sign = 1;   ///< of the counter: its direction
  double noise = 0;  ///< standard deviation of the position before the rounding [counts]

  bool empty() const { return actions.empty(); }

  /// @param count  along the joint coordinate
  double operator()(double count, const Moment& m) const {
    double x = sign * count;
    for (const Action& action : actions) x = action(x, m);
    return sign * x;
  }

  /// Mean over the encoder's zero and the noise at a position in counts.
  double mean(double position, const Moment&) const;

 private:
  /// Mean over the zero: interpolated between the two next integers.
  double mean_over_zero(double position, const Moment&) const;
};

/// 64 equally probable values of a standard normal number, scaled to the variance 1.
const std::vector<double>& normal_values();

/// Whether an effect acts between the position of the shaft and the count, or scatters the position: such
/// errors are tied to the counts.
bool counts_depend_on(const EffectKind&);

/// Rounding of y + N to the nearest integer, N normal: error of its mean, and its variance, over N. Both have
/// the period 1 in y.
class DitheredRounding {
 public:
  /// @param s  standard deviation of N, > 0
  explicit DitheredRounding(double s);

  struct Moments {
    double error = 0, variance = 0;  ///< E[round(y + N)] - y, and the variance of round(y + N)
  };
  Moments operator()(double y) const;

 private:
  double s_;
  std::vector<Moments> table_;  // at multiples of 1/512; empty where a closed form serves
};

/// Errors of the counts of one encoder with everything that acts within a line and on its counts: distortion
/// g within a line, noise N, jitter, decoder D.
class CountErrors {
 public:
  /// @param rounds  false: of the distortion alone
  CountErrors(const OperationalModel&, const std::vector<Effect>&, std::size_t encoder, bool rounds);

  bool plain() const { return line_.empty() && !random() && decoder_.empty(); }  ///< rounding, nothing else
  bool random() const { return rounds_ && (noise_ > 0 || jitter_ > 0); }
  bool decodes() const { return !decoder_.empty(); }
  double mean_of_decoder(double x, const Moment& m) const {
    const double counted = x + decoder_shift_;
    return decodes() ? decoder_.mean(counted, m) - counted : 0;
  }
  bool jitters() const { return rounds_ && jitter_ > 0; }
  /// Before the rounding, without jitter [counts]; 1 without rounding, whose error is as smooth as with it.
  double noise() const { return rounds_ ? noise_ : 1; }
  /// Counts after which the error repeats: those of a line, or 1.
  double span() const { return line_.empty() ? 1 : span_; }
  /// Errors that can be evaluated in a second.
  double affordable() const;

  /// Mean of the error over the noise at position x and every zero u [counts]: E[g(x + u) + N] - x - u,
  /// behind a decoder less the decoder's own mean error.
  /// @param speed    [counts/s]
  /// @param weights  of the zeros
  /// @returns the variance over the noise, in the mean over the zeros
  double operator()(double x, const Moment&, double speed, const std::vector<double>& zeros,
                    const std::vector<double>& weights, double* errors);

 private:
  /// Distortion at a position [counts], and its slope.
  struct Distorted {
    double by, slope;
  };
  Distorted distortion(double position) const;
  const DitheredRounding& rounding(double s);
  std::pair<double, double> decoded(double w, double y, double s, double u, const Moment&) const;

  bool rounds_, adds_jitter_;
  double decoder_shift_ = 0;                              // by an effect that changes the rounding
  double shift_ = 0, span_ = 1, noise_ = 0, jitter_ = 0;  // [counts, counts, counts, s]
  std::vector<double> line_;                              // distortion over a line
  Decoder decoder_;
  std::map<int, DitheredRounding> roundings_;  // by the logarithm of the noise
};

}  // namespace qerr
