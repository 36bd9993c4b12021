#include "report/page/page_size.hpp"

#include "report/page/page_style.hpp"

namespace qerr::page {

std::size_t bytes_left(const Page& page) {
  // Some texts are given without the entities and elements around them: a reserve of 25 kB.
  constexpr std::size_t most = 275000, fewest = 40000;
  std::size_t taken =
      style_sheet.size() + script.size() + page.answer.size() + page.about.size() + page.spec_text.size();
  for (const Section& s : page.sections) taken += s.heading.size() + s.body.size();
  for (const std::string& w : page.warnings) taken += w.size();
  return most > taken + fewest ? most - taken : fewest;
}

}  // namespace qerr::page
