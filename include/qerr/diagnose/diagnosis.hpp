#pragma once

#include <functional>
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

/// Root mean squares of the residual measured - reference, means included and quantization left in.
struct Gain {
  double rms_before = 0, rms_after = 0;
  bool held_out = false;        ///< after: by a model that was fitted to other blocks of the record
  double lower = 0, upper = 0;  ///< 95 % interval of before/after, by the blocks (bootstrap)
  double counts_before = 0, counts_after = 0;  ///< the same in counts of each encoder
  double sigma_ratio = 0;                      ///< rms of the rest, over what the extended model predicts
  double log_score = 0;                        ///< gain in log-likelihood per reading
  double coverage = 0;                         ///< part of the readings inside the model's central 95 %

  double ratio() const { return rms_after > 0 ? rms_before / rms_after : 1; }
};

/// A cause by its name.
struct Cause {
  Effect effect;  ///< ready to stand in the spec's `effects:`
  std::vector<FoundParameter> parameters;
  double p_value = 1;  ///< of no such effect, under control for the number of hypotheses
  Gain gain;           ///< of its joint
  double rms = 0;      ///< of what it adds to the readings [rad or m]; 0: not known
};

/// What could be instead of a cause, and what to record to tell them apart.
struct AlternativeCause {
  std::string instead_of, effect, joint, record;
};

/// Something real without a name.
struct Unnamed {
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
  std::vector<Unnamed> unexplained;
  Gain gain;               ///< over all judged joints
  bool prismatic = false;  ///< the gain's unit is m
  std::vector<std::string> warnings;
};

struct DiagnoseOptions {
  std::uint64_t seed = 1;
  unsigned threads = 0;
  std::function<void(std::uint64_t done, std::uint64_t total)> progress = {};
};

/// Holds a log against the model: what its simulation gets wrong, the causes, what the extended model gains.
/// @param present  effects that the spec already has: the model is to be judged with them
Diagnosis diagnose(const OperationalModel&, const std::vector<Filter>&, const std::vector<Effect>& present,
                   const Log&, const DiagnoseOptions& = {});

}  // namespace qerr
