#include "report/output_schemas.hpp"

namespace qerr {

Json threshold_schema() {
  using namespace schema;
  std::vector<SchemaMember> members{{"robot", text()},
                                    {"joint", text(), "with the largest resolution at the tip"}};
  for (const char* name :
       {"counts_per_rev", "gear_ratio", "coupling", "length_mm", "sample_rate_hz", "resolution_mm",
        "threshold_velocity_mm_s", "resolution_mm_as_printed", "threshold_velocity_mm_s_as_printed"})
    members.push_back({name, number_or_null()});
  return object({{"qerr", text(), "the version that wrote the report"},
                 {"command", constant("threshold")},
                 {"robots", list(object(members))}});
}

}  // namespace qerr
