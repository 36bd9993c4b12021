#pragma once

#include <cmath>
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

/// One thing that measured data and the simulation of the model were compared by.
struct Comparison {
  std::string joint;      ///< or a coordinate of the tip
  std::string statistic;  ///< mean, sigma_ratio, uniformity, autocorrelation, ...
  double observed = 0;
  double expected = 0;  ///< mean of the surrogates
  double p_value = 1;
};

/// A number that was fitted, with its 95 % interval [SI].
struct FoundParameter {
  std::string name;
  double value = 0, lower = 0, upper = 0;
};

/// Root mean squares of the residual measured - reference, means included and quantization left in. NaN:
/// not known.
struct Gain {
  double rms_before = 0, rms_after = 0;
  bool held_out = false;        ///< after: by a model that was fitted to other blocks of the record
  double lower = 0, upper = 0;  ///< 95 % interval of before/after, by the blocks (bootstrap)
  double counts_before = std::nan(""), counts_after = std::nan("");  ///< in counts of each encoder
  double sigma_ratio = std::nan("");  ///< rms of the rest, over what the extended model predicts
  double log_score = std::nan("");    ///< gain in log-likelihood per reading
  double coverage = std::nan("");     ///< part of the readings inside the model's central 95 %
  std::string unit = "rad";           ///< of the rms values; m: of the tip, or of prismatic joints alone
  bool of_tip = false;                ///< per coordinate of the tip; else per reading of encoders

  double ratio() const { return rms_after > 0 ? rms_before / rms_after : 1; }
};

/// A cause by its name.
struct Cause {
  Effect effect;  ///< ready to stand in the spec's `effects:`
  std::vector<FoundParameter> parameters;
  double p_value = 1;  ///< of no such effect, under control for the number of hypotheses
  Gain gain;           ///< of its joint, or of the tip where that is what it was seen by
  double rms = 0;      ///< of what it adds to the readings [rad or m]; 0: not known
};

/// What could be instead of a cause, and what to record to tell them apart.
struct AlternativeCause {
  std::string instead_of, effect, joint, record;
};

/// Something real without a name.
struct Unidentified {
  std::string joint;
  std::string what;                 ///< "periodic in the joint angle", "slow in time", "vibrates", ...
  std::optional<double> order;      ///< periods per revolution of the joint (or per metre)
  std::optional<double> frequency;  ///< [Hz]
  double amplitude = 0;             ///< [rad or m]
};

/// What a log says about the model of its robot.
struct Diagnosis {
  Verdict verdict = Verdict::cannot_judge;
  std::string reason;  ///< of cannot_judge: what would suffice; else ""
  std::vector<Comparison> simulation;
  std::vector<Cause> causes;  ///< by the variance they remove
  std::vector<AlternativeCause> alternatives;
  std::vector<Unidentified> unexplained;
  Gain gain;  ///< over all judged joints; of the tip where no joint has a reference
  std::vector<std::string> warnings;
};

/// How a log is judged. What is found does not depend on the threads, and causes not on the seed.
struct DiagnoseOptions {
  std::uint64_t seed =
      1;                 ///< of the simulations that residuals are held against, and of the gain's intervals
  unsigned threads = 0;  ///< 0: as many as the machine has
};

/// Holds a log against the model: what its simulation gets wrong, the causes, what the extended model gains.
///
/// The residual of an encoder is measured - reference [rad or m], in its own coordinate; that of the tip is
/// forward kinematics of the measured joints - tracked tip [m], for causes that no joint's reference shows.
/// Every cause is tested against the log's own likelihood, in which quantization is exact (Explanation), and
/// the gain is of blocks that the model was not fitted to.
///
/// Assumed is that references have white noise of their own beside the encoders' errors, that joints move on
/// paths which are smooth from row to row, and that the rows of a log with time follow each other. A log that
/// does not say enough (fewer than 30 rows, no reference that moves, references noisier than 0.3 counts) is
/// no error: the verdict is `cannot_judge`, with the reason.
///
/// @param filters  of the spec; those of the first derivative are held against JOINT.velocity
/// @param present  effects that the spec already has: the model is to be judged with them
/// @param log      with its values; rows x columns finite, times increasing, as read_log has checked
/// @throws std::out_of_range for an effect in `present` that is not in the catalogue; specs are checked when
///   they are read
Diagnosis diagnose(const OperationalModel&, const std::vector<Filter>&, const std::vector<Effect>& present,
                   const Log&, const DiagnoseOptions& = {});

}  // namespace qerr
