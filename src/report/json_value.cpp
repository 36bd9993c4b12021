#include "report/json_value.hpp"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string_view>
#include <utility>

#include "core/text.hpp"
#include "input/byte_source.hpp"
#include "qerr/core/error.hpp"

namespace qerr {

/// The only place that knows nlohmann-json: it reads texts, writes the digits and escapes the strings.
struct JsonText {
  using Library = nlohmann::ordered_json;

  static Error no_json(const std::string& text, std::size_t byte, const std::string& file,
                       const std::string& rule) {
    const std::string rest =
        text.substr(byte, std::min(text.find_first_of("\r\n", byte) - byte, std::size_t{30}));
    // What a file of another kind holds may be nobody's business.
    const bool report = text.find("\"qerr\"") != std::string::npos;
    return Error(Fault{place_of_byte(text, byte, file), "", rule,
                       rest.empty() ? "its end"
                       : report     ? quoted(rest)
                                    : "",
                       "write the file anew with --format json"});
  }

  /// The first number beyond the doubles that is not within a string.
  static std::size_t place_of_large_number(const std::string& text) {
    constexpr std::string_view parts = "+-.0123456789Ee";
    for (std::size_t at = 0; at < text.size(); ++at) {
      if (text[at] == '"') {
        while (++at < text.size() && text[at] != '"') at += text[at] == '\\';
      } else if (parts.find(text[at]) < parts.size() - 2) {
        const std::size_t end = std::min(text.find_first_not_of(parts, at), text.size());
        if (Library::parse(text.substr(at, end - at), nullptr, false).is_discarded()) return at;
        at = end - 1;
      }
    }
    return 0;
  }

  static Library read(const std::string& text, const std::string& file) {
    constexpr int most_levels = 64;  // the conversion calls itself for each
    if (text.find_first_not_of(" \t\r\n") == std::string::npos)
      throw Error(Fault{{file, 1, 1}, "", "the file is empty", "", "write it anew with --format json"});
    const auto limited = [&](int depth, Library::parse_event_t, const Library&) {
      if (depth > most_levels) throw no_json(text, 0, file, "has more than 64 levels: this is no report");
      return true;
    };
    try {
      return Library::parse(text, limited);
    } catch (const nlohmann::json::parse_error& e) {
      throw no_json(text, std::min(text.size(), e.byte > 0 ? e.byte - 1 : 0), file,
                    "the text is no valid JSON");
    } catch (const nlohmann::json::out_of_range&) {
      throw no_json(text, place_of_large_number(text), file, "a number is too large");
    }
  }

  static Json value(const Library& read) {
    if (read.is_boolean()) return read.get<bool>();
    if (read.is_number_unsigned()) return read.get<std::uint64_t>();
    if (read.is_number_integer()) return read.get<std::int64_t>();
    if (read.is_number()) return read.get<double>();
    if (read.is_string()) return read.get<std::string>();
    Json json;
    if (read.is_array()) json = Json::array();
    if (read.is_object()) json = Json::object();
    for (const auto& [name, member] : read.items())
      if (read.is_array())
        json.push_back(value(member));
      else
        std::get<Json::Members>(json.value_).push_back({name, value(member)});
    return json;
  }

  static Library converted(const Json& json) {
    return std::visit([](const auto& value) { return converted(value); }, json.value_);
  }

  template <class Scalar>
  static Library converted(const Scalar& value) {
    return value;
  }

  static Library converted(const Json::Items& items) {
    Library array = Library::array();
    for (const Json& item : items) array.push_back(converted(item));
    return array;
  }

  static Library converted(const Json::Members& members) {
    Library object = Library::object();
    for (const JsonMember& member : members) object.emplace(member.name, converted(member.value));
    return object;
  }

