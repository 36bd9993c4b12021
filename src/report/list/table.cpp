#include "report/formats.hpp"
#include "report/list/parameter_unit.hpp"
#include "report/text_table.hpp"

namespace qerr {

std::string to_table(const ListReport& report, const Style&) {
  std::string out;
  for (const ListReport::Row& row : report.rows) {
    out += row.name + "\n    " + row.summary + '\n';
    for (const auto& [name, text] : row.notes) out += "    " + name + ": " + text + '\n';
    for (const Parameter& p : row.parameters) {
      out += "    - " + std::string(p.name);
      if (const std::string unit = parameter_unit(p); !unit.empty()) out += " [" + unit + ']';
      out += ": " + std::string(p.meaning);
      if (!p.choices.empty()) {
        out += " (";
        const std::vector<std::string> words = choices_of(p);
        for (std::size_t i = 0; i < words.size(); ++i)
          out += (i ? ", " : "") + words[i] + (i ? "" : " by default");
        out += ')';
      }
      if (p.fallback) out += " (default " + shortest(*p.fallback) + ')';
      if (p.required) out += " (required)";
      out += '\n';
    }
  }
  return out;
}

}  // namespace qerr
