#include "report/output_schemas.hpp"

#include <stdexcept>

#include "qerr/report/write.hpp"

namespace qerr {

namespace {

/// A row: a command with a JSON report.
struct OutputSchema {
  std::string_view command;
  std::string_view title;
  Json (*schema)();
};

constexpr OutputSchema output_schemas[] = {
    {"analyze", "qerr analyze --format json", analysis_schema},
    {"check", "qerr check --format json", check_schema},
    {"compare", "qerr compare --format json", comparison_schema},
    {"design", "qerr design --format json", design_schema},
    {"filter", "qerr filter --format json", filter_schema},
    {"simulate", "qerr simulate --format json", simulation_schema},
    {"diagnose", "qerr diagnose --format json", diagnosis_schema},
    {"plan", "qerr diagnose --plan --format json", plan_schema},
    {"sweep", "qerr sweep --format json", sweep_schema},
    {"threshold", "qerr threshold --format json", threshold_schema},
    {"robot", "qerr robot --format json", robot_schema},
    {"list", "qerr list --format json", list_schema},
};

}  // namespace

std::vector<std::string> output_schema_names() {
  std::vector<std::string> names;
  for (const OutputSchema& row : output_schemas) names.emplace_back(row.command);
  return names;
}

std::string output_schema(std::string_view command) {
  for (const OutputSchema& row : output_schemas)
    if (row.command == command) {
      Json root = {{"$schema", "https://json-schema.org/draft/2020-12/schema"}, {"title", row.title}};
      root.append(row.schema());
      return root.document();
    }
  throw std::logic_error("no report has the name '" + std::string(command) + "'");
}

namespace schema {

Json number() { return {{"type", "number"}}; }
Json number_or_null() { return or_null(number()); }
Json text() { return {{"type", "string"}}; }
Json text_or_null() { return or_null(text()); }
Json boolean() { return {{"type", "boolean"}}; }
Json constant(std::string_view text) { return {{"const", text}}; }
Json one_of(const std::vector<std::string>& words) { return {{"enum", words}}; }
Json list(Json items) { return {{"type", "array"}, {"items", std::move(items)}}; }
Json map(Json values) { return {{"type", "object"}, {"additionalProperties", std::move(values)}}; }
Json or_null(Json schema) { return {{"anyOf", Json::array({std::move(schema), {{"type", "null"}}})}}; }

Json object(const std::vector<SchemaMember>& members) {
  Json properties = Json::object(), required = Json::array();
  for (const SchemaMember& member : members) {
    Json property = member.schema;
    if (!member.meaning.empty()) property["description"] = member.meaning;
    properties[member.name] = property;
    if (!member.optional) required.push_back(member.name);
  }
  return {{"type", "object"}, {"properties", properties}, {"required", required}};
}

Json interval() { return object({{"lower", number_or_null()}, {"upper", number_or_null()}}); }

Json warnings() { return list(text()); }

Json spec_source() {
  const Json change = object({{"key", text()}, {"value", text()}});
  return object({{"file", text()},
                 {"sha256", text(), "of the file's bytes"},
                 {"set", list(change), "the values that --set replaced", true}});
}

std::vector<SchemaMember> header(std::string_view command) {
  return {{"qerr", text(), "the version that wrote the report"},
          {"command", constant(command)},
          {"spec", spec_source()},
          {"seed", number()},
          {"robot", object({{"name", text()}, {"base", text()}, {"tip", text()}})}};
}

std::vector<SchemaMember> joined(std::vector<SchemaMember> members, const std::vector<SchemaMember>& more) {
  members.insert(members.end(), more.begin(), more.end());
  return members;
}

}  // namespace schema

}  // namespace qerr
