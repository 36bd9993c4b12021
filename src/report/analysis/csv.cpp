#include "report/analysis/count_rates.hpp"
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

namespace {

/// Rates of counters whose limit is stated, beside their limits [counts/s].
std::string count_rate_rows(const Spec& spec, const std::string& before) {
  std::string out;
  std::optional<EncoderSpeeds> speeds;
  for (std::size_t i = 0; i < spec.encoder_figures.size(); ++i) {
    const std::optional<CountLimit> limit = count_limit(spec, i);
    if (!limit) continue;
    if (!speeds) speeds = encoder_speeds(spec);
    const std::string row = before + "counter,," + csv_cell(spec.model.chain.independent[i].name) + ",1/s,";
    if ((*speeds)[i])
      out += row + "count_rate,max," + csv_number(count_rate(spec, i, *(*speeds)[i])) + "\r\n";
    out += row + "max_count_rate,max," + csv_number(limit->rate) + "\r\n";
  }
  return out;
}

}  // namespace

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
  out += count_rate_rows(a.spec, before);
  return out;
}

}  // namespace qerr
