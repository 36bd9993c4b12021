#include "report/formats.hpp"
#include "report/list/parameter_unit.hpp"
#include "report/text_table.hpp"
#include "report/wrapped_text.hpp"

namespace qerr {

namespace {

/// Name, unit, meaning, choices and default in one sentence.
std::string described(const Parameter& p) {
  std::string text(p.name);
  if (const std::string unit = parameter_unit(p); !unit.empty()) text += " [" + unit + ']';
  text += ": " + std::string(p.meaning);
  if (!p.choices.empty()) {
    text += " (";
    const std::vector<std::string> words = choices_of(p);
    for (std::size_t i = 0; i < words.size(); ++i)
      text += (i ? ", " : "") + words[i] + (i ? "" : " by default");
    text += ')';
  }
  if (p.fallback) text += " (default " + shortest(*p.fallback) + ')';
  if (p.required) text += " (required)";
  return text;
}

}  // namespace

std::string to_table(const ListReport& report, const Style& style) {
  std::string out;
  for (const ListReport::Row& row : report.rows) {
    out += painted(row.name, Paint::bold, style) + '\n' + wrapped(row.summary, style.width, "    ");
    for (const auto& [name, text] : row.notes) out += wrapped(name + ": " + text, style.width, "    ");
    for (const Parameter& p : row.parameters) out += wrapped(described(p), style.width, "      ", "    - ");
  }
  return out;
}

}  // namespace qerr
