#pragma once

#include <cstddef>
#include <utility>
#include <vector>

/// Long records as lines of few points.
namespace qerr::page {

/// The smallest and the largest ordinate in each of equal intervals of the abscissa. A line through them, in
/// the order of the abscissa, covers what a line through all points covers, if an interval is a pixel.
class Envelope {
 public:
  /// @param intervals  at least 1
  Envelope(double from, double to, std::size_t intervals);

  /// In any order; of equal ordinates, the first one counts.
  void add(double x, double y) {
    const double place = (x - from_) * per_unit_;
    const auto i = place > 0 ? static_cast<std::size_t>(place) : 0;
    Cell& c = cells_[i < cells_.size() ? i : cells_.size() - 1];
    if (y < c.least) c.least = y, c.at_least = x;
    if (y > c.largest) c.largest = y, c.at_largest = x;
  }

  /// At most two per interval; each is a point that was added.
  std::vector<std::pair<double, double>> points() const;

 private:
  struct Cell {
    double least, at_least, largest, at_largest;
  };
  double from_, per_unit_;
  std::vector<Cell> cells_;
};

}  // namespace qerr::page
