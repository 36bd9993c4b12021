#pragma once

#include <cstdint>
#include <vector>

#include "qerr/diagnose/diagnosis.hpp"

namespace qerr {

/// What a tracked tip adds to a diagnosis.
struct TipDiagnosis {
  bool judged = false;  ///< the log has a tip, and all joints
  std::vector<Cause> causes;
  std::vector<AlternativeCause> alternatives;
  std::vector<Unidentified> unexplained;
  Gain gain;  ///< per coordinate of the tip [m]
  std::vector<std::string> warnings;
};

/// Judges the tip: `geometry`, and every cause of encoders that have no better sensor of their own, by what
/// it does to the tip.
///
/// A tracker that stands in a frame of its own, or looks at a target beside the model's tip, is found where
/// these 9 numbers explain more than chance, and is taken out; the gain is then counted from what is left.
/// @param present  effects that the spec already has: the tip is judged with them, new lengths come on top
TipDiagnosis diagnose_tip(const OperationalModel&, const std::vector<Effect>& present, const Log&,
                          std::uint64_t seed, unsigned threads);

}  // namespace qerr
