#include "report/rows.hpp"

#include <algorithm>

#include "core/text.hpp"
#include "input/csv.hpp"
#include "qerr/core/error.hpp"
#include "qerr/core/quantity.hpp"

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
  const bool empty = value.is_string() ? value.get_ref<const std::string&>().empty()
                                       : value.is_structured() && value.empty();
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

namespace {

/// Whether a spreadsheet would calculate the text, or an apostrophe before it would be taken for one of ours.
bool is_formula(const std::string& text) {
  std::string why;
  return text.size() > 1 && std::string_view("=+-@'").find(text[0]) != std::string_view::npos &&
         !parse_quantity(text, why);
}

/// Whether the text means itself without quotation marks: blanks at its ends are lost, and `#` begins a
/// comment.
bool is_plain(const std::string& text) {
  return text.empty() || (text.find_first_of(",\"\r\n") == std::string::npos && text[0] != '#' &&
                          text.front() != ' ' && text.back() != ' ');
}

Error no_json(const std::string& text, std::size_t byte, const std::string& file, const std::string& rule) {
  const std::string rest =
      text.substr(byte, std::min(text.find_first_of("\r\n", byte) - byte, std::size_t{30}));
  // What a file of another kind holds may be nobody's business.
  const bool report = text.find("\"qerr\"") != std::string::npos;
  return Error(place_of_byte(text, byte, file), "", rule,
               rest.empty() ? "its end"
               : report     ? quoted(rest)
                            : "",
               "write the file anew with --format json");
}

/// The first number beyond the doubles that is not within a string.
std::size_t place_of_large_number(const std::string& text) {
  constexpr std::string_view parts = "+-.0123456789Ee";
  for (std::size_t at = 0; at < text.size(); ++at) {
    if (text[at] == '"') {
      while (++at < text.size() && text[at] != '"') at += text[at] == '\\';
    } else if (parts.find(text[at]) < parts.size() - 2) {
      const std::size_t end = std::min(text.find_first_not_of(parts, at), text.size());
      if (Json::parse(text.substr(at, end - at), nullptr, false).is_discarded()) return at;
      at = end - 1;
    }
  }
  return 0;
}

std::string escaped_code(unsigned code) {
  if (code >= 0x10000)  // two surrogates
    return escaped_code(0xD800 + (code - 0x10000) / 0x400) + escaped_code(0xDC00 + code % 0x400);
  return "\\u" + hexadecimal(static_cast<unsigned char>(code >> 8)) +
         hexadecimal(static_cast<unsigned char>(code & 0xFF));
}

/// What a reader cannot see, or a terminal obeys, is valid in JSON: as \uXXXX the text is the same. It
/// occurs in strings only, except for line ends.
std::string terminal_safe(const std::string& text) {
  std::string out;
  out.reserve(text.size());
  for (std::size_t i = 0; i < text.size();) {
    const std::size_t hidden = text[i] == '\n' ? 0 : hidden_length(text, i);
    const std::size_t length = std::max<std::size_t>(utf8_length(text, i), 1);
    if (hidden > 0)
      out += escaped_code(code_point(text, i));
    else
      out.append(text, i, length);
    i += length;
  }
  return out;
}

std::string text(const Json& json, int indent) {
  return terminal_safe(json.dump(indent, ' ', false, Json::error_handler_t::replace));
}

}  // namespace

std::string csv_cell(const std::string& cell) {
  const std::string text = (is_formula(cell) ? "'" : "") + escaped(cell, std::string::npos);
  if (is_plain(text)) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
  return quoted + '"';
}

std::string csv_number(double value) {
  if (std::isinf(value)) return value > 0 ? "inf" : "-inf";
  return std::isnan(value) ? std::string() : shortest(value);
}

std::string csv_number(const std::optional<double>& value) {
  return value ? csv_number(*value) : std::string();
}

std::string csv_cells(const Json& object, const std::vector<std::string>& paths) {
  std::string cells;
  for (const std::string& path : paths) {
    const Json* value = &object;
    for (std::size_t begin = 0; value && begin <= path.size();) {
      const std::size_t dot = std::min(path.find('.', begin), path.size());
      const auto member = value->find(path.substr(begin, dot - begin));
      value = member == value->end() ? nullptr : &*member;
      begin = dot + 1;
    }
    if (&path != &paths.front()) cells += ',';
    if (!value || value->is_null()) continue;
    cells += value->is_boolean()  ? (value->get<bool>() ? "true" : "false")
             : value->is_string() ? csv_cell(value->get<std::string>())
                                  : csv_number(value->get<double>());
  }
  return cells;
}

std::vector<std::string> csv_paths(const Json& schema) {
  std::vector<std::string> paths;
  for (const auto& [name, member] : schema.at("properties").items()) {
    if (!member.contains("properties"))
      paths.push_back(name);
    else
      for (const std::string& inner : csv_paths(member)) paths.push_back(name + '.' + inner);
  }
  return paths;
}

Json parse_json(const std::string& text, const std::string& file) {
  constexpr int most_levels = 64;  // readers call themselves for each
  if (text.find_first_not_of(" \t\r\n") == std::string::npos)
    throw Error({file, 1, 1}, "", "the file is empty", "", "write it anew with --format json");
  const auto limited = [&](int depth, Json::parse_event_t, const Json&) {
    if (depth > most_levels) throw no_json(text, 0, file, "has more than 64 levels: this is no report");
    return true;
  };
  try {
    return Json::parse(text, limited);
  } catch (const Json::parse_error& e) {
    throw no_json(text, std::min(text.size(), e.byte > 0 ? e.byte - 1 : 0), file,
                  "the text is no valid JSON");
  } catch (const Json::out_of_range&) {
    throw no_json(text, place_of_large_number(text), file, "a number is too large");
  }
}

std::string document(const Json& json) { return text(json, 2) + '\n'; }

std::string line(const Json& json) { return text(json, -1); }

}  // namespace qerr
