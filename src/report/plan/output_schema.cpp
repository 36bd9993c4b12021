#include "report/output_schemas.hpp"

namespace qerr {

namespace {

/// An effect with the choices and the figures that tell it from others of its type.
Json planned_effect_schema(const std::vector<SchemaMember>& more) {
  using namespace schema;
  return object(joined({{"effect", text()},
                        {"shaft", text(), "", true},
                        {"order", number(), "", true},
                        {"time_constant", number(), "", true}},
                       more));
}

Json planned_joints_schema() {
  using namespace schema;
  const Json correlated = planned_effect_schema({{"correlation", number()},
                                                 {"told_apart", number_or_null(), "from this magnitude on"},
                                                 {"record", text(), "what tells them apart"}});
  const Json effect = planned_effect_schema({{"parameter", text()},
                                             {"unit", text()},
                                             {"seen", number_or_null(), "smallest detectable magnitude"},
                                             {"named", number_or_null(), "smallest identifiable magnitude"},
                                             {"seen_counts", number_or_null()},
                                             {"named_counts", number_or_null()},
                                             {"alike", list(correlated)}});
  return list(object({{"joint", text()},
                      {"unit", text()},
                      {"resolution", number()},
                      {"moves", boolean()},
                      {"readings", number(), "independent ones"},
                      {"effects", list(effect)},
                      {"unseen", list(object({{"effect", text()}, {"needs", text()}}))}}));
}

}  // namespace

Json plan_schema() {
  using namespace schema;
  const Json better = object({{"motion", text(), "YAML to paste"},
                              {"changed", list(text()), "joints"},
                              {"joints", planned_joints_schema()}});
  return object({{"qerr", text(), "the version that wrote the report"},
                 {"command", constant("diagnose --plan")},
                 {"spec", object({{"file", text()}, {"sha256", text()}})},
                 {"reference_noise", number(), "counts"},
                 {"power", number()},
                 {"joints", planned_joints_schema()},
                 {"better", or_null(better), "a motion that identifies more"},
                 {"warnings", warnings()}});
}

}  // namespace qerr
