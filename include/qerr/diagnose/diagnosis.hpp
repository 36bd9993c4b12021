#pragma once

#include <cmath>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "qerr/bound/operational_error.hpp"
#include "qerr/effect/effect.hpp"
#include "qerr/filter/filter.hpp"
#include "qerr/simulate/log.hpp"

namespace qerr {

enum class Verdict { nothing_wrong, explained, partly_explained, ambiguous, unexplained, cannot_judge };

/// "nothing_wrong", ...
std::string_view name(Verdict);

/// One statistic by which the measured data are compared with simulations of the model.
struct Comparison {
  std::string joint;      ///< or a coordinate of the tip
  std::string statistic;  ///< mean, sigma_ratio, uniformity, autocorrelation, ... (residual_statistics.hpp)
  double observed = 0;
  double expected = 0;  ///< mean of the simulations
  double p_value = 1;   ///< corrected for the number of comparisons (Bonferroni)
};

/// A fitted parameter with its 95 % interval [SI].
struct FoundParameter {
  std::string name;
  double value = 0, lower = 0, upper = 0;
};

/// Reduction of the residual measured - reference by the extended model, as root mean squares that include
/// the mean and the quantization error. NaN: unknown.
struct Gain {
  double rms_before = 0, rms_after = 0;
  bool held_out = false;        ///< rms_after is of blocks to which the model was not fitted
  double lower = 0, upper = 0;  ///< 95 % interval of before/after (block bootstrap), with the ratio in it
  double counts_before = std::nan(""), counts_after = std::nan("");  ///< in counts of each encoder
  double sigma_ratio = std::nan("");  ///< rms of the residual over that predicted by the extended model
  double log_score = std::nan("");    ///< increase of the log-likelihood per reading
  double coverage = std::nan("");     ///< share of the readings in the model's central 95 % interval
  std::string unit = "rad";           ///< of the rms values; m: of the tip, or of prismatic joints alone
  bool of_tip = false;                ///< per coordinate of the tip; else per reading of encoders

