#include <algorithm>
#include <cmath>

#include "core/text.hpp"
#include "report/analysis/about.hpp"
#include "report/analysis/figure_names.hpp"
#include "report/analysis/page/pictures.hpp"
#include "report/analysis/requirements.hpp"
#include "report/formats.hpp"
#include "report/page/prose.hpp"
#include "report/text_table.hpp"

namespace qerr {

namespace {

/// The first figures of the tip, and the encoder to improve.
std::string answer(const Analysis& a) {
  std::string text;
  for_each_figure(a, [&](const FigureName& name, const Statistic& s) {
    if (!text.empty() || name.bound != "worst_case") return;
    text = "Over " + std::to_string(a.workspace.count) + " configurations the tip's " +
           std::string(name.coordinate) + " is off by at most " + readable(s.max, name.shown_unit) +
           ", at the median by " + readable(s.p50, name.shown_unit);
  });
  const std::vector<double> budget = encoder_budget(a);
  const auto largest = std::max_element(budget.begin(), budget.end());
  if (largest != budget.end() && *largest > 0)
    text += "; the largest share of the variance, " + percent(*largest) + ", is due to encoder " +
            page::isolated(
                a.spec.model.chain.independent[static_cast<std::size_t>(largest - budget.begin())].name);
  return text + '.';
}

/// As requirements name it; the filter's name keeps its writing direction to itself.
std::string isolated_quantity(const FigureName& name) {
  const std::string quantity = name.quantity();
  return name.filter.empty() ? quantity : page::isolated(name.filter) + quantity.substr(name.filter.size());
}

std::string summary(const Analysis& a) {
  std::vector<std::vector<std::string>> rows;
  for_each_figure(a, [&](const FigureName& name, const Statistic& s) {
    const ProvenMaximum* proof = find_proof(a, name.figure);
    rows.push_back({isolated_quantity(name), readable(s.p50, name.shown_unit),
                    readable(s.p95, name.shown_unit), readable(s.p99, name.shown_unit),
                    readable(s.max, name.shown_unit),
                    proof ? readable(proof->upper, name.shown_unit) : "not asked for"});
  });
  return page::table({"quantity", "median", "p95", "p99", "max", "proven maximum"}, rows);
}

std::optional<std::vector<RequirementResult>> verdicts_of(const Analysis& a) {
  try {
    return requirement_results(a);
  } catch (const Error&) {  // one that cannot be judged is no reason for no page
    return std::nullopt;
  }
}

}  // namespace

std::string to_html(const Analysis& a, const Style&) {
  const ConfigurationSample sample = configuration_sample(a);
  page::Page page{
      "Accuracy of " + a.spec.robot_name,
      answer(a),
      {{"Error budget of the encoders", budget_figures(a)},
       {"The robot where its position is least certain, and where it is as usual", robot_figures(a, sample)},
       {"Error over the workspace", workspace_figures(a, sample)},
       {"Distribution over the configurations", distribution_figures(a, sample)},
       {"All figures", summary(a)}},
      a.warnings};
  describe(page, a.spec, verdicts_of(a));
  return markup(page);
}

}  // namespace qerr
