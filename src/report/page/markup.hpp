#pragma once

#include <string>
#include <string_view>

/// Text and numbers in markup that is both HTML 5 and well-formed XML.
namespace qerr::page {

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

}  // namespace qerr::page
