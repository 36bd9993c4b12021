#pragma once

namespace qerr {

/// Below this cosine of pitch the rates of roll and yaw are unbounded: the axes of yaw and roll are parallel
/// to the rounding of a chain of joints.
inline constexpr double gimbal_lock = 1e-12;

}  // namespace qerr
