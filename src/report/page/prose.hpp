#pragma once

#include <string>
#include <vector>

#include "report/page/frame.hpp"

/// Text between the pictures of a page.
namespace qerr::page {

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
