#include "report/json_value.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>

#include "core/text.hpp"

namespace qerr {

/// The only place that knows nlohmann-json: it writes the digits and escapes the strings.
struct JsonText {
  using Library = nlohmann::ordered_json;

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

  /// DEL and the control characters U+0080..U+009F, which a terminal obeys, are valid in JSON: as \u00XX the
  /// text is the same. They occur in strings only.
  static std::string terminal_safe(const std::string& text) {
    std::string out;
    out.reserve(text.size());
    for (std::size_t i = 0; i < text.size(); ++i) {
      const auto byte = static_cast<unsigned char>(text[i]);
      const bool control =
          byte == 0xC2 && i + 1 < text.size() && static_cast<unsigned char>(text[i + 1]) < 0xA0;
      if (byte == 0x7F || control)
        out += "\\u00" + hexadecimal(static_cast<unsigned char>(text[control ? ++i : i]));
      else
        out += text[i];
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
Json::Json(double value) : value_(value) {}
Json::Json(const char* text) : value_(std::string(text)) {}
Json::Json(std::string_view text) : value_(std::string(text)) {}
Json::Json(std::string text) : value_(std::move(text)) {}
Json::Json(std::initializer_list<JsonMember> members) : value_(Members(members)) {}
Json::Json(const std::map<std::string, std::string>& members) : Json(object()) {
  for (const auto& [name, text] : members) std::get<Members>(value_).push_back({name, text});
}

Json::Json(const Json&) = default;
Json::Json(Json&&) noexcept = default;
Json& Json::operator=(const Json&) = default;
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

Json& Json::back() { return std::get<Items>(value_).back(); }

void Json::append(Json members) {
  for (JsonMember& member : std::get<Members>(members.value_))
    std::get<Members>(value_).push_back(std::move(member));
}

std::string Json::document() const { return JsonText::text(*this, 2) + '\n'; }

std::string Json::line() const { return JsonText::text(*this, -1); }

}  // namespace qerr
