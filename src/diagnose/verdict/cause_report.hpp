#pragma once

#include "diagnose/inference/explanation.hpp"
#include "diagnose/inference/finding.hpp"
#include "qerr/diagnose/diagnosis.hpp"

namespace qerr {

/// Adds one encoder's causes, their alternatives and its unexplained errors to the diagnosis.
/// @param gain  of its joint
void add(Diagnosis&, const Finding&, const Gain& gain);

/// The residual without one term of a fitted model, in bins of the quantity that the term depends on: the one
/// of angle, speed, time, effort, temperature and (of a periodic term) angle within its period of which its
/// addition varies least within a bin.
ResidualCurve residual_curve(const Evidence&, const Explanation&, std::size_t term);

}  // namespace qerr
