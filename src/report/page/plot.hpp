#pragma once

#include <complex>
#include <cstddef>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "report/page/frame.hpp"

namespace qerr::page {

/// Long records as lines of few points.

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

/// Lines and points over two axes, as SVG.

struct Series {
  std::string name;
  std::vector<std::pair<double, double>> points;  ///< [SI]; those that an axis cannot show are left out
  bool marks = false;                             ///< a mark at each point
  bool line = true;
  /// [point]: ordinate from, to [SI]: an error bar; empty: none. A pair that is not finite is left out.
  std::vector<std::pair<double, double>> intervals = {};
  bool band = false;  ///< the area between the intervals in place of error bars
  std::vector<std::pair<double, double>> marked = {};  ///< [SI]: marks beside those of `points`, untitled
  bool dots = false;                                   ///< in place of the line
};

/// A limit. One that would squeeze the data into a fifth of a linear axis is named in the legend only.
struct Marker {
  std::string name;
  double value = 0;
};

struct Plot {
  std::string title;        ///< for screen readers, and the heading
  std::string description;  ///< for screen readers: what one sees
  AxisRange x, y;
  std::vector<Series> series;
  std::vector<Marker> markers = {};  ///< on the abscissa
  bool equal_scales = false;         ///< a metre is as long on both axes
  std::vector<Marker> levels = {};   ///< limits on the ordinate
};

/// The picture with its legend. Lines differ in colour and in dashes, marks in colour and in shape: 25
/// combinations. A line carries its values as `data-points="x,y x,y"` with six digits, a band as
/// `data-band="x,from,to x,from,to"`, a mark all digits as `data-x`, `data-y`, an error bar as `data-from`,
/// `data-to`, a limit as `data-limit`.
std::string figure(const Plot&);

/// Horizontal bars from zero, as SVG.

struct Bar {
  std::string name;
  double value = 0;                                     ///< [SI], not negative
  std::string text;                                     ///< the value for people
  std::optional<std::pair<double, double>> error = {};  ///< from, to [SI]
  int colour = 0;                                       ///< of those of lines, 0 to 4
};

struct Bars {
  std::string title, description;
  std::vector<Bar> bars;
  AxisRange axis = {"", "%"};        ///< with the unit %, values are parts of 1
  std::optional<double> limit = {};  ///< a line across all bars [SI]
};

/// One bar below the other, in the order given, over one axis; each with its name above it. A bar carries its
/// value as `data-value`, the name as `data-name`.
std::string figure(const Bars&);

}  // namespace qerr::page

namespace qerr {

/// sum_k values[k] e^{-2 pi i n k / N} for n = 0 .. N/2, N the number of values.
/// @pre N is even
std::vector<std::complex<double>> half_spectrum(const std::vector<double>& values);

}  // namespace qerr
