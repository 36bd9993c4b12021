#pragma once

#include <string>
#include <utility>
#include <vector>

#include "report/page/axis.hpp"

/// Lines and points over two axes, as SVG.
namespace qerr::page {

struct Series {
  std::string name;
  std::vector<std::pair<double, double>> points;  ///< [SI]; those that an axis cannot show are left out
  bool marks = false;                             ///< a mark at each point
  bool line = true;
};

/// A limit on the abscissa.
struct Marker {
  std::string name;
  double value = 0;
};

struct Plot {
  std::string title;        ///< for screen readers, and the heading
  std::string description;  ///< for screen readers: what one sees
  AxisRange x, y;
  std::vector<Series> series;
  std::vector<Marker> markers = {};
  bool equal_scales = false;  ///< a metre is as long on both axes
};

/// The picture with its legend. Lines differ in colour and in dashes; a line carries its values as
/// `data-points="x,y x,y"` with six digits, a mark all digits as `data-x`, `data-y`.
std::string figure(const Plot&);

}  // namespace qerr::page
