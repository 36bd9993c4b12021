#pragma once

#include <string>

#include "qerr/core/parameter.hpp"

namespace qerr {

/// SI unit of a number, `rad or m` of a joint coordinate; "" for a pure number and for other kinds.
std::string parameter_unit(const Parameter&);

}  // namespace qerr
