#pragma once

#include <string>
#include <vector>

#include "qerr/report/write.hpp"

namespace qerr {

/// Points and a line over the same abscissae, in characters.
struct TextPicture {
  std::vector<double> at;      ///< ascending
  std::vector<double> points;  ///< one per abscissa, NaN: none
  std::vector<double> line;    ///< the same; empty: no line
  std::string points_name, line_name;
  std::string ordinate, abscissa;  ///< names of the axes, with units
};

/// The smallest of 1, 2, 5 times a power of ten that is at least `least`, but for a relative tolerance.
double round_step(double least, double tolerance = 0);

/// The picture, at most ten rows high between its legend and its abscissa, in lines of at most
/// `style.width` columns, behind an indent. Ticks are at 1, 2, 2.5 or 5 times a power of ten; zero is always
/// in the range. A gap in the line remains a gap; between abscissae that are wider apart than a
/// column, the line is interpolated. "" if fewer than two abscissae have a finite value.
std::string text_picture(const TextPicture&, const Style&, const std::string& indent = "    ");

}  // namespace qerr
