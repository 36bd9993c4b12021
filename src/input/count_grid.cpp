#include "input/count_grid.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace qerr {

namespace {

constexpr int finest_grid = 1024;  // an interpolation by more is given as periods and interpolation_bits
constexpr double part_unit = 0x1p-30;

}  // namespace

bool CountGrid::add(double value) {
  largest_ = std::max(largest_, std::abs(value));
  parts_.insert(std::llround(std::remainder(value, 1.0) / part_unit));
  return parts_.size() <= 4 * finest_grid;  // either sign, and neighbours by the rounding of a double
}

int CountGrid::denominator(int decimals) const {
  const double rounding = 0.5 * std::pow(10.0, -decimals) + largest_ * 0x1p-52 + part_unit;
  int common = 1;
  for (const std::int64_t part : parts_) {
    const double fraction = static_cast<double>(part) * part_unit;
    const auto is_multiple = [&](int n) {
      return std::abs(std::remainder(fraction * n, 1.0)) <= rounding * n;
    };
    if (is_multiple(common)) continue;
    int own = 2;
    while (own <= finest_grid && !is_multiple(own)) ++own;
    common = std::lcm(own, common);
    if (common > finest_grid) return 0;
  }
  return common;
}

}  // namespace qerr