  double ratio() const { return rms_after > 0 ? rms_before / rms_after : 1; }
};

/// The extended model, simulated along the record: its residual, reading - reference, and the measured one,
/// as root mean squares of all judged readings; of the tip, per logged coordinate, tip of the model -
/// tracked.
struct Reproduction {
  double rms_simulated = 0, rms_measured = 0;  ///< [rad, or m where all joints are prismatic; m of the tip]
  /// Whether at every joint, or at the tip, the readings differ from the simulated positions by no more than
  /// the reported residual, and a tenth.
  bool agrees = true;
};

/// The residual against the quantity that an effect depends on, averaged in bins, and the fit through it.
struct ResidualCurve {
  std::string against;           ///< angle, count, speed, time, effort, temperature, direction
  std::string unit;              ///< of `at`: rad, m, count, rad/s, ...
  std::vector<double> at;        ///< centres of the bins, ascending
  std::vector<double> residual;  ///< mean residual of the bin without this cause [rad or m]; NaN: no rows
  std::vector<double> fit;       ///< the cause's mean contribution to the bin [rad or m]
};

/// An identified cause of the residual.
struct Cause {
  Effect effect;  ///< as an entry of the spec's `effects:`
  std::vector<FoundParameter> parameters;
  double p_value = 1;  ///< of the hypothesis without the effect, corrected for the number of hypotheses
  Gain gain;           ///< at its joint, or at the tip if the cause was found there
  double rms = 0;      ///< of its contribution to the readings [rad or m]; 0: unknown
  /// Residual rms of the extended model without this cause, the others refitted [rad or m]; NaN: unknown.
  double rms_without = std::nan("");
  ResidualCurve curve = {};  ///< empty: none
};

/// An effect that may be the cause instead of another one, and what to record to distinguish them.
struct AlternativeCause {
  std::string instead_of, effect, joint, record;
};

/// A significant part of the residual that no effect of the catalogue explains.
struct Unidentified {
  std::string joint;
  std::string what;                 ///< "periodic in the joint angle", "slow in time", ...
  std::optional<double> order;      ///< periods per revolution of the joint (or per metre)
  std::optional<double> frequency;  ///< [Hz]
  double amplitude = 0;             ///< [rad or m]
  Shape shape = Shape::unknown;
  /// Of the shape, SI: time of a step; width of a hysteresis; time_constant of an exponential; frequency of a
  /// line; order; angle and width of a bump; divisor of an error by count.
  std::map<std::string, double> figures = {};
  ResidualCurve curve = {};  ///< empty: none
  std::string next = {};     ///< what to inspect or to record; empty: that of its shape
};

/// What a finding about the record says of its readings. Each kind but `remark` is a fault of the record.
enum class DataKind {
  remark,        ///< all readings are used as they are: the rows are few, the stamps uneven, the joint rests
  corrupt,       ///< readings that no motion has
  missing,       ///< readings that were taken and not recorded
  repeated,      ///< readings or stamps of an earlier row
  contradictory  ///< columns that contradict each other or their headers
};

/// "remark", ...
std::string_view name(DataKind);

/// A property of the record itself, which is found without a model of the error.
struct DataFinding {
  std::string what;                  ///< "counts are held for 4 rows", ...
  std::string joint;                 ///< ""; of the whole record
  std::optional<std::uint64_t> row;  ///< in the file, from 1: where it begins
  std::optional<double> time;        ///< [s]
  std::string remedy;
  DataKind kind = DataKind::remark;
};

/// Smallest size of an effect that the record would have shown.
struct Visible {
  std::string effect, joint;
  double smallest = std::nan("");  ///< of the effect's size parameter; NaN: the record cannot show it
  std::string parameter, unit;
  std::string hidden_by;  ///< why the record cannot show it: "standstill", "one way", ...; else ""
};

/// Comparison of a log with the model of its robot.
struct Diagnosis {
  Verdict verdict = Verdict::cannot_judge;
  std::string reason;  ///< of cannot_judge, and what to record; else ""
  std::vector<Comparison> simulation;
  std::vector<Cause> causes;  ///< in descending order of the variance that they explain
  std::vector<AlternativeCause> alternatives;
  std::vector<Unidentified> unexplained;
  std::vector<DataFinding> data;          ///< about the record itself
  std::vector<Visible> visible;           ///< what the record could have shown
  std::optional<Reproduction> check;      ///< of joints with a reference; empty without one
  std::optional<Reproduction> tip_check;  ///< of the tip; empty if no cause moves it
  Gain gain;  ///< over all joints with a verdict; of the tip if no joint has a reference
  /// What the log has columns of and nothing can be said of: joints, `tip`, or a misspelt coordinate `tip.x`.
  /// A warning says why, or the reason of cannot_judge. Joints of which the log has no column are not
  /// listed.
  std::vector<std::string> unjudged;
  std::vector<std::string> warnings;
};

/// The kinds of faults of the record, each once, in the order of their enumeration.
std::vector<DataKind> record_faults(const Diagnosis&);

/// Whether neither the robot nor the record has a fault: the verdict is `nothing_wrong`, no reading had to be
/// left out, replaced or converted to come to it, and nothing of which the log has columns is unjudged.
bool is_faultless(const Diagnosis&);

/// The result does not depend on the number of threads. Of a record with more than 4096 independent readings
/// the seed may select those that are fitted; else causes do not depend on it.
struct DiagnoseOptions {
  std::uint64_t seed = 1;  ///< of the simulations, of the bootstrap and of selected rows
  unsigned threads = 0;    ///< 0: one per core
};

/// Compares a log with the model: what the simulation of the model gets wrong, which effects are the cause,
/// and the improvement with the extended model.
///
/// The residual of an encoder is measured - reference [rad or m] in the encoder's coordinate. That of the tip
/// is forward kinematics of the measured joints - tracked tip [m]; it shows causes that no joint's reference
/// shows. Causes are tested with the likelihood of the quantized readings (interval_likelihood.hpp), and the
/// gain is computed on blocks to which the model was not fitted.
///
/// It is assumed that references have white noise, independent of the encoders' errors, that joints move on
/// paths that are smooth from row to row, and that the rows of a log with time are consecutive. An
/// insufficient log (fewer than 30 rows, no reference that can be used, references noisier than 0.3 counts)
/// is not an error: the verdict is `cannot_judge`, with the reason.
///
/// @param filters  of the spec; those of the first derivative are compared with JOINT.velocity
/// @param present  effects that the spec has: they are part of the model
/// @param log      with its values; rows x columns finite, times increasing, as read_log has checked
/// @throws std::out_of_range for an effect in `present` that is not in the catalogue; specs are checked when
///   they are read
Diagnosis diagnose(const OperationalModel&, const std::vector<Filter>&, const std::vector<Effect>& present,
                   Log, const DiagnoseOptions& = {});

}  // namespace qerr