  static std::string escaped_code(unsigned code) {
    if (code >= 0x10000)  // two surrogates
      return escaped_code(0xD800 + (code - 0x10000) / 0x400) + escaped_code(0xDC00 + code % 0x400);
    return "\\u" + hexadecimal(static_cast<unsigned char>(code >> 8)) +
           hexadecimal(static_cast<unsigned char>(code & 0xFF));
  }

  /// What a reader cannot see, or a terminal obeys, is valid in JSON: as \uXXXX the text is the same. It
  /// occurs in strings only, except for line ends.
  static std::string terminal_safe(const std::string& text) {
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

  static std::string text(const Json& json, int indent) {
    return terminal_safe(converted(json).dump(indent, ' ', false, Library::error_handler_t::replace));
  }
};

void Json::set(bool value) { value_ = value; }
void Json::set(std::int64_t value) { value_ = value; }
void Json::set(std::uint64_t value) { value_ = value; }

Json::Json() = default;
Json::Json(double value) : Json() {
  if (std::isfinite(value)) value_ = value;
}
Json::Json(const char* text) : value_(std::string(text)) {}
Json::Json(std::string_view text) : value_(std::string(text)) {}
Json::Json(std::string text) : value_(std::move(text)) {}
Json::Json(std::initializer_list<JsonMember> members) : value_(Members(members)) {}

// The copy is made outside the variant, into which it moves without an exception: with the defaulted
// constructor of g++ 12, a copy that lacked memory ended in a wild jump (check_faults.py).
Json::Json(const Json& other) {
  std::visit(
      [this](const auto& value) {
        auto copy = value;
        value_ = std::move(copy);
      },
      other.value_);
}
Json::Json(Json&&) noexcept = default;
Json& Json::operator=(const Json& other) {
  Json copy(other);
  value_ = std::move(copy.value_);
  return *this;
}
Json& Json::operator=(Json&&) noexcept = default;
Json::~Json() = default;

Json Json::array() { return array({}); }

Json Json::array(std::initializer_list<Json> items) {
  Json json;
  json.value_ = Items(items);
  return json;
}

Json Json::object() {
  Json json;
  json.value_ = Members();
  return json;
}

Json& Json::operator[](std::string_view name) {
  if (std::holds_alternative<std::nullptr_t>(value_)) value_ = Members();
  auto& members = std::get<Members>(value_);
  const auto found =
      std::find_if(members.begin(), members.end(), [&](const JsonMember& m) { return m.name == name; });
  if (found != members.end()) return found->value;
  members.push_back({std::string(name), Json()});
  return members.back().value;
}

void Json::push_back(Json item) {
  if (std::holds_alternative<std::nullptr_t>(value_)) value_ = Items();
  std::get<Items>(value_).push_back(std::move(item));
}

void Json::append(Json members) {
  for (JsonMember& member : std::get<Members>(members.value_))
    std::get<Members>(value_).push_back(std::move(member));
}

Json Json::parse(const std::string& text, const std::string& file) {
  return JsonText::value(JsonText::read(text, file));
}

std::optional<double> Json::number() const {
  if (const auto* real = std::get_if<double>(&value_)) return *real;
  if (const auto* natural = std::get_if<std::uint64_t>(&value_)) return static_cast<double>(*natural);
  if (const auto* whole = std::get_if<std::int64_t>(&value_)) return static_cast<double>(*whole);
  return {};
}

std::optional<bool> Json::boolean() const {
  const bool* value = std::get_if<bool>(&value_);
  return value ? std::optional(*value) : std::nullopt;
}

std::span<const JsonMember> Json::members() const {
  const Members* members = std::get_if<Members>(&value_);
  return members ? std::span<const JsonMember>(*members) : std::span<const JsonMember>();
}

const Json* Json::find(std::string_view name) const {
  for (const JsonMember& member : members())
    if (member.name == name) return &member.value;
  return nullptr;
}

std::string Json::document() const { return JsonText::text(*this, 2) + '\n'; }

std::string Json::line() const { return JsonText::text(*this, -1); }

}  // namespace qerr
