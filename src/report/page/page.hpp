#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "report/page/frame.hpp"
#include "report/text_table.hpp"

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
