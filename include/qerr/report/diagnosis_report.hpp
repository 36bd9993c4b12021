#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "qerr/diagnose/diagnosis.hpp"
#include "qerr/input/spec.hpp"

namespace qerr {

/// The answer of `qerr diagnose`.
struct DiagnosisReport {
  Spec spec;
  Log log;  ///< with its values
  Diagnosis diagnosis;
  std::string extended_model;  ///< the file that --write-model wrote, "" for none
  std::vector<std::string> warnings;
};

/// Holds a log against its spec.
/// @throws Error (input) for what the log lacks
DiagnosisReport diagnosis_report(const Spec&, Log, const DiagnoseOptions&);

/// The parameters of a cause in the order of the effect's row: what was fitted, with its interval, and what
/// was not (an order, a shaft's side), with an interval of no width.
struct ReportedParameter {
  FoundParameter figure;
  std::string unit;    ///< SI, "" for a pure number
  bool fixed = false;  ///< not fitted
};
std::vector<ReportedParameter> reported_parameters(const Spec&, const Cause&);

/// `m` for a prismatic joint and for a coordinate of the tip, `rad` otherwise.
std::string coordinate_unit(const Spec&, const std::string& joint_or_coordinate);

/// The spec with the found effects in it, ready to stand at `target` (see extended_spec); notes above each
/// effect tell what was found, and how surely.
std::string extended_model(const DiagnosisReport&, const std::string& target);

/// Look-up table for a controller (CSV): per encoder, what to add to the measured position so that the found
/// effects that depend on the position alone are gone. Columns joint, encoder_angle [rad], measured,
/// correction, unit; over one revolution of the encoder where the error repeats with it, else over the
/// positions of the log. `#` lines say how it is used and what it does not hold.
/// @throws Error (usage) where the errors' periods are too short for a table
std::string correction_table(const DiagnosisReport&);

/// For plots (CSV): measured - reference of every encoder against time, position and direction, and the
/// amplitudes of its sines by order per revolution of the joint (or per metre); before, and after what the
/// found effects explain. Empty where there is nothing to plot: no joint has a reference (as in a log of a
/// tracked tip alone), and for the spectrum, none has moved.
struct ResidualCurves {
  std::string residual;  ///< joint, time [s], reference, direction, before, after, unit
  std::string spectrum;  ///< joint, order, encoder_order, before, after, unit
};
ResidualCurves residual_curves(const DiagnosisReport&);

}  // namespace qerr
