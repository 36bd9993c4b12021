#pragma once

#include <string_view>

namespace qerr::page {

/// The style sheet, without `<` and `&`, which XML would read. Colours of lines are those of Okabe and Ito,
/// told apart with any colour vision; dashes tell them apart in black and white.
extern const std::string_view style_sheet;

/// The script, below 5 kB, without `<` and `&`: shows the chosen figure, and the values of the line at the
/// pointer.
extern const std::string_view script;

}  // namespace qerr::page
