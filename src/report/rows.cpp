#include "report/rows.hpp"

namespace qerr {

namespace schema {

Json number() { return {{"type", "number"}}; }
Json text() { return {{"type", "string"}}; }
Json boolean() { return {{"type", "boolean"}}; }
Json list(Json items) { return {{"type", "array"}, {"items", std::move(items)}}; }
Json map(Json values) { return {{"type", "object"}, {"additionalProperties", std::move(values)}}; }
Json or_null(Json schema) { return {{"anyOf", Json::array({std::move(schema), {{"type", "null"}}})}}; }

}  // namespace schema

Schema constant(std::string_view text) { return {{{"const", text}}}; }
Schema one_of(const std::vector<std::string>& words) { return {{{"enum", words}}}; }
Schema numbers_or_null() { return {schema::list(schema::or_null(schema::number()))}; }
Schema named_numbers_or_null() { return {schema::map(schema::or_null(schema::number()))}; }

std::optional<Json> unless_empty(Json value, Presence presence) {
  const bool empty = value.text()    ? value.text()->empty()
                     : value.items() ? value.items()->empty()
                                     : value.is_object() && value.members().empty();
  if (empty && presence != Presence::required) return {};
  return value;
}

Json object_of(const std::vector<MemberRow>& rows, const void* source) {
  Json object = Json::object();
  for (const MemberRow& row : rows) {
    std::optional<Json> value = row.value(source);
    if (value || row.presence != Presence::optional) object[row.name] = value ? std::move(*value) : Json();
  }
  return object;
}

Json schema_of(const std::vector<MemberRow>& rows) {
  Json properties = Json::object(), required = Json::array();
  for (const MemberRow& row : rows) {
    Json property = row.presence == Presence::nullable ? schema::or_null(row.schema()) : row.schema();
    if (!row.meaning.empty()) property["description"] = row.meaning;
    properties[row.name] = std::move(property);
    if (row.presence != Presence::optional) required.push_back(row.name);
  }
  return {{"type", "object"}, {"properties", properties}, {"required", required}};
}

}  // namespace qerr
