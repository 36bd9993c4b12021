#include "qerr/bound/statistic.hpp"
#include "report/output_schemas.hpp"

namespace qerr {

namespace {

Json schema_of_proof() {
  using namespace schema;
  return object({{"lower", number_or_null(), "reached at `at`"},
                 {"upper", number_or_null(), "never exceeded, rounding included; null: no bound is known"},
                 {"gap", number_or_null(), "upper/lower - 1; null: unbounded"},
                 {"at", map(number()), "joints"}});
}

Json schema_of_statistic() {
  using namespace schema;
  std::vector<SchemaMember> members;
  for (const StatisticKind& kind : statistic_kinds())
    members.push_back({std::string(kind.name), number(), std::string(kind.summary)});
  members.push_back({"at_max", map(number()), "the joints where the maximum is"});
  members.push_back(
      {"proven", schema_of_proof(), "the maximum over the whole joint ranges; with --prove", true});
  return object(members);
}

Json schema_of_covariance(const std::vector<SchemaMember>& more = {}) {
  using namespace schema;
  const Json matrix = list(list(number()));
  return object(joined(
      {{"mean", matrix, "over the configurations"}, {"at_largest", matrix, "where its trace is largest"}},
      more));
}

Json schema_of_position() {
  using namespace schema;
  return object(
      {{"coordinate", text()},
       {"unit", text()},
       {"worst_case", schema_of_statistic(), "of the linearized kinematics"},
       {"worst_case_rigorous", or_null(schema_of_statistic()), "of the exact kinematics; null: no bound"},
       {"sigma", schema_of_statistic(), "IPQN"},
       {"share", map(number()), "of each encoder in the variance; not of a length", true},
       {"share_worst_case", map(number()), "", true}});
}

Json schema_of_derivative() {
  using namespace schema;
  const Json coordinate = object(
      {{"coordinate", text()},
       {"unit", text()},
       {"worst_case", schema_of_statistic()},
       {"sigma", or_null(schema_of_statistic()), "IPQN; null: it depends on the motion"},
       {"sigma_quantization", schema_of_statistic(), "beside other errors: of quantization alone", true},
       {"sigma_in_motion", schema_of_statistic(), "with encoders that move as in `motion:`", true}});
  return object({{"filter", text()},
                 {"derivative", number()},
                 {"h2_norm", number()},
                 {"l1_norm", interval()},
                 {"coordinates", list(coordinate)},
                 {"covariance", or_null(schema_of_covariance())},
                 {"noise_in_motion_over_ipqn", map(number_or_null()), "per encoder", true}});
}

Json schema_of_effect() {
  using namespace schema;
  const Json value{{"type", Json::array({"number", "string", "null"})}};
  const Json parameter = object({{"name", text()}, {"value", value}, {"unit", text()}});
  return object({{"effect", text()},
                 {"joint", text()},
                 {"stage", text()},
                 {"unit", text()},
                 {"mean", number_or_null()},
                 {"worst_case", number_or_null()},
                 {"sigma", number_or_null()},
                 {"counted", boolean(), "false: it concerns the log or the reference only"},
                 {"parameters", list(parameter)}});
}

Json schema_of_ellipsoids() {
  using namespace schema;
  const Json ellipsoid = object({{"semi_axes", list(number()), "of one sigma, the largest first"},
                                 {"directions", list(list(number())), "unit vectors along them"}});
  return object({{"of", one_of({"position", "rotation"})},
                 {"unit", text()},
                 {"frame", one_of({"base", "tip"}), "in whose axes the directions are"},
                 {"mean", ellipsoid, "of the mean covariance"},
                 {"at_largest", ellipsoid, "where the trace of the position's covariance is largest"}});
}

Json schema_of_exceedance() {
  using namespace schema;
  const Json shell = object({{"from", number()},
                             {"to", number()},
                             {"count", number(), "configurations"},
                             {"above", number(), "of these, above the limit"}});
  return object({{"quantity", text(), "as in requirements"},
                 {"limit", number()},
                 {"unit", text()},
                 {"count", number(), "configurations"},
                 {"above", number(), "of these, above the limit"},
                 {"share", number()},
                 {"by_distance", list(shell), "distances of the tip from the origin of the base"},
                 {"lowest", list(number_or_null()), "x y z of the tip above the limit; null without any"},
                 {"highest", list(number_or_null())}});
}

std::vector<SchemaMember> analysis_header_schema(std::string_view command) {
  using namespace schema;
  const Json configurations = object({{"method", text()}, {"count", number()}});
  return joined(header(command), {{"configurations", configurations}});
}

}  // namespace

Json analysis_schema() {
  using namespace schema;
  const Json joint = object({{"name", text()},
                             {"unit", text()},
                             {"resolution", number(), "of the encoder, at the joint side"},
                             {"worst_case", number(), "of the joint, after the coupling"},
                             {"sigma", number()},
                             {"mean", number()},
                             {"accuracy", number(), "of the encoder, at the joint side", true},
                             {"gear_accuracy", number(), "at the joint", true},
                             {"count_rate", number_or_null(), "counts/s; where a limit is stated", true},
                             {"max_count_rate", number(), "counts/s", true}});
  const Json parts = object({{"quantization", number()},
                             {"accuracy", number(), "as a sine of that amplitude"},
                             {"effects", number(), "attributed to the encoder"}});
  const Json covariance =
      schema_of_covariance({{"coordinates", list(text())}, {"largest_at", map(number()), "joints"}});
  return object(joined(
      analysis_header_schema("analyze"),
      {{"joints", list(joint)},
       {"position", list(schema_of_position())},
       {"derivatives", list(schema_of_derivative())},
       {"covariance", covariance, "of the tip's position"},
       {"budget", map(number()), "share of each encoder in the variance of the tip"},
       {"budget_parts", map(parts), "of each encoder's share; beside an `accuracy`", true},
       {"ellipsoids", list(schema_of_ellipsoids()), "of x y z and of rx ry rz, if all three are given"},
       {"exceedances", list(schema_of_exceedance()), "with --above", true},
       {"effects", list(schema_of_effect())},
       {"warnings", warnings()}}));
}

Json check_schema() {
  using namespace schema;
  const Json requirement = object({{"quantity", text()},
                                   {"statistic", text(), "absent for a figure of a filter", true},
                                   {"at_most", number(), "either this or at_least", true},
                                   {"at_least", number(), "", true},
                                   {"value", number_or_null()},
                                   {"unit", text()},
                                   {"met", boolean()},
                                   {"proven", schema_of_proof(), "of the statistic proven_max", true}});
  const Json regression =
      object({{"quantity", text()},
              {"statistic", text(), "empty: a figure of a filter"},
              {"unit", text()},
              {"baseline", number_or_null(), "null: unbounded"},
              {"value", number_or_null(), "null: unbounded"},
              {"change", number_or_null(), "relative; null: from zero, or to unbounded"}});
  const Json baseline = object({{"file", text()},
                                {"tolerance", number(), "relative"},
                                {"compared", number(), "figures that both have"},
                                {"missing", list(text()), "figures that only the baseline has"},
                                {"dropped_requirements", list(text()), "that only the baseline has"},
                                {"not_in_baseline", list(text()), "required figures that it lacks"}});
  const Json of_spec =
      object(joined(analysis_header_schema("check"),
                    {{"requirements", list(requirement)},
                     {"baseline", baseline, "with --baseline", true},
                     {"regressions", list(regression), "with --baseline: figures that are worse", true},
                     {"met", boolean(), "all requirements, and no figure is worse"},
                     {"warnings", warnings()}}));
  const Json of_specs =
      object({{"qerr", text()},
              {"command", constant("check")},
              {"reports", list(of_spec), "one for each spec, if there are several"},
              {"broken", list(object({{"file", text()}, {"error", text()}})), "specs that cannot be checked"},
              {"met", boolean(), "all of all"}});
  return {{"anyOf", Json::array({of_spec, of_specs})}};
}

}  // namespace qerr
