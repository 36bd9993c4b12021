#pragma once

#include "qerr/design/threshold.hpp"
#include "qerr/input/spec.hpp"

namespace qerr {

/// The spec's row of Table IV: the joint with the largest l Delta.
///
/// l is `threshold: {length}`, or else that joint's largest entry of the position Jacobian over the
/// configurations.
/// @throws Error (input; key `filters`) when the spec has no derivative filter to take the sample rate from
ThresholdRow threshold_row(const Spec&, unsigned threads);

}  // namespace qerr
