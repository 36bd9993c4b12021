#include "report/output_schemas.hpp"
#include "report/simulation/signals.hpp"

namespace qerr {

namespace {

std::vector<SchemaMember> figures_schema(const Figures& figures) {
  using namespace schema;
  std::vector<SchemaMember> members;
  for (const auto& figure : figures) members.push_back({figure.first, schema::number_or_null()});
  return members;
}

}  // namespace

Json simulation_schema() {
  using namespace schema;
  Json effect = object({{"effect", text()}, {"joint", text()}});
  effect["additionalProperties"] = {{"type", Json::array({"number", "string", "null"})}};
  const Json result = object(joined(
      joined(
          {{"filter", text(), "\"position\" or the filter's name"}, {"coordinate", text()}, {"unit", text()}},
          figures_schema(figures_of({}))),
      {{"ladder", object(figures_schema(factors_of({}))), "factors from sigma_ipqn to sigma_simulated"}}));
  const Json choice = object({{"cutoff", number(), "[Hz]"},
                              {"encoder_rms", number(), "by the errors of the encoders"},
                              {"tracking_rms", number(), "by the filter"},
                              {"total_rms", number()}});
  const Json cutoffs = object({{"filter", text()},
                               {"unit", text(), "of the errors"},
                               {"best", number(), "the cut-off with the least total [Hz]"},
                               {"choices", list(choice), "of the vector of the position's coordinates"}});
  return object(joined(header("simulate"), {{"effects", list(effect)},
                                            {"runs", number()},
                                            {"samples", number(), "of a run"},
                                            {"settling_samples", number(), "discarded at the start"},
                                            {"results", list(result)},
                                            {"cutoffs", cutoffs, "with --cutoffs", true},
                                            {"warnings", warnings()}}));
}

}  // namespace qerr
