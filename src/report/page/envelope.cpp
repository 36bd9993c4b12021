#include "report/page/envelope.hpp"

#include <cmath>

namespace qerr::page {

Envelope::Envelope(double from, double to, std::size_t intervals)
    : from_(from),
      per_unit_(to > from ? static_cast<double>(intervals) / (to - from) : 0),
      cells_(intervals, Cell{INFINITY, 0, -INFINITY, 0}) {}

std::vector<std::pair<double, double>> Envelope::points() const {
  std::vector<std::pair<double, double>> all;
  for (const Cell& c : cells_) {
    if (!(c.least <= c.largest)) continue;
    const std::pair low{c.at_least, c.least}, high{c.at_largest, c.largest};
    all.push_back(c.at_least <= c.at_largest ? low : high);
    if (low != high) all.push_back(c.at_least <= c.at_largest ? high : low);
  }
  return all;
}

}  // namespace qerr::page
