#pragma once

#include <array>
#include <complex>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "report/text_table.hpp"

namespace qerr::page {

/// Text and numbers in markup that is both HTML 5 and well-formed XML.

/// The text for element content and for attributes in double quotes: `&`, `<`, `>`, `"` as entities. Control
/// characters, bytes that are no UTF-8 and code points that XML excludes become U+FFFD.
std::string escaped_markup(std::string_view text);

/// A name from outside in running text, isolated from the writing direction around it.
std::string name_markup(std::string_view name);

/// At most `most` code points of a name: the middle of a longer one is an ellipsis.
std::string shortened(std::string_view name, std::size_t most);

/// Width of a text in pictures, estimated from above for the sans-serif fonts of browsers [font sizes]:
/// more for capital letters, most for scripts with square characters.
double text_width(std::string_view text);

/// The text, shortened in its middle to the width [pixels] that is left for it.
std::string fitted(std::string_view text, double width, double font_size);

/// A coordinate in a picture, two decimals.
std::string drawn(double value);

/// ` name="value"` with every digit of the value.
std::string data_attribute(std::string_view name, double value);

/// Axes of pictures.

struct AxisRange {
  std::string label;      ///< the quantity
  std::string unit = {};  ///< SI, without a prefix; "" for a pure number
  bool logarithmic = false;
  bool prefix = true;  ///< an SI prefix by the size of the values
};

struct Tick {
  double value = 0;   ///< [SI]
  std::string label;  ///< in the unit of the axis' title
};

struct Axis {
  std::string title;  ///< quantity and unit with its SI prefix: `gain [krad/s]`
  bool logarithmic = false;
  double from = 0, to = 1;  ///< [SI]
  std::vector<Tick> ticks;
  double unit = 1;  ///< of the title [SI]

  /// Where a value lies: 0 at `from`, 1 at `to`.
  double part(double value) const;
};

/// An axis from a tick at or below `least` to one at or above `largest`, with round ticks: 1, 2 or 5 times a
/// power of ten, or powers of ten on a logarithmic axis (1, 2, 5 of each where it has less than two decades).
/// @param most  ticks, about
/// @pre finite values; on a logarithmic axis above 0
Axis axis(const AxisRange&, double least, double largest, int most = 6);

/// What pictures over two axes have in common.

/// Sizes of a picture and of the margins around its axes; the left one grows with its labels [pixels].
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
/// is shortened. For the script that zooms: `data-frame` has left, right, top and bottom [pixels],
/// `data-abscissa` and `data-ordinate` from and to [SI], 1 for a logarithmic axis, and the unit [SI].
std::string drawn_axes(const PictureFrame&);

std::string drawn_text(double x, double y, std::string_view style, const std::string& text);

/// A straight line, with further attributes.
std::string drawn_line(double x1, double y1, double x2, double y2, const std::string& style,
                       const std::string& attributes = "");

/// Opens `figure` and `svg`. @param attributes  of the latter
std::string figure_begin(const std::string& title, const std::string& description, double width,
                         double height, const std::string& attributes = "");

/// With the units of both axes for the script.
std::string figure_begin(const std::string& title, const std::string& description, const AxisRange& x,
                         const AxisRange& y);

/// Palette pictures as PNG (ISO/IEC 15948), small enough to stand in a page.

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

/// A figure over a grid of two quantities, as a palette picture inside SVG.

struct HeatMap {
  std::string title, description;
  AxisRange x, y, value;
  std::pair<double, double> x_span, y_span;  ///< of the grid [SI]
  std::size_t columns = 1, rows = 1;
  std::vector<double> cells;  ///< row by row from the least y [SI]; not finite: an empty cell
  bool equal_scales = false;  ///< a metre is as long on both axes
};

/// Every eighth of cividis (Nunez, Anderton, Renslow, PLOS ONE 2018); between them it is linear here.
extern const std::array<Colour, 9> cividis;

/// Steps of the scale: 0.4 % of its range is below what an eye tells apart.
inline constexpr int heat_steps = 255;

/// The picture with a colour bar. Colours are those of cividis: they rise in lightness with any colour
/// vision, and in black and white.
///
/// The value of a cell is rounded to a step of the scale: `data-from` and `data-to` of the picture are the
/// values of the palette's indices 1 and 255, index 0 is an empty cell; `data-span` has the edges of the
/// grid.
std::string figure(const HeatMap&);

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

namespace qerr::page {

/// A page that stands alone: HTML 5 that is also well-formed XML, without any request.

struct PageSection {
  std::string heading;
  std::string body;  ///< markup
};

struct Page {
  std::string title;
  std::string answer;  ///< one sentence, text
  std::vector<PageSection> sections;
  std::vector<std::string> warnings = {};
  std::string spec_file = {}, spec_text = {};  ///< as given; folded at the end
  std::string about = {};                      ///< markup below the answer (report/analysis/tables.hpp)
  std::string report = {};                     ///< JSON of the command, for scripts that read the page

