#pragma once

#include <concepts>
#include <cstdint>
#include <initializer_list>
#include <optional>
#include <ranges>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <variant>
#include <vector>

namespace qerr {

struct JsonMember;

/// A JSON value; an object keeps the order in which its members were added.
///
///     Json j = {{"name", "elbow"}, {"range", {{"lower", -1.5}, {"upper", 1.5}}}};
///     j["counts"] = Json::array();
///     j["counts"].push_back(4096);
///
/// Braces always denote an object. A number that is not finite is null, as JSON has
/// no infinity.
class Json {
 public:
  Json();  ///< null
  Json(std::nullptr_t) : Json() {}
  Json(double value);
  Json(const char* text);
  Json(std::string_view text);
  Json(std::string text);
  Json(std::initializer_list<JsonMember> members);

  template <std::integral T>
  Json(T value) : Json() {
    if constexpr (std::same_as<T, bool>)
      set(value);
    else if constexpr (std::is_signed_v<T>)
      set(static_cast<std::int64_t>(value));
    else
      set(static_cast<std::uint64_t>(value));
  }

  /// An array.
  template <std::ranges::input_range R>
  requires(!std::same_as<R, Json> && !std::convertible_to<const R&, std::string_view> &&
           std::convertible_to<std::ranges::range_reference_t<const R>, Json>) Json(const R& values)
      : Json(array()) {
    for (const auto& value : values) push_back(value);
  }

  Json(const Json&);
  Json(Json&&) noexcept;
  Json& operator=(const Json&);
  Json& operator=(Json&&) noexcept;
  ~Json();

  static Json array();
  static Json array(std::initializer_list<Json> items);
  static Json object();

  /// The member of this name, null if it is new. @pre an object, or null, which becomes one
  Json& operator[](std::string_view name);

  /// Appends an item. @pre an array, or null, which becomes one
  void push_back(Json item);
  /// Appends the members of another object, whose names must be new. @pre both are objects
  void append(Json members);

  /// The value that a text holds (RFC 8259), with at most 64 levels.
  /// @param file  that has the text, for messages
  /// @throws Error (input) with line and column where it is no JSON
  static Json parse(const std::string& text, const std::string& file);

  bool is_null() const { return std::holds_alternative<std::nullptr_t>(value_); }
  bool is_object() const { return std::holds_alternative<Members>(value_); }
  std::optional<double> number() const;                                           ///< empty if it is none
  std::optional<bool> boolean() const;                                            ///< empty if it is none
  const std::string* text() const { return std::get_if<std::string>(&value_); }   ///< null if it is none
  const std::vector<Json>* items() const { return std::get_if<Items>(&value_); }  ///< null: no array
  std::span<const JsonMember> members() const;                                    ///< of an object, else none
  const Json* find(std::string_view name) const;                                  ///< null if it is missing

  /// The document: indented by two blanks a level, with a line break at its end. Doubles are written with as
  /// many digits as read back as the same double; bytes that are not UTF-8 are replaced by U+FFFD.
  std::string document() const;
  /// The document on one line, without the break.
  std::string line() const;

 private:
  friend struct JsonText;

  // Defined where members are a complete type, which assigning to the variant needs.
  void set(bool);
  void set(std::int64_t);
  void set(std::uint64_t);

  using Items = std::vector<Json>;
  using Members = std::vector<JsonMember>;
  std::variant<std::nullptr_t, bool, std::int64_t, std::uint64_t, double, std::string, Items, Members> value_;
};

struct JsonMember {
  std::string name;
  Json value;
};

}  // namespace qerr
