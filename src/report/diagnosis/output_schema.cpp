#include "qerr/diagnose/diagnosis.hpp"
#include "report/output_schemas.hpp"

namespace qerr {

namespace {

Json gain_schema() {
  using namespace schema;
  return object({{"held_out", boolean(), "measured on blocks of the log that the fit has not seen"},
                 {"rms_before", number_or_null()},
                 {"rms_after", number_or_null()},
                 {"ratio", number_or_null()},
                 {"lower", number_or_null()},
                 {"upper", number_or_null()},
                 {"counts_before", number_or_null()},
                 {"counts_after", number_or_null()},
                 {"sigma_ratio", number_or_null()},
                 {"log_score", number_or_null()},
                 {"coverage", number_or_null()},
                 {"unit", text()}});
}

Json curve_schema() {
  using namespace schema;
  return or_null(object({{"against", text(), "the quantity on which the error depends"},
                         {"unit", text(), "of `at`"},
                         {"at", list(number()), "centres of the bins"},
                         {"residual", list(number_or_null()), "mean of the bin without this cause"},
                         {"fit", list(number_or_null()), "mean contribution of this cause"}}));
}

Json data_schema() {
  using namespace schema;
  return object({{"what", text()},
                 {"kind", one_of({"remark", "corrupt", "missing", "repeated", "contradictory"}),
                  "of all but a remark --check ends with 1"},
                 {"joint", text_or_null(), "null: the whole record"},
                 {"row", number(), "of the file, from 1, where it begins", true},
                 {"time", number(), "[s], where it begins", true},
                 {"remedy", text()}});
}

Json visible_schema() {
  using namespace schema;
  return object({{"effect", text()},
                 {"joint", text()},
                 {"parameter", text(), "whose smallest visible size is stated"},
                 {"smallest", number_or_null(), "null: the record cannot show the effect"},
                 {"unit", text()},
                 {"hidden_by", text_or_null(), "why the record cannot show it"}});
}

std::vector<std::string> shape_names() {
  std::vector<std::string> names;
  for (const Shape shape : {Shape::step, Shape::hysteresis, Shape::exponential, Shape::line, Shape::order,
                            Shape::bump, Shape::by_count, Shape::noise, Shape::unknown})
    names.emplace_back(name(shape));
  return names;
}

Json unexplained_schema() {
  using namespace schema;
  return object({{"joint", text()},
                 {"what", text()},
                 {"order", number_or_null()},
                 {"frequency", number_or_null()},
                 {"amplitude", number_or_null()},
                 {"unit", text()},
                 {"shape", one_of(shape_names())},
                 {"figures", map(number_or_null()), "of the shape, SI, such as the time of a step"},
                 {"units", map(text()), "of the figures"},
                 {"curve", curve_schema()}});
}

Json cause_schema() {
  using namespace schema;
  const Json parameter = object({{"name", text()},
                                 {"value", number()},
                                 {"lower", number_or_null()},
                                 {"upper", number_or_null()},
                                 {"unit", text()}});
  return object({{"effect", text()},
                 {"joint", text()},
                 {"p_value", number()},
                 {"parameters", list(parameter), "with 95 % intervals"},
                 {"gain", gain_schema(), "of its joint"},
                 {"rms", number(), "of its contribution to the readings", true},
                 {"counts", number(), "the same in counts of the joint's encoder", true},
                 {"rms_without", number_or_null(), "of the residual if the model lacks this cause alone"},
                 {"curve", curve_schema()},
                 {"choices", map(text()), "", true}});
}

Json log_schema() {
  using namespace schema;
  const Json unwrapped = object({{"column", text()},
                                 {"turns_at_start", number()},
                                 {"wraps", number()},
                                 {"first_row", number()},
                                 {"first_time", number_or_null()},
                                 {"contradicted", number()}});
  return object({{"file", text()},
                 {"rows", number()},
                 {"first_time", number_or_null()},
                 {"last_time", number_or_null()},
                 {"unwrapped", list(unwrapped), "columns that wrapped at a full turn"}});
}

}  // namespace

Json diagnosis_schema() {
  using namespace schema;
  const Json comparison = object({{"joint", text()},
                                  {"statistic", text()},
                                  {"observed", number_or_null()},
                                  {"expected", number_or_null()},
                                  {"p_value", number_or_null()}});
  const Json alternative =
      object({{"instead_of", text()}, {"effect", text()}, {"joint", text()}, {"record", text()}});
  std::vector<SchemaMember> members = header("diagnose");
  std::erase_if(members, [](const SchemaMember& member) { return member.name == "robot"; });
  return object(joined(
      members,
      {{"log", log_schema()},
       {"verdict", one_of({"nothing_wrong", "explained", "partly_explained", "ambiguous", "unexplained",
                           "cannot_judge"})},
       {"reason", text()},
       {"unjudged", list(text()),
        "joints (or tip, tip.x) of which the log has columns and nothing can be said: if any, "
        "--check ends with 1"},
       {"data", list(data_schema()), "faults of the record itself"},
       {"simulation", list(comparison), "statistics of the log, and of the simulated model"},
       {"causes", list(cause_schema()), "in the order of the variance that they remove"},
       {"alternatives", list(alternative), "what explains it as well, and what to record to tell"},
       {"unexplained", list(unexplained_schema())},
       {"visible", list(visible_schema()), "what the record could have shown"},
       {"gain", gain_schema(), "of the extended model, over all judged joints"},
       {"check",
        or_null(object({{"rms_simulated", number(), "of the extended model, simulated along the record"},
                        {"rms_measured", number()},
                        {"agrees", boolean(), "whether the simulation leaves what the gain says"}})),
        "residual, reading - reference; null without a joint that is judged"},
       {"extended_model", text_or_null(), "its file"},
       {"warnings", warnings()}}));
}

}  // namespace qerr
