#pragma once

namespace qerr {

/// Below this cosine of pitch Euler angles have no rates: a thousand times the 1e-15 to which a chain of
/// joints rounds the axis of its tip.
inline constexpr double gimbal_lock = 1e-12;

}  // namespace qerr
