#include <algorithm>
#include <cmath>

#include "core/text.hpp"
#include "report/analysis/about.hpp"
#include "report/analysis/control.hpp"
#include "report/analysis/figure_names.hpp"
#include "report/analysis/page/pictures.hpp"
#include "report/analysis/requirements.hpp"
#include "report/formats.hpp"
#include "report/page/page.hpp"
#include "report/text_table.hpp"

namespace qerr {

namespace {

/// Standard deviation of the position: of |(x, y, z)| [m]; empty without all three.
std::optional<double> position_sigma(const Analysis& a, const Eigen::MatrixXd& covariance) {
  const std::vector<Coordinate>& all = a.spec.model.coordinates;
  double sum = 0;
  int found = 0;
  for (std::size_t i = 0; i < all.size() && static_cast<Eigen::Index>(i) < covariance.rows(); ++i)
    if (is_position(all[i]))
      sum += covariance(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(i)), ++found;
  return found == 3 && std::isfinite(sum) ? std::optional(std::sqrt(sum)) : std::nullopt;
}

/// The error of xyz, or the first figures of the tip if it has no such three.
std::string tip_sentence(const Analysis& a) {
  std::string text = "Over " + counted(a.workspace.count, "configuration") + " the tip's ";
  const auto mean = position_sigma(a, a.workspace.mean_covariance),
             most = position_sigma(a, a.workspace.covariance_at_largest);
  if (mean && most)
    return text + "position xyz has a sigma of " + readable(*mean, "m") + " rms, and of " +
           readable(*most, "m") + " where it is largest";
  bool said = false;
  for_each_figure(a, [&](const FigureName& name, const Statistic& s) {
    if (said || name.bound != "worst_case") return;
    said = true;
    text += std::string(name.coordinate) + " is off by at most " + readable(s.max, name.shown_unit) +
            ", at the median by " + readable(s.p50, name.shown_unit);
  });
  return text;
}

/// The first requirement that is not met, else the first.
std::string requirement_sentence(const Spec& spec, const std::vector<RequirementResult>& results) {
  if (results.empty()) return "";
  std::size_t i = 0;
  for (std::size_t k = results.size(); k-- > 0;)
    if (!results[k].met) i = k;
  std::string kept = margin_text(spec.requirements[i], results[i]);
  if (!kept.empty())
    kept = kept[0] == '-' ? ", beyond its limit by " + kept.substr(1) : ", a margin of " + kept;
  return "; " + page::isolated(limited(spec.requirements[i])) + " is " +
         (results[i].met         ? "met"
          : results[i].undecided ? "not proven"
                                 : "not met") +
         " with " + readable(results[i].value, spec.requirements[i].unit) + kept;
}

/// The error of the tip, the first requirement, and the encoder to improve.
std::string answer(const Analysis& a, const std::optional<std::vector<RequirementResult>>& results) {
  std::string text = tip_sentence(a) + (results ? requirement_sentence(a.spec, *results) : "");
  const std::vector<double> budget = encoder_budget(a);
  const auto largest = std::max_element(budget.begin(), budget.end());
  if (largest != budget.end() && *largest > 0)
    text += "; the first encoder to upgrade is that of " +
            page::isolated(
                a.spec.model.chain.independent[static_cast<std::size_t>(largest - budget.begin())].name) +
            ", with " + percent(*largest) + " of the variance";
  return text + '.';
}

/// As requirements name it; the filter's name keeps its writing direction to itself.
std::string isolated_quantity(const FigureName& name) {
  const std::string quantity = name.quantity();
  return name.filter.empty() ? quantity : page::isolated(name.filter) + quantity.substr(name.filter.size());
}

std::string summary(const Analysis& a) {
  TableRows rows;
  for_each_figure(a, [&](const FigureName& name, const Statistic& s) {
    const ProvenMaximum* proof = find_proof(a, name.figure);
    rows.push_back({isolated_quantity(name), readable(s.p50, name.shown_unit),
                    readable(s.p95, name.shown_unit), readable(s.p99, name.shown_unit),
                    readable(s.max, name.shown_unit),
                    proof ? readable(proof->upper, name.shown_unit) : "not asked for"});
  });
  return page::table({"quantity", "median", "p95", "p99", "max", "proven maximum"}, rows);
}

/// Torques, loops and walls of a spec with controllers; "" without.
std::string control_part(const Analysis& a) {
  std::string out;
  if (a.control)
    for (ControlTable& table : control_tables(a.spec, *a.control)) {
      if (!table.rows.empty())
        out += page::subtitle(table.title) + page::table(std::move(table.rows), "name");
      for (const std::string& note : table.notes) out += page::paragraph(note + '.');
    }
  return out;
}

std::optional<std::vector<RequirementResult>> verdicts_of(const Analysis& a) {
  try {
    return requirement_results(a);
  } catch (const Error&) {  // one that cannot be judged is no reason for no page
    return std::nullopt;
  }
}

}  // namespace

page::Page page_of(const Analysis& a) {
  const ConfigurationSample sample = configuration_sample(a);
  const auto results = verdicts_of(a);
  page::Page page{
      "Accuracy of " + a.spec.robot_name,
      answer(a, results),
      {{"The robot where its position is least certain, and where it is as usual", robot_figures(a, sample)},
       {"Error budget of the encoders", budget_figures(a)},
       {"Distribution over the configurations", distribution_figures(a, sample)},
       {"Error over the workspace", workspace_figures(a, sample)},
       {"All figures", summary(a)}},
      a.warnings};
  if (std::string control = control_part(a); !control.empty())
    page.sections.insert(page.sections.begin() + 1, {"Torques, loops and walls", std::move(control)});
  describe(page, a.spec, results);
  return page;
}

}  // namespace qerr
