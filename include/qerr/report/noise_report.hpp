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
};

/// sigma of the filtered error of one encoder in one motion, exact over a random position of its zero.
struct NoiseRow {
  std::string encoder;  ///< of this joint, on the joint side of its gear
  std::string unit;     ///< of sigma
  MotionQuestion motion;
  double counts_per_sample = 0;  ///< peak speed
  double sigma = 0, sigma_ipqn = 0;
};

/// How far IPQN can be believed behind one filter.
struct FilterNoise {
  std::string filter;
  bool followed = true;  ///< false: a memory of millions of samples; nothing below is known
  std::optional<double>
      within_10_percent;  ///< peak speed of slow sines from which on sigma is within 10 % of IPQN
  std::optional<double> within_1_percent;  ///< [counts per sample]; empty: not searched, the memory is long
  std::optional<double> rise_time;         ///< after switching on, to 99 % of the noise [s]
  std::vector<NoiseRow> rows;
};

/// For every filter, every encoder and every motion asked for; encoders whose unit is another are left out.
std::vector<FilterNoise> noise_report(const Spec&, const std::vector<MotionQuestion>&);

std::string noise_table(const std::vector<FilterNoise>&);

/// `filter,encoder,motion,size,frequency,counts_per_sample,unit,sigma,sigma_ipqn`, one row for each motion.
std::string noise_csv(const std::vector<FilterNoise>&);

/// Noise after switching on as CSV, `filter,time [s],sigma_over_input`: until it has reached 99.9 % of its
/// steady state, at most 100000 samples a filter.
std::string transient_csv(const Spec&);

}  // namespace qerr
