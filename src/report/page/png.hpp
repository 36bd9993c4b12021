#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

/// Palette pictures as PNG (ISO/IEC 15948), small enough to stand in a page.
namespace qerr::page {

using Colour = std::array<std::uint8_t, 3>;  ///< red, green, blue

/// The picture as PNG with eight bits a pixel. Colour 0 is transparent.
///
/// Deflate (RFC 1951) with the fixed code and matches of distance 1: runs, such as an empty surrounding, take
/// few bits, and no library is needed.
/// @param pixels   indices into the palette, row by row from the top; width * height
/// @param palette  1 to 256 colours
std::string png(std::size_t width, std::size_t height, const std::vector<std::uint8_t>& pixels,
                const std::vector<Colour>& palette);

/// RFC 4648.
std::string base64(std::string_view bytes);

}  // namespace qerr::page
