#pragma once

#include <string>
#include <string_view>

namespace qerr {

/// Which recording tells two causes apart.
std::string record_advice(std::string_view one, std::string_view other);

}  // namespace qerr
