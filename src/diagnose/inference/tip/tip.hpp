#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "qerr/diagnose/diagnosis.hpp"

namespace qerr {

/// Contribution of a tracked tip to a diagnosis.
struct TipDiagnosis {
  bool judged = false;  ///< the log has a tip that moves, or a constant error of it, and all joints
  std::string reason;   ///< why a tip that the log has is not judged, and what to record; else ""
  std::vector<std::string> unseen;  ///< joints without a reference that do not move the logged coordinates
  std::vector<Cause> causes;
  std::vector<AlternativeCause> alternatives;
  std::vector<Unidentified> unexplained;
  Gain gain;  ///< per coordinate of the tip [m]
  std::optional<Reproduction> check;
  std::vector<DataFinding> data;
  std::vector<std::string> warnings;
};

/// Diagnoses the error of the tip: link dimensions, and errors of encoders whose joints have no reference.
///
/// Where the frame of the tracker and the position of its target (9 parameters) are significantly different
/// from the model, they are causes, `frame` and `tool`.
/// @param present  effects that the spec already has: they are part of the model, and found lengths are added
/// to theirs
TipDiagnosis diagnose_tip(const OperationalModel&, const std::vector<Effect>& present, const Log&,
                          std::uint64_t seed, unsigned threads);

}  // namespace qerr
