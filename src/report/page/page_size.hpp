#pragma once

#include <cstddef>

#include "report/page/page.hpp"

namespace qerr::page {

/// Bytes that the parts of a page, and its style and script, leave for further ones below 300 kB; at least
/// 40000, which a few figures take.
std::size_t bytes_left(const Page&);

}  // namespace qerr::page
