#pragma once

#include <string>
#include <string_view>

namespace qerr {

/// SHA-256 (FIPS 180-4) of the bytes, as 64 hexadecimal digits: the fingerprint of a spec in its report.
std::string sha256(std::string_view bytes);

}  // namespace qerr
