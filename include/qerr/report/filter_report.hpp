#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "qerr/bound/velocity_estimators.hpp"
#include "qerr/filter/norms.hpp"
#include "qerr/input/spec.hpp"

namespace qerr {

/// A motion of an encoder whose filtered quantization error is computed.
struct MotionQuestion {
  bool sine = false;      ///< else a constant speed
  double size = 0;        ///< speed, or amplitude of the sine
  double frequency = 0;   ///< of the sine [Hz]
  bool in_counts = true;  ///< size in counts per sample (counts for a sine), else in the joint's unit
  bool length = false;    ///< size in m/s or m, else in rad/s or rad

  /// `counts/sample`, `rad/s` or `m/s`; of an amplitude `counts`, `rad` or `m`.
  std::string unit() const;
};

/// What `qerr filter` computes in addition to the norms.
struct FilterQuestions {
  std::vector<double> frequencies;                       ///< fidelity at these [Hz]
  std::optional<std::pair<double, double>> motion_band;  ///< tracking error over this [Hz]
  bool coefficients = false;                             ///< the sections or taps
  bool estimators = false;                               ///< compare FDM and ITM of every encoder
  std::optional<double> clock;                           ///< of ITM [Hz]; empty: the sample rate
  bool noise = false;                                    ///< above which speed IPQN is accurate
  std::vector<MotionQuestion> motions;                   ///< noise of every encoder in these
};

/// Figures of one filter.
struct FilterFigures {
  std::string name;
  Filter filter;
  Norms norms;
  double group_delay = 0;  ///< [s]
  double poles_max_modulus = 0;
  std::optional<double> bandwidth;        ///< -3 dB [Hz]
  std::optional<double> noise_bandwidth;  ///< [Hz]; empty for a filter that does not estimate its derivative
  std::optional<double> settling_time;    ///< to 2 % [s]
  std::vector<Fidelity> fidelity;
  std::optional<BandTracking> tracking;
  std::shared_ptr<const FamilyDesign> designed = {};  ///< as of NamedFilter
};

/// sigma of the filtered error of one encoder in one motion, exact for a uniformly random zero of the
/// encoder.
struct NoiseRow {
  std::string encoder;  ///< of this joint, on the joint side of its gear
  std::string unit;     ///< of sigma
  MotionQuestion motion;
  double counts_per_sample = 0;  ///< peak speed
  std::optional<double> sigma;   ///< empty if the filter's memory is too long to compute it
  double sigma_ipqn = 0;
};

/// The accuracy of IPQN behind one filter.
struct FilterNoise {
  std::string filter;
  bool followed = true;  ///< false for a memory of millions of samples: no thresholds, no sigma along sines
  /// Peak speed of slow sines above which sigma is within 10 % (1 %) of IPQN [counts per sample]; empty: the
  /// filter's memory is too long for the search.
  std::optional<double> within_10_percent, within_1_percent;
  std::optional<double> rise_time;  ///< after switching on, to 99 % of the noise [s]
  std::vector<NoiseRow> rows;
};

/// The error of the quantizer itself along a sine (paper, Appendix B), over all zeros of the encoder, in
/// counts; and the envelopes of the paper.
struct SineErrorRow {
  std::string encoder;
  double amplitude = 0;                         ///< [counts]
  double largest_mean = 0;                      ///< largest |E e|
  double least_square = 0, largest_square = 0;  ///< of E e^2, which is 1/12 under IPQN
  double mean_envelope = 0, square_below = 0, square_above = 0;
};

/// Both velocity estimators at one speed of one encoder.
struct EstimatorRow {
  double speed = 0;              ///< [rad/s or m/s]
  double quanta_per_sample = 0;  ///< v/(Delta f)
  EstimatorError finite_difference, inverse_time;

  /// By the bounds for a varying speed.
  bool inverse_time_is_better() const { return inverse_time.varying <= finite_difference.varying; }
};

/// One encoder's comparison of FDM and ITM (paper, Appendix A).
struct EncoderEstimators {
  std::string encoder;  ///< of this joint, on the joint side of its gear
  std::string unit;     ///< rad/s or m/s
  double resolution = 0;
  double crossing_speed = 0;  ///< ITM is at least as good up to here
  EdgeErrors edges;           ///< of the spec's effects
  std::vector<EstimatorRow> rows;
};

struct EstimatorReport {
  double sample_rate = 0;  ///< of FDM [Hz]
  double clock = 0;        ///< of ITM [Hz]
  std::vector<EncoderEstimators> encoders;
};

/// The result of `qerr filter`.
struct FilterReport {
  Spec spec;
  FilterQuestions questions;
  std::vector<FilterFigures> filters;
  std::vector<FilterNoise> noise;  ///< one per filter if noise or motions are asked for, else empty
  std::vector<SineErrorRow> sine_errors = {};
  std::optional<EstimatorReport> estimators = {};
  std::vector<std::string> warnings = {};  ///< of the spec and its filters
};

/// @throws Error (usage) for a frequency above half a filter's sample rate
FilterReport filter_report(const Spec&, const FilterQuestions&);

/// Every encoder of the spec, at speeds 1.5, 3.5 and 7.5 in every decade from 0.01 counts per sample to
/// beyond the crossing: at whole counts per sample and whole ticks per count both estimators are exact by
/// coincidence.
///
/// The sample rate is that of the first filter that estimates a derivative (of the first filter if none
/// does).
/// @param clock  [Hz], between 1e-3 and 1e15; when empty that of the first of the spec's estimators with a
/// clock, else the sample rate, as in the paper
/// @pre the spec has a filter
EstimatorReport estimator_report(const Spec&, std::optional<double> clock = {});

/// One for each filter that does not estimate the derivative that the spec states: it passes constants, or
/// its gain at low frequencies is not that of the derivative.
std::vector<std::string> filter_warnings(const Spec&);

/// Frequency response as CSV, `filter,frequency [Hz],magnitude,phase [rad]`: logarithmic from 1e-5 of the
/// sample rate, or from a thousandth of the bandwidth where that is lower, to half the sample rate.
std::string response_csv(const FilterReport&);

/// Impulse response as CSV, `filter,time [s],value`: until it has decayed; of a long one every n-th sample,
/// so that at most 100000 are written.
std::string impulse_csv(const FilterReport&);

/// Noise after switching on as CSV, `filter,time [s],sigma_over_input,steady_state`: until it has
/// reached 99.99 % of its steady state ||H||_2; of a slow filter every n-th sample.
std::string transient_csv(const Spec&);

/// A language in which filters are written: a row of `code_languages`.
struct CodeLanguage {
  std::string_view name, ending, summary;
  /// @throws Error (input) for a filter that the form cannot hold
  std::string (*write)(const FilterReport&);
};

/// C, Python, and chains of ROS filters.
const std::vector<CodeLanguage>& code_languages();

}  // namespace qerr
