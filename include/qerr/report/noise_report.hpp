#pragma once

#include <optional>
#include <string>
#include <vector>

#include "qerr/input/spec.hpp"

namespace qerr {

/// A motion of which `qerr filter` is asked what noise it makes of an encoder's quantization.
struct MotionQuestion {
  bool sine = false;      ///< else a constant speed
  double size = 0;        ///< speed, or amplitude of the sine
  double frequency = 0;   ///< of the sine [Hz]
  bool in_counts = true;  ///< size in counts per sample (counts for a sine), else in the joint's unit
  bool length = false;    ///< size in m/s or m, else in rad/s or rad

  /// "counts/sample", "rad/s" or "m/s"; of an amplitude "counts", "rad" or "m".
  std::string unit() const {
    if (in_counts) return sine ? "counts" : "counts/sample";
    return std::string(length ? "m" : "rad") + (sine ? "" : "/s");
  }
};

/// sigma of the filtered error of one encoder in one motion, exact over a random position of its zero.
struct NoiseRow {
  std::string encoder;  ///< of this joint, on the joint side of its gear
  std::string unit;     ///< of sigma
  MotionQuestion motion;
  double counts_per_sample = 0;  ///< peak speed
  std::optional<double> sigma;   ///< empty when the filter remembers too many samples
  double sigma_ipqn = 0;
};

/// The error of the quantizer itself along a sine (paper, Appendix B), over every position of its zero, in
/// counts; beside it the paper's envelopes.
struct SineErrorRow {
  std::string encoder;
  double amplitude = 0;                         ///< [counts]
  double largest_mean = 0;                      ///< largest |E e|
  double least_square = 0, largest_square = 0;  ///< of E e^2, which is 1/12 under IPQN
  double mean_envelope = 0, square_below = 0, square_above = 0;
};

/// How far IPQN can be believed behind one filter.
struct FilterNoise {
  std::string filter;
  bool followed = true;  ///< false: a memory of millions of samples; no thresholds, no sigma along sines
  std::optional<double>
      within_10_percent;  ///< peak speed of slow sines from which on sigma is within 10 % of IPQN
  std::optional<double> within_1_percent;  ///< [counts per sample]; empty: not searched, the memory is long
  std::optional<double> rise_time;         ///< after switching on, to 99 % of the noise [s]
  std::vector<NoiseRow> rows;
};

/// For every filter, every encoder and every motion asked for; encoders whose unit is another are left out.
std::vector<FilterNoise> noise_report(const Spec&, const std::vector<MotionQuestion>&);

/// For every encoder and every sine asked for.
std::vector<SineErrorRow> sine_errors(const Spec&, const std::vector<MotionQuestion>&);

std::string noise_table(const std::vector<FilterNoise>&, const std::vector<SineErrorRow>&);

/// `filter,encoder,motion,size,size_unit,frequency [Hz],counts_per_sample,unit,sigma,sigma_ipqn`, one row for
/// each motion; sigma is empty where it is not known.
std::string noise_csv(const std::vector<FilterNoise>&);

}  // namespace qerr
