#include <algorithm>

#include "core/text.hpp"
#include "report/check/parts.hpp"

/// The table in Markdown (GitHub's dialect) that a job shows as its summary.
namespace qerr {

namespace {

/// A name in a cell: as code, in which only the bar and the backtick have a meaning.
std::string code(const std::string& name) {
  std::string text = "`";
  for (const char c : escaped(name, 200)) text += c == '|' ? "\\|" : std::string(1, c == '`' ? '\'' : c);
  return text + '`';
}

std::string row(std::initializer_list<std::string> cells) {
  std::string line = "|";
  for (const std::string& cell : cells) line += ' ' + cell + " |";
  return line + '\n';
}

std::string rows_of(const SpecCheck& check) {
  std::string out;
  for (std::size_t i = 0; i < check.results.size(); ++i) {
    const Requirement& r = check.analysis.spec.requirements[i];
    const RequirementResult& result = check.results[i];
    out += row({code(check.analysis.spec.file), code(limited(r)), readable(result.value, r.unit),
                result.met         ? "met"
                : result.undecided ? "**not proven**"
                                   : "**not met**"});
  }
  if (check.baseline)
    out += row({code(check.analysis.spec.file), "baseline " + code(check.baseline->file), "",
                check.baseline->regressions.empty() ? "met" : "**" + verdict(*check.baseline) + "**"});
  return out;
}

}  // namespace

std::string to_markdown(const CheckReport& report, const Style&) {
  std::string out = row({"spec", "requirement", "value", "verdict"}) + row({"---", "---", "---", "---"});
  for (const SpecCheck& check : report.specs) out += rows_of(check);
  for (const BrokenSpec& b : report.broken) out += row({code(b.file), "", "", "**cannot be checked**"});
  return out;
}

}  // namespace qerr