  void add(const std::string& heading, const std::string& body) {
    if (!body.empty()) sections.push_back({heading, body});
  }
};

/// JSON within a page, which scripts read: no markup and no end of a section begins in it.
/// @param attributes  of its element, such as ` id="report"`
std::string json_script(std::string json, const std::string& attributes = "");

/// A cell with a bar below its text.
/// @param part    of the cell's width; beyond 1 in the colour of what fails
/// @param value   that the text stands for [SI]
/// @param colour  of those of lines
std::string bar_cell(const std::string& text, double part, double value, int colour = 0);

/// A cell of text; "" and names keep their writing direction to themselves.
std::string cell(const std::string& text);

/// A table whose rows are cells as markup.
/// @param style  its class
std::string table_of(std::string_view style, const std::vector<std::string>& header,
                     const std::vector<std::string>& rows);

/// A table for people and screen readers. The cells are text.
std::string table(const std::vector<std::string>& header, const TableRows& rows);

/// The HTML of a terminal's table, whose first row is the header.
/// @param corner  the header of the first column, where that has none
std::string table(TableRows rows, const std::string& corner = "");

/// Names and their markup as the block at the head of a page, which is left open: `</div>`.
std::string title_list(const std::vector<std::pair<std::string, std::string>>& entries);

/// Several figures of which one is shown at a time, chosen from a list by its name; all of them without a
/// script.
/// @param figures  name and markup; a single one has no list
std::string choice(const std::string& label, const std::vector<std::pair<std::string, std::string>>& figures);

/// No date and no path but the spec's as given: equal reports give equal bytes.
std::string markup(const Page&);

/// Bytes that the parts of a page leave for further ones below 300 kB, which a mail takes, beside style and
/// script; at least 40000, which a few figures take.
std::size_t bytes_left(const Page&);

/// The style sheet, without `<` and `&`, which XML would read. Colours of lines are those of Okabe and Ito,
/// told apart with any colour vision; dashes tell them apart in black and white.
extern const std::string_view style_sheet;

/// The script, without requests and without `]]>`. It shows the chosen figure; zooms plots and heat maps,
/// tells their values at the pointer and by keys, and switches series; turns the robot of a scene
/// (report/analysis/robot_figures.cpp). Without it every picture is there, still.
extern const std::string_view script;

/// Text between the pictures of a page.

/// The text with each run of a right-to-left script isolated (U+2068, U+2069), so that the numbers and words
/// beside a name keep their order, and written from the left (U+200E). Other texts are not changed.
std::string isolated_runs(const std::string& text);

/// A name among other words, which keeps its writing direction to itself.
std::string isolated(const std::string& name);

/// A paragraph; "" without text.
std::string paragraph(const std::string& text);

/// Items with dots; "" without any.
std::string list(const std::vector<std::string>& items);

/// A title within a section. @param name  text
std::string subtitle(const std::string& name);

/// The axis of a time that ends at `last` [s]: a thousand seconds are not a kilosecond.
AxisRange time_axis(double last);

/// Figures beside each other where there is space; "" without any.
std::string side_by_side(const std::string& figures);

}  // namespace qerr::page
