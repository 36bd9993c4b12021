#include "report/output_schemas.hpp"

namespace qerr {

namespace {

Json source_schema() {
  using namespace schema;
  return object({{"file", text()},
                 {"command", one_of({"analyze", "check", "filter", "spec"}),
                  "that wrote the report; spec: its figures are those of now"}});
}

Json judged_schema() {
  using namespace schema;
  return or_null(object({{"at_most", number(), "", true},
                         {"at_least", number(), "", true},
                         {"value", number_or_null(), "null: unbounded"},
                         {"met", boolean()},
                         {"margin", number_or_null(), "distance from the limit over the limit"}}));
}

}  // namespace

Json comparison_schema() {
  using namespace schema;
  const Json figure =
      object({{"figure", text(), "the name that requirements use"},
              {"statistic", text(), "empty: a figure of a filter"},
              {"unit", text()},
              {"a", number_or_null(), "null: unbounded, or only B has it"},
              {"b", number_or_null(), "null: unbounded, or only A has it"},
              {"change", number_or_null(), "(b - a)/|a|; null: from zero, to unbounded, or one report only"},
              {"only", one_of({"a", "b"}), "the report that has the figure, if one has it", true}});
  const Json share = object({{"encoder", text()},
                             {"a", number_or_null()},
                             {"b", number_or_null()},
                             {"change", number_or_null(), "b - a"}});
  const Json requirement = object({{"quantity", text()},
                                   {"statistic", text(), "empty: a figure of a filter"},
                                   {"unit", text()},
                                   {"a", judged_schema(), "null: only B has it"},
                                   {"b", judged_schema(), "null: only A has it"},
                                   {"flipped", boolean()},
                                   {"flips_after", number_or_null(), "part of the way from A to B"}});
  return object({{"qerr", text(), "the version that wrote the report"},
                 {"command", constant("compare")},
                 {"a", source_schema()},
                 {"b", source_schema()},
                 {"figures", list(figure), "the largest changes first"},
                 {"shares", list(share), "of each encoder in the variance of the tip"},
                 {"requirements", list(requirement),
                  "flipped ones first, in their order; then the smallest margins in B"},
                 {"warnings", warnings()}});
}

}  // namespace qerr
