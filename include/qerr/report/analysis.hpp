#pragma once

#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "qerr/bound/effect_shares.hpp"
#include "qerr/bound/independent_error.hpp"
#include "qerr/bound/proven_maximum.hpp"
#include "qerr/bound/workspace.hpp"
#include "qerr/design/requirement.hpp"
#include "qerr/input/spec.hpp"
#include "qerr/report/comparison.hpp"

namespace qerr {

/// How often a bound exceeds a limit over the configurations, and where the tip is there.
struct Exceedance {
  /// Configurations with the tip at a distance of from <= d < to from the origin of the base [m].
  struct Shell {
    double from = 0, to = 0;
    std::uint64_t count = 0, above = 0;
  };

  std::string quantity;  ///< as in requirements: `position.xyz.worst_case`
  double limit = 0;      ///< in `unit` [SI]
  std::string unit;
  std::uint64_t count = 0, above = 0;  ///< configurations, and those above the limit
  std::vector<Shell> by_distance;      ///< of equal widths, from 0 to the reach
  /// The box of the tip's positions above the limit, in the base frame [m]; infinite without any.
  Eigen::Vector3d lowest = Eigen::Vector3d::Constant(std::numeric_limits<double>::infinity());
  Eigen::Vector3d highest = Eigen::Vector3d::Constant(-std::numeric_limits<double>::infinity());
};

/// Which maxima are proven over the whole joint ranges, which are those of the configurations' limits, also
/// where the configurations are listed.
struct ProofRequest {
  double gap = 0.01;  ///< between what is reached and what is proven
  bool all = false;   ///< every worst case and sigma; else the figures of requirements on the proven maximum
  /// Part of the distance between a requirement's limit and what is reached that the gap may have; 1: no more
  /// of a proof than the verdict needs (ProofOptions::of_distance).
  double of_distance = 0;
  std::function<void(std::uint64_t done, std::uint64_t total)> progress = {};
};

/// The proven maximum of a figure.
struct ProvenResult {
  Figure figure;
  ProvenMaximum maximum;
};

struct ControlReport;  // src/report/analysis/control.hpp

/// The result of `qerr analyze`: the bounds of a spec over its configurations.
struct Analysis {
  Spec spec;  ///< its model contains the effects
  JointError joints;
  Workspace workspace;
  std::vector<Eigen::VectorXd> noise_in_motion;  ///< [filter][encoder], in quantization intervals
  std::vector<std::string> warnings;
  std::vector<EffectShare> effects = {};  ///< in the order of the spec
  Eigen::VectorXd resolutions = {};       ///< of the encoders as in the spec; effects on a decoder multiply
                                          ///< those in the model
  std::vector<Exceedance> exceedances = {};  ///< that were asked for
  std::vector<ProvenResult> proofs = {};
  std::shared_ptr<const ControlReport> control = {};  ///< loops and walls; null without `control`
};

/// The proof of a figure; null if there is none.
const ProvenMaximum* find_proof(const Analysis&, const Figure&);

/// Every bound of the spec over its configurations, with the effects of the spec, and the proofs that are
/// asked for or required.
///
/// Where a requirement's limit lies between what is reached and what is proven, the proof is repeated once
/// with a smaller gap (`deciding_gap`).
/// @throws Error (input; key `requirements`) for a requirement on sigma_in_motion whose filter has too long a
/// memory
Analysis analyze(const Spec&, const WorkspaceOptions& = {}, const ProofRequest& = {});

/// The analysis, and one CSV row per configuration: its joint coordinates and its bounds.
/// @param csv  is called with the header, and then with the rows in the order of the configurations
Analysis analyze(const Spec&, const WorkspaceOptions&, const std::function<void(const std::string&)>& csv,
                 const ProofRequest& = {});

/// One number for each configuration in every column of `--per-configuration`; NaN for a sigma that is not
/// known.
struct ConfigurationColumns {
  std::vector<std::string> names;  ///< with units: `position.x.sigma [m]`
  std::vector<std::vector<double>> values;
};

/// @param columns  receives the figures of every configuration
Analysis analyze(const Spec&, const WorkspaceOptions&, ConfigurationColumns& columns,
                 const ProofRequest& = {});

/// The requirements of a spec, evaluated with its bounds.
struct SpecCheck {
  Analysis analysis;
  std::vector<RequirementResult> results;  ///< one for each requirement of the spec
  std::optional<BaselineCheck> baseline = {};
  double seconds = 0;  ///< that the evaluation took

