#include <algorithm>

#include "report/analysis/requirements.hpp"
#include "report/check/parts.hpp"
#include "report/compare/parts.hpp"
#include "report/formats.hpp"
#include "report/text_table.hpp"

namespace qerr {

std::string largest_place(const Analysis& a, const Eigen::VectorXd& q) {
  std::vector<std::string> joints;
  for (Eigen::Index i = 0; i < q.size(); ++i) {
    const IndependentJoint& joint = a.spec.model.chain.independent[static_cast<std::size_t>(i)];
    joints.push_back(shown(joint.name) + ' ' + readable(q[i], joint.prismatic() ? "m" : "rad"));
  }
  std::string out;
  for (std::size_t i = 0; i < joints.size(); ++i) out += (i ? ", " : "") + joints[i];
  return out;
}

namespace {

std::string table_of(const SpecCheck& check, const Style& style) {
  std::vector<std::vector<std::string>> rows;
  for (std::size_t i = 0; i < check.results.size(); ++i) {
    const Requirement& r = check.analysis.spec.requirements[i];
    const RequirementResult& result = check.results[i];
    const char* const relation = r.at_least ? (result.met ? ">=" : "<") : (result.met ? "<=" : ">");
    rows.push_back({shortened(r.quantity, 32) + (r.statistic.empty() ? "" : ' ' + r.statistic),
                    value_text(r, result.value), relation, readable(r.limit, r.unit),
                    result.met         ? "met"
                    : result.undecided ? "NOT PROVEN"
                                       : "NOT MET"});
  }
  const std::string text = aligned(rows);
  std::string out;
  std::size_t at = 0;
  for (std::size_t i = 0; i < check.results.size(); ++i) {
    const RequirementResult& result = check.results[i];
    const std::size_t end = text.find('\n', at);
    const std::string line = text.substr(at, end - at);
    at = end + 1;
    out += (result.met ? line : painted(line, Paint::red, style)) + '\n';
    if (!result.met && !check.analysis.spec.requirements[i].at_least && result.at_max.size() > 0)
      out += wrapped("largest at " + largest_place(check.analysis, result.at_max), style.width, "      ");
    if (result.undecided)
      out += wrapped("between " + readable(result.proven->lower, check.analysis.spec.requirements[i].unit) +
                         ", which is reached, and the proven bound: " + std::string(undecided_remedy),
                     style.width, "      ");
  }
  return out;
}

std::string baseline_table(const BaselineCheck& b, const Style& style) {
  const std::vector<FigureChange> worst = b.worst_by_quantity();
  const std::size_t shown_rows = std::min(worst.size(), most_regressions);
  std::string out = wrapped("Baseline: " + verdict(b), style.width);
  std::vector<std::vector<std::string>> rows{{"figure", "baseline", "now", "change"}};
  for (std::size_t i = 0; i < shown_rows; ++i)
    rows.push_back({shown(worst[i].figure.name()), readable(*worst[i].a, worst[i].figure.unit),
                    readable(*worst[i].b, worst[i].figure.unit), change_text(worst[i])});
  if (shown_rows > 0) out += fitted_table(rows, style.width);
  if (shown_rows < b.regressions.size())
    out += wrapped("and " + counted(b.regressions.size() - shown_rows, "more figure") + ": --format json",
                   style.width, "  ");
  for (const JudgedRequirement& r : b.dropped_requirements)
    out += wrapped("the baseline requires " + shown(r.figure.name()) + ", which the spec does not",
                   style.width, "  ");
  for (const NamedFigure& f : b.not_in_baseline)
    out += wrapped("the baseline has no " + shown(f.name()) + ", which the spec requires: it is not compared",
                   style.width, "  ");
  if (!b.missing.empty())
    out += wrapped("the spec lacks " + counted(b.missing.size(), "figure") + " of the baseline, such as " +
                       shown(b.missing.front().name()),
                   style.width, "  ");
  return out;
}

}  // namespace

std::string to_table(const CheckReport& report, const Style& style) {
  std::string out;
  std::size_t failed = 0, count = 0, worse = 0;
  const bool several = report.specs.size() + report.broken.size() > 1;
  for (const SpecCheck& check : report.specs) {
    if (several) out += painted(shown(check.analysis.spec.file), Paint::bold, style) + '\n';
    out += table_of(check, style);
    if (check.baseline) {
      out += baseline_table(*check.baseline, style);
      worse += check.baseline->regressions.size();
    }
    for (const RequirementResult& result : check.results) failed += !result.met;
    count += check.results.size();
  }
  for (const BrokenSpec& b : report.broken)
    out += painted(shown(b.file), Paint::bold, style) + "\n" +
           painted("  cannot be checked", Paint::red, style) + '\n';
  if (worse > 0)
    out += painted(counted(worse, "figure") + " worse than in the baseline", Paint::red, style) + '\n';
  if (count == 0) return out;
  const std::string all = counted(count, "requirement");
  const std::string unchecked =
      report.broken.empty()
          ? ""
          : painted(counted(report.broken.size(), "spec") + " not checked", Paint::red, style) + '\n';
  return out + unchecked +
         (failed ? painted(std::to_string(failed) + " of " + all + " not met", Paint::red, style)
                 : painted(all + " met", Paint::green, style)) +
         '\n';
}

}  // namespace qerr
