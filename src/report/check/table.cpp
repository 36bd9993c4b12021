#include "report/formats.hpp"
#include "report/text_table.hpp"

namespace qerr {

std::string to_table(const CheckReport& report, const Style& style) {
  std::vector<std::vector<std::string>> rows;
  std::size_t failed = 0;
  for (std::size_t i = 0; i < report.results.size(); ++i) {
    const Requirement& r = report.analysis.spec.requirements[i];
    const auto [value, met] = report.results[i];
    failed += !met;
    rows.push_back({shown(r.quantity) + " " + r.statistic, readable(value, r.unit), met ? "<=" : ">",
                    readable(r.at_most, r.unit), met ? "met" : "NOT MET"});
  }
  const std::string all = counted(rows.size(), "requirement");
  return (rows.empty() ? "  the spec has no requirements\n" : aligned(rows)) +
         (failed ? painted(std::to_string(failed) + " of " + all + " not met", Paint::red, style)
                 : painted(all + " met", Paint::green, style)) +
         "\n";
}

}  // namespace qerr
