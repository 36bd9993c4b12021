#include "report/output_schemas.hpp"

namespace qerr {

Json list_schema() {
  using namespace schema;
  const Json parameter = object({{"name", text()},
                                 {"unit", text(), "SI; empty of a pure number and of other kinds"},
                                 {"meaning", text()},
                                 {"required", boolean()},
                                 {"default", number(), "", true},
                                 {"least", number(), "", true},
                                 {"most", number(), "", true},
                                 {"choices", list(text()), "the default first", true}});
  return list(object({{"name", text()},
                      {"summary", text()},
                      {"parameters", list(parameter)},
                      {"stage", text(), "of an effect: where it acts", true},
                      {"typical", text(), "of an effect: usual magnitudes", true}}));
}

}  // namespace qerr
