#pragma once

#include <string>
#include <vector>

#include "qerr/diagnose/diagnosis.hpp"
#include "qerr/diagnose/plan.hpp"
#include "qerr/input/spec.hpp"

namespace qerr {

/// The result of `qerr diagnose`.
struct DiagnosisReport {
  Spec spec;
  Log log;  ///< with its values, if they were kept
  Diagnosis diagnosis;
  std::string extended_model;  ///< path of the file that --write-model wrote; "" without one
  std::vector<std::string> warnings;
};

/// Compares a log with its spec.
/// @param keep_values  a look-up table and plots need them; without, a long log takes half the memory
/// @throws Error (input) if the log lacks data that the diagnosis needs
DiagnosisReport diagnosis_report(const Spec&, Log, const DiagnoseOptions&, bool keep_values = true);

/// A parameter of a cause. One that was not fitted, such as an order, has an interval of zero width.
struct ReportedParameter {
  FoundParameter figure;
  std::string unit;    ///< SI, "" for a pure number
  bool fixed = false;  ///< not fitted
};

/// In the order of the effect's row.
std::vector<ReportedParameter> reported_parameters(const Spec&, const Cause&);

/// `m` for a prismatic joint and for a coordinate of the tip, `rad` otherwise.
std::string coordinate_unit(const Spec&, const std::string& joint_or_coordinate);

/// The spec with the effects found, as the text of a file at `target` (see extended_spec); a comment above
/// each effect states its parameters with their intervals.
std::string extended_model(const DiagnosisReport&, const std::string& target);

/// Look-up table for a controller (CSV): per encoder, the correction that is added to the measured position
/// to compensate those effects found that depend on the position alone. Columns joint, encoder_angle [rad],
/// measured, correction, unit; over one revolution of the encoder if the error is periodic in it, else over
/// the positions of the log. Lines with `#` state how to use it and which effects it does not contain.
/// @throws Error (usage) if the periods of the errors are too short for a table
std::string correction_table(const DiagnosisReport&);

/// For plots (CSV): measured - reference of every encoder against time, position and direction, and the
/// amplitude spectrum by order per revolution of the joint (or per metre); before and after subtraction of
/// the effects found. Empty if no joint has a reference (as in a log of a tracked tip alone); the spectrum
/// also if no joint moves.
struct ResidualCurves {
  std::string residual;  ///< joint, time [s], reference, direction, before, after, unit
  std::string spectrum;  ///< joint, order, encoder_order, before, after, unit
};
ResidualCurves residual_curves(const DiagnosisReport&);

/// The result of `qerr diagnose --plan`.
struct PlanReport {
  Spec spec;
  Plan plan;
  std::vector<std::string> warnings;
};

/// The effects that a log of the spec's motion would detect and identify.
/// @throws Error (input; key `motion`) if the spec has none
PlanReport plan_report(const Spec&, const PlanOptions& = {});

/// The `motion:` section of a spec, with a motion of each joint.
std::string motion_text(const Motion&, const Chain&);

}  // namespace qerr