  /// Also that no figure is worse than in the baseline, if there is one.
  bool all_met() const;
};

/// The bounds of a spec, and its requirements, if it has any.
/// @throws Error (input; key `requirements`) if there are requirements and an effect of unknown size, as they
/// cannot be decided then
SpecCheck evaluate(const Spec&, const WorkspaceOptions& = {}, const ProofRequest& = {});

/// The evaluation of a spec that has requirements or is checked against a baseline.
/// @param baseline  a report of check or analyze; may be null
/// @throws Error (input; key `requirements`) if there is nothing to check
SpecCheck check(const Spec&, const WorkspaceOptions& = {}, const Baseline* baseline = nullptr,
                const ProofRequest& = {});

/// The baselines that a file holds: one, or of a report of `check` of several specs one for each.
/// @throws Error (input) if it is no report of check or analyze
Baselines read_baselines(const std::string& text, const std::string& file, double tolerance);

/// The baseline of a spec, by its path, or by its name if only one has it. @param alone  the spec is the only
/// one that is checked: a report of one spec is then its baseline, whatever its name
/// @throws Error (input) if there is none
const Baseline& baseline_of(const Baselines&, const std::string& spec, bool alone);

/// A spec that cannot be checked.
struct BrokenSpec {
  std::string file;
  Error error;
};

/// The result of `qerr check`.
struct CheckReport {
  std::vector<SpecCheck> specs;
  std::vector<BrokenSpec> broken = {};

  bool all_met() const;
};

/// JUnit XML: a test suite for each spec, one test case per requirement, named by its spec, quantity,
/// statistic and limit, with the value; a spec that cannot be checked is a suite with one error. Valid in the
/// schema of Jenkins.
/// @param time  of the run, `2026-01-31T12:00:00`
std::string junit(const CheckReport&, const std::string& time);

/// Workflow commands of GitHub Actions: an error at the line of each requirement that is not met.
std::string github_annotations(const CheckReport&);
/// Workflow commands for what is wrong with a spec that cannot be checked.
std::string github_annotations(const Error&);

/// A row of Table IV of the paper, in both interpretations. Lengths in metres.
///
/// Physical: resolution 2 pi l/(n G) of a point at distance l from a revolute joint with n G counts per turn.
/// As printed (paper, Eqs. 43 and 44): l/(n G), without the factor 2 pi. A prismatic joint has no such
/// factor. Threshold velocity: resolution times sample rate, which is one count per sample. Behind a coupling
/// C (joint angles = C * encoder angles) one count of encoder i moves joint j by |C_ji| times this; the row
/// is that of the encoder and the joint with the largest product.
struct ThresholdRow {
  std::string robot;
  std::string
      joint;  ///< the joint j with the largest l |C_ji| Delta_i; counts and ratio are those of encoder i
  double counts_per_rev = 0;
  double gear_ratio = 1;
  double coupling = 1;               ///< |C_ji|, a factor of both resolutions
  double length = 0;                 ///< [m]
  double sample_rate = 0;            ///< [Hz], that of `filter`
  std::string filter = {};           ///< the first one of the spec that takes a derivative
  double resolution = 0;             ///< [m]
  double resolution_as_printed = 0;  ///< [m]

  double threshold_velocity() const { return resolution * sample_rate; }  ///< [m/s]
  double threshold_velocity_as_printed() const { return resolution_as_printed * sample_rate; }
};

/// The result of `qerr threshold`: Table IV of the paper.
struct ThresholdReport {
  std::vector<ThresholdRow> rows;
};

/// The spec's row of Table IV: the joint with the largest l Delta.
///
/// l is `threshold: {length}`, or else that joint's largest entry of the position Jacobian over the
/// configurations.
/// @throws Error (input; key `filters`) if the spec has no derivative filter that states the sample rate
ThresholdRow threshold_row(const Spec&, unsigned threads);

/// For every filter the noise of each encoder along the spec's motion, in quantization intervals (behind its
/// decoder, where an effect multiplies counts); empty without a motion, and for a filter whose memory is too
/// long to compute it.
std::vector<Eigen::VectorXd> noise_in_motion(const Spec&, unsigned threads = 0);

/// Unit of a signal, m or rad, behind a filter: `rad/s`, `m/s^2`, that of a control law; "" where it is
/// unknown.
std::string derivative_unit(std::string_view unit, const Filter&);

/// Each encoder's share of the mean variance of the tip's position (of all coordinates if no position is
/// analysed); sums to 1, or is 0 if no encoder moves the tip. Empty without a coordinate of one tip.
std::vector<double> encoder_budget(const Analysis&);

/// What an encoder's share in the budget consists of: the shares of its quantization, of its `accuracy` (a
/// sine of that amplitude) and of the effects that are attributed to it.
struct BudgetParts {
  double quantization = 0, accuracy = 0, effects = 0;
};

/// The parts of `encoder_budget`, of every encoder.
std::vector<BudgetParts> budget_parts(const Analysis&);

}  // namespace qerr
