#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "qerr/filter/quality.hpp"
#include "qerr/input/spec.hpp"
#include "qerr/report/estimator_report.hpp"
#include "qerr/report/noise_report.hpp"

namespace qerr {

/// What `qerr filter` is asked beside the norms.
struct FilterQuestions {
  std::vector<double> frequencies;                       ///< fidelity at these [Hz]
  std::optional<std::pair<double, double>> motion_band;  ///< tracking error over this [Hz]
  bool coefficients = false;                             ///< print the realised sections
  bool estimators = false;                               ///< compare FDM and ITM of every encoder
  std::optional<double> clock;                           ///< of ITM [Hz]; empty: the sample rate
  bool noise = false;                                    ///< how far IPQN can be believed
  std::vector<MotionQuestion> motions;                   ///< noise of every encoder in these
};

/// One filter's figures.
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
};

/// The answer of `qerr filter`.
struct FilterReport {
  std::string file;
  FilterQuestions questions;
  std::vector<FilterFigures> filters;
  std::vector<FilterNoise> noise;  ///< one per filter where it is asked for, else empty
  std::vector<SineErrorRow> sine_errors = {};
  std::optional<EstimatorReport> estimators = {};
};

/// What is suspicious about the spec's filters: a derivative that passes constants, or is far from its own
/// gain.
std::vector<std::string> filter_warnings(const Spec&);

/// @throws Error (usage) for a frequency above half a filter's sample rate
FilterReport filter_report(const Spec&, const FilterQuestions&);

struct Style;

/// With estimators CSV is `estimator_csv` alone, with motions `noise_csv` alone: one file, one table.
std::string write(const FilterReport&, std::string_view format, const Style&);

/// Frequency response as CSV, `filter,frequency [Hz],magnitude,phase [rad]`: logarithmic from 1e-5 of the
/// sample rate, or from a thousandth of the bandwidth where that is lower, to half the sample rate.
std::string response_csv(const FilterReport&);

/// Impulse response as CSV, `filter,time [s],value`: until it has decayed; of a long one every n-th sample,
/// so that at most 100000 are written.
std::string impulse_csv(const FilterReport&);

/// Noise after switching on as CSV, `filter,time [s],sigma_over_input,steady_state`: until it has
/// reached 99.99 % of its steady state ||H||_2; of a slow filter every n-th sample.
std::string transient_csv(const Spec&);

}  // namespace qerr
