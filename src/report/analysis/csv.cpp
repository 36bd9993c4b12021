#include "report/analysis/figure_names.hpp"
#include "report/csv_text.hpp"
#include "report/formats.hpp"

namespace qerr {

std::string to_csv(const Analysis& a, const Style&) {
  return std::string(analysis_csv_header) + "\r\n" + analysis_csv_rows(a, "", all_statistics());
}

std::vector<const StatisticKind*> all_statistics() {
  std::vector<const StatisticKind*> all;
  for (const StatisticKind& kind : statistic_kinds()) all.push_back(&kind);
  return all;
}

std::string analysis_csv_rows(const Analysis& a, const std::string& before,
                              const std::vector<const StatisticKind*>& statistics) {
  std::string out;
  for_each_figure(a, [&](const FigureName& name, const Statistic& s) {
    const std::string prefix = before + std::string(name.signal) + ',' + csv_cell(name.filter) + ',' +
                               csv_cell(name.coordinate) + ',' + name.unit + ',' + std::string(name.bound) +
                               ',';
    for (const StatisticKind* kind : statistics)
      out += prefix + std::string(kind->name) + ',' + csv_number(s.*kind->value) + "\r\n";
    const ProvenMaximum* const proven = find_proof(a, name.figure);
    if (!proven) return;
    out += prefix + "proven_lower," + csv_number(proven->lower) + "\r\n";
    out += prefix + std::string(proven_statistic) + ',' + csv_number(proven->upper) + "\r\n";
  });
  for (const StatisticKind* kind : statistics) {
    if (kind->name != "mean") continue;  // the encoders' parts of the mean variance
    const std::vector<double> budget = encoder_budget(a);
    for (std::size_t i = 0; i < budget.size(); ++i)
      out += before + "budget,," + csv_cell(a.spec.model.chain.independent[i].name) + ",,share,mean," +
             csv_number(budget[i]) + "\r\n";
  }
  for (const SingleFigure& f : single_figures(a)) {
    const std::size_t first = f.quantity.find('.'), last = f.quantity.rfind('.');
    out += before + f.quantity.substr(0, first) + ",," +
           csv_cell(f.quantity.substr(first + 1, last - first - 1)) + ',' + f.unit + ',' +
           f.quantity.substr(last + 1) + ',' + std::string(f.statistic) + ',' + csv_number(f.value) + "\r\n";
  }
  return out;
}

}  // namespace qerr
