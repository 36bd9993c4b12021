#pragma once

#include <vector>

#include "qerr/report/filter_report.hpp"

namespace qerr {

/// For every filter the noise of every encoder in every motion; an encoder is skipped if the motion's unit is
/// not that of its joint.
std::vector<FilterNoise> noise_report(const Spec&, const std::vector<MotionQuestion>&);

/// For every encoder and every sine among the motions.
std::vector<SineErrorRow> sine_errors(const Spec&, const std::vector<MotionQuestion>&);

}  // namespace qerr
