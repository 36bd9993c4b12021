#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "qerr/report/filter_report.hpp"

namespace qerr {

/// A language in which filters are written: a row of `code_languages`.
struct CodeLanguage {
  std::string_view name, ending, summary;
  /// @throws Error (input) for a filter that the form cannot hold
  std::string (*write)(const FilterReport&);
};

/// C, Python, and chains of ROS filters.
const std::vector<CodeLanguage>& code_languages();

}  // namespace qerr
