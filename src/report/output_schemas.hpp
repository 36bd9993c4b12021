#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "report/json_value.hpp"

/// JSON Schemas (draft 2020-12) of the reports' JSON, one file per report beside its writer. Objects are
/// open: a later version may add members.
namespace qerr {

/// A member of an object.
struct SchemaMember {
  std::string name;
  Json schema;
  std::string meaning = {};
  bool optional = false;
};

namespace schema {

Json number();
Json number_or_null();  ///< null: unbounded, or not known
Json text();
Json text_or_null();
Json boolean();
Json constant(std::string_view text);
Json one_of(const std::vector<std::string>& words);
Json list(Json items);
Json map(Json values);  ///< an object with any names
Json or_null(Json schema);
Json object(const std::vector<SchemaMember>& members);
Json interval();  ///< `{"lower", "upper"}`
Json warnings();

/// The spec of a report (report/json_header.hpp).
Json spec_source();

/// The members that the report of a command begins with.
std::vector<SchemaMember> header(std::string_view command);
std::vector<SchemaMember> joined(std::vector<SchemaMember> members, const std::vector<SchemaMember>& more);

}  // namespace schema

Json analysis_schema();
Json check_schema();
Json comparison_schema();
Json design_schema();
Json diagnosis_schema();
Json filter_schema();
Json list_schema();
Json plan_schema();
Json robot_schema();
Json simulation_schema();
Json sweep_schema();
Json threshold_schema();

}  // namespace qerr
