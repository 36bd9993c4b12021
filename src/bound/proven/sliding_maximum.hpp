#pragma once

#include <algorithm>
#include <cstddef>

namespace qerr {

/// Replaces row i of `rows` by the maximum of rows i .. i + window - 1, elementwise, for i <= count - window
/// (van Herk: maxima from the starts and to the ends of blocks).
/// @param values  [count][width]; rows beyond count - window are left undefined
/// @param memory  [count][width]
/// @pre 1 <= window <= count
template <class Number>
void sliding_maximum(Number* values, std::size_t count, std::size_t window, std::size_t width,
                     Number* memory) {
  for (std::size_t i = 0; i < count; ++i) {
    const Number* from = values + i * width;
    Number* to = memory + i * width;
    if (i % window == 0)
      std::copy(from, from + width, to);
    else
      for (std::size_t c = 0; c < width; ++c) to[c] = std::max(memory[(i - 1) * width + c], from[c]);
  }
  for (std::size_t i = count - 1; i-- > 0;) {
    if ((i + 1) % window == 0) continue;
    for (std::size_t c = 0; c < width; ++c)
      values[i * width + c] = std::max(values[i * width + c], values[(i + 1) * width + c]);
  }
  for (std::size_t i = 0; i + window <= count; ++i)
    for (std::size_t c = 0; c < width; ++c)
      values[i * width + c] = std::max(values[i * width + c], memory[(i + window - 1) * width + c]);
}

}  // namespace qerr
