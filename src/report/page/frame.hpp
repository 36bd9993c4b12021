#pragma once

#include <string>
#include <string_view>

#include "report/page/axis.hpp"

/// What pictures over two axes have in common.
namespace qerr::page {

/// Of a picture and of the margins around the area of its axes; the left one grows with its labels [pixels].
inline constexpr double picture_width = 400, picture_height = 250;
inline constexpr double least_left = 40, right_margin = 14, top_margin = 22, bottom_margin = 40;

struct PictureFrame {
  Axis x, y;
  double left = least_left, right = picture_width - right_margin;
  double title_room = picture_width - 8;  ///< of the ordinate's title

  double at_x(double value) const { return left + x.part(value) * (right - left); }
  double at_y(double value) const {
    return picture_height - bottom_margin - y.part(value) * (picture_height - top_margin - bottom_margin);
  }
};

/// The area of the axes: it leaves room for the labels of the ordinate.
/// @param right  end of the area [pixels]
PictureFrame framed(Axis x, Axis y, double right = picture_width - right_margin);

/// The axis from `least` to `largest` themselves, not to round numbers.
Axis unrounded(const AxisRange&, double least, double largest);

/// Grid, ticks and titles; a tick whose label would touch the one before has none, a title that is too long
/// is shortened.
std::string drawn_axes(const PictureFrame&);

/// Text in the class of the style sheet.
std::string drawn_text(double x, double y, std::string_view style, const std::string& text);

/// A straight line, with further attributes.
std::string drawn_line(double x1, double y1, double x2, double y2, const std::string& style,
                       const std::string& attributes = "");

/// Opens `figure` and `svg`, with the units of both axes for the script.
std::string figure_begin(const std::string& title, const std::string& description, const AxisRange& x,
                         const AxisRange& y);

}  // namespace qerr::page
