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
  std::optional<double> bandwidth;      ///< -3 dB [Hz]
  double noise_bandwidth = 0;           ///< [Hz]
  std::optional<double> settling_time;  ///< to 2 % [s]
  std::vector<Fidelity> fidelity;
  std::optional<BandTracking> tracking;
};

/// The answer of `qerr filter`.
struct FilterReport {
  std::string file;
  FilterQuestions questions;
  std::vector<FilterFigures> filters;
  std::vector<FilterNoise> noise;  ///< one per filter where it is asked for, else empty
  std::optional<EstimatorReport> estimators = {};
};

/// @throws Error (usage) for a frequency above half a filter's sample rate
FilterReport filter_report(const Spec&, const FilterQuestions&);

struct Style;

/// With estimators CSV is `estimator_csv` alone, with motions `noise_csv` alone: one file, one table.
std::string write(const FilterReport&, std::string_view format, const Style&);

/// Frequency response as CSV, `filter,frequency [Hz],magnitude,phase [rad]`: logarithmic from 1e-5 of the
/// sample rate, and linear near half of it.
std::string response_csv(const FilterReport&);

/// Impulse response as CSV, `filter,time [s],value`: until it has decayed, at most 100000 samples a filter.
std::string impulse_csv(const FilterReport&);

}  // namespace qerr
