#pragma once

#include <string>

#include "qerr/core/quantity.hpp"

namespace qerr {

/// A kind of quantity as people call it: "an angle", "a speed", "a quantity in N m/rad".
std::string name_of(const Dimension&);

/// "give an angle in rad, mrad, deg, arcmin or arcsec".
std::string unit_remedy(const Dimension&);

}  // namespace qerr
