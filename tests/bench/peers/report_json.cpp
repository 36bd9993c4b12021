#include <cmath>
#include <nlohmann/json.hpp>

#include "report.hpp"

namespace qerr::bench {

namespace {

using Json = nlohmann::ordered_json;

Json number(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }
Json number(const std::optional<double>& value) { return value ? number(*value) : Json(nullptr); }

Json of(const ContestantResult& c) {
  Json stages_of = Json::object();
  for (std::size_t s = 0; s < stages.size(); ++s)
    if (c.rates[s])
      stages_of[stage_names[s]] = {{"best", c.rates[s]->best},
                                   {"median", c.rates[s]->median},
                                   {"fma_pipe_operations", number(c.fma_pipe_operations[s])},
                                   {"fraction_of_fma_bound", number(c.fraction_of_bound[s])}};
  const Deviation& d = c.deviation;
  return {{"name", c.name},
          {"built", c.built},
          {"instruction_set", c.instruction_set.empty() ? Json(nullptr) : Json(c.instruction_set)},
          {"agrees", d.agrees()},
          {"deviation",
           {{"jacobian", number(d.jacobian)},
            {"worst_case", number(d.worst_case)},
            {"covariance", number(d.covariance)},
            {"summary", number(d.summary)},
            {"quantile", number(d.quantile)}}},
          {"configurations_per_second", stages_of}};
}

}  // namespace

std::string json(const Results& results, const Setting& s) {
  Json out{{"machine", s.machine},
           {"compiler", s.compiler},
           {"rounds", s.options.rounds},
           {"slice_seconds", s.options.slice},
           {"configurations", s.configurations},
           {"compared_configurations", s.compared},
           {"robots", Json::array()},
           {"fma_peaks", Json::array()}};
  for (const ProblemResult& p : results.problems) {
    Json rows = Json::array();
    for (const ContestantResult& c : p.contestants) rows.push_back(of(c));
    Json two = nullptr;
    if (p.two_threads) two = {{"times_one", p.two_threads->ratio}, {"cores", p.two_threads->cores}};
    out["robots"].push_back(
        {{"name", p.name}, {"joints", p.joints}, {"contestants", rows}, {"two_threads", two}});
  }
  for (const PeakResult& p : results.peaks)
    out["fma_peaks"].push_back({{"instruction_set", p.peak.instruction_set},
                                {"instruction", p.peak.instruction},
                                {"lanes", p.peak.lanes},
                                {"instructions_per_second", p.rate.best},
                                {"flop_per_second", 2 * p.rate.best * p.peak.lanes}});
  return out.dump(2) + '\n';
}

}  // namespace qerr::bench
