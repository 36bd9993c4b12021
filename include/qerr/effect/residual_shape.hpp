#pragma once

#include <string_view>

namespace qerr {

/// Shape of a residual that no effect of the catalogue has.
enum class Shape { step, hysteresis, exponential, line, order, bump, by_count, noise, unknown };

/// "step", "hysteresis", ...
std::string_view name(Shape);

}  // namespace qerr
