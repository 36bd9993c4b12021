#pragma once

#include <string>
#include <utility>
#include <vector>

/// A page that stands alone: HTML 5 that is also well-formed XML, without any request.
namespace qerr::page {

struct Section {
  std::string heading;
  std::string body;  ///< markup
};

struct Page {
  std::string title;
  std::string answer;  ///< one sentence, text
  std::vector<Section> sections;
  std::vector<std::string> warnings = {};
  std::string spec_file = {}, spec_text = {};  ///< as given; folded at the end
  std::string about = {};                      ///< markup below the answer (report/analysis/about.hpp)
};

/// A table for people and screen readers. The cells are text.
std::string table(const std::vector<std::string>& header, const std::vector<std::vector<std::string>>& rows);

/// Several figures of which one is shown at a time, chosen from a list by its name; all of them without a
/// script.
/// @param figures  name and markup; a single one has no list
std::string choice(const std::string& label, const std::vector<std::pair<std::string, std::string>>& figures);

/// No date and no path but the spec's as given: equal reports give equal bytes.
std::string markup(const Page&);

}  // namespace qerr::page
