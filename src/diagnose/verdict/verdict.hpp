#pragma once

#include "qerr/diagnose/diagnosis.hpp"

namespace qerr {

/// The verdict of a diagnosis by its causes, alternatives and unidentified residuals: without causes
/// `nothing_wrong` or `unexplained`; with alternatives `ambiguous`; else `explained`, or `partly_explained`
/// if an unidentified residual matters.
/// @param judged  whether the position of any joint, or of the tip, could be judged
Verdict verdict(const Diagnosis&, bool judged);

}  // namespace qerr
