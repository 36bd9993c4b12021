#pragma once

#include <string>
#include <vector>

/// Text between the pictures of a page.
namespace qerr::page {

/// A paragraph; "" without text.
std::string paragraph(const std::string& text);

/// Items with dots; "" without any.
std::string list(const std::vector<std::string>& items);

/// A title within a section. @param name  text
std::string subtitle(const std::string& name);

/// Figures beside each other where there is space; "" without any.
std::string side_by_side(const std::string& figures);

}  // namespace qerr::page
