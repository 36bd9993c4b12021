#pragma once

#include <optional>
#include <string>
#include <vector>

#include "qerr/bound/velocity_estimators.hpp"
#include "qerr/input/spec.hpp"

namespace qerr {

/// Both estimators at one speed of one encoder.
struct EstimatorRow {
  double speed = 0;              ///< [rad/s or m/s]
  double quanta_per_sample = 0;  ///< v/(Delta f)
  EstimatorError finite_difference, inverse_time;
};

/// One encoder's comparison of FDM and ITM (paper, Appendix A).
struct EncoderEstimators {
  std::string encoder;  ///< of this joint, on the joint side of its gear
  std::string unit;     ///< rad/s or m/s
  double resolution = 0;
  double crossing_speed = 0;  ///< ITM is at least as good up to here
  std::vector<EstimatorRow> rows;
};

/// The answer of `qerr filter --estimators`.
struct EstimatorReport {
  double sample_rate = 0;  ///< of FDM [Hz]
  double clock = 0;        ///< of ITM [Hz]
  std::vector<EncoderEstimators> encoders;
};

/// Every encoder of the spec, at speeds 1.5, 3.5 and 7.5 in every decade from 0.01 counts per sample to
/// beyond the crossing: between the whole counts and ticks, where both are exact by accident.
///
/// The sample rate is that of the first filter that estimates a derivative (of the first filter when none
/// does).
/// @param clock  [Hz], between 1e-3 and 1e15; the sample rate when empty, as in the paper
/// @pre the spec has a filter
EstimatorReport estimator_report(const Spec&, std::optional<double> clock = {});

std::string estimator_table(const EstimatorReport&);

/// `encoder,speed,unit,quanta_per_sample,estimator,bound,error,snr_db`, one row for each bound; empty where
/// infinite.
std::string estimator_csv(const EstimatorReport&);

}  // namespace qerr
