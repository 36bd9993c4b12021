#include <algorithm>
#include <cmath>

#include "core/text.hpp"
#include "report/analysis/effects.hpp"
#include "report/analysis/tables.hpp"
#include "report/text_table.hpp"

namespace qerr {

namespace {

/// By how much sigma falls if a share of the variance vanishes.
double fall_of_sigma(double share) { return 1 - std::sqrt(std::max(0.0, 1 - share)); }

std::vector<std::string> row_of(const std::string& name, const std::string& count,
                                const std::string& accuracy, const BudgetParts& p, bool effects) {
  std::vector<std::string> row{name, count, accuracy, percent(p.quantization), percent(p.accuracy)};
  if (effects) row.push_back(percent(p.effects));
  return row;
}

}  // namespace

std::string accuracy_table(const Analysis& a, const Style& style) {
  if (!states_accuracy(a.spec)) return "";
  const std::vector<BudgetParts> parts = budget_parts(a);
  BudgetParts sum;
  for (const BudgetParts& p : parts) {
    sum.quantization += p.quantization;
    sum.accuracy += p.accuracy;
    sum.effects += p.effects;
  }
  const bool effects = sum.effects > 0;
  std::vector<std::vector<std::string>> rows{
      {"encoder", "half a count", "accuracy", "resolution", "accuracy"}};
  rows[0][3] = "share of resolution";
  rows[0][4] = "share of accuracy";
  if (effects) rows[0].emplace_back("share of effects");
  for (std::size_t e = 0; e < parts.size(); ++e) {
    const IndependentJoint& joint = a.spec.model.chain.independent[e];
    const Encoder& encoder = a.spec.model.transmission.encoders[e];
    const double slow = encoder.accuracy + encoder.gear_accuracy;
    const std::string unit = joint.prismatic() ? "m" : "rad";
    rows.push_back(row_of(shortened(joint.name, 22), readable(0.5 * encoder.resolution, unit),
                          slow > 0 ? readable(slow, unit) : "", parts[e], effects));
  }
  rows.push_back(row_of("all", "", "", sum, effects));
  return heading("Accuracy or resolution: where the tip's variance comes from", style) +
         fitted_table(rows, style.width) +
         wrapped("without the accuracies sigma would be " + percent(fall_of_sigma(sum.accuracy)) +
                     " less, with infinitely fine counts " + percent(fall_of_sigma(sum.quantization)) +
                     " less",
                 style.width, "  ");
}

}  // namespace qerr
