#pragma once

#include <cmath>
#include <concepts>
#include <functional>
#include <initializer_list>
#include <nlohmann/json.hpp>
#include <optional>
#include <ranges>
#include <set>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

/// The members of a report's objects as rows: JSON and JSON Schema (draft 2020-12) follow from one list.
///
///     RowsOf<Toy> rows(Of<Toy>) {
///       return {{"mass", &Toy::mass, "[kg]"},
///               {"twice", [](auto& toy) { return 2 * toy.mass; }},
///               {"owner", &Toy::owner, optional},  // a text, absent if it is empty
///               {"parts", &Toy::parts}};           // a list of objects, with rows(Of<Part>)
///     }
///     json_of(toy), schema_of<Toy>()
///
/// The schema of a member follows from the type of its value. Objects are open: a later version may add
/// members.
namespace qerr {

/// JSON whose objects keep the order in which their members were added. A number that is not finite is null.
using Json = nlohmann::ordered_json;

/// The value that a text holds (RFC 8259), with at most 64 levels.
/// @param file  that has the text, for messages
/// @throws Error (input) with line and column where it is no JSON
Json parse_json(const std::string& text, const std::string& file);

/// The document: indented by two blanks a level, with a line break at its end. Doubles are written with as
/// many digits as read back as the same double; bytes that are not UTF-8 are replaced by U+FFFD.
std::string document(const Json&);
/// The document on one line, without the break.
std::string line(const Json&);

/// What a member without a value is: that of an empty std::optional, and of rows that are not `required` an
/// empty text, list or object. A number that is not finite is null in any case.
enum class Presence { required, nullable, optional };
inline constexpr Presence nullable = Presence::nullable;  ///< null
inline constexpr Presence optional = Presence::optional;  ///< absent

namespace schema {

Json number();
Json text();
Json boolean();
Json list(Json items);
Json map(Json values);  ///< an object with any names
Json or_null(Json schema);

}  // namespace schema

/// What `of` makes of each item, as a list. (Clang 14 does not accept the views of GCC 12's library.)
template <class Item, class Of>
auto each(const std::vector<Item>& items, Of of) {
  std::vector<std::decay_t<std::invoke_result_t<Of&, const Item&>>> values;
  values.reserve(items.size());
  for (const Item& item : items) values.push_back(std::invoke(of, item));
  return values;
}

/// A schema that the type of the value does not tell.
struct Schema {
  Json json;
};
Schema constant(std::string_view text);
Schema one_of(const std::vector<std::string>& words);
Schema numbers_or_null();        ///< a list
Schema named_numbers_or_null();  ///< an object with any names

struct MemberRow {
  std::string name, meaning = {};
  Presence presence = Presence::required;
  std::function<Json()> schema = {};                           ///< of a value that is not empty
  std::function<std::optional<Json>(const void*)> value = {};  ///< of a source

  void add(std::string_view text) { meaning = text; }
  void add(Presence p) { presence = p; }
  void add(const Schema& s) {
    schema = [json = s.json] { return json; };
  }
};

Json object_of(const std::vector<MemberRow>&, const void* source);
Json schema_of(const std::vector<MemberRow>&);
/// The value of a row, which is none if it may lack one and is an empty text, list or object.
std::optional<Json> unless_empty(Json, Presence);

template <class T>
Json json_of(const T& value);
template <class T>
Json schema_of();

namespace kind {

template <class T>
concept Text = std::convertible_to<const T&, std::string_view> && !std::same_as<T, Json>;
template <class T>
concept List = !Text<T> && !std::same_as<T, Json> && std::ranges::input_range<const T>;
template <class T>
concept Map = List<T> && requires(std::ranges::range_value_t<const T> entry) {
  entry.second;
};
template <class T>
inline constexpr bool is_optional = false;
template <class T>
inline constexpr bool is_optional<std::optional<T>> = true;

}  // namespace kind

template <class Source>
struct RowsOf;

template <class Source>
struct RowOf : MemberRow {
  /// @param getter   of the value; or the rows of an object that has the same source
  /// @param details  the meaning, the presence, the schema, in any order
  template <class Getter = RowsOf<Source>, class... Details>
  RowOf(std::string_view of, const Getter& getter, const Details&... details) : MemberRow{std::string(of)} {
    if constexpr (std::same_as<Getter, RowsOf<Source>>) {
      schema = [list = getter.list] { return schema_of(list); };
      value = [list = getter.list](const void* source) { return object_of(list, source); };
      (add(details), ...);
    } else {
      using Value = std::remove_cvref_t<std::invoke_result_t<const Getter&, const Source&>>;
      constexpr bool may_lack = kind::is_optional<Value>;
      if constexpr (may_lack) presence = Presence::nullable;
      schema = schema_of<typename std::conditional_t<may_lack, Value, std::optional<Value>>::value_type>;
      (add(details), ...);
      const auto member = [getter](const void* source) -> decltype(auto) {
        return std::invoke(getter, *static_cast<const Source*>(source));
      };
      if constexpr (may_lack)
        value = [member](const void* source) {
          const auto& found = member(source);
          return found ? std::optional(json_of(*found)) : std::nullopt;
        };
      else
        value = [member, p = presence](const void* source) {
          return unless_empty(json_of(member(source)), p);
        };
    }
  }
};

template <class Source>
struct RowsOf {
  std::vector<MemberRow> list;

  RowsOf(std::initializer_list<RowOf<Source>> rows) : list(rows.begin(), rows.end()) {}
  RowsOf with(const RowsOf& more) const {
    RowsOf all = *this;
    all.list.insert(all.list.end(), more.list.begin(), more.list.end());
    return all;
  }
};

/// Names a type, of which a function `rows` states the rows.
template <class Source>
struct Of {};

template <class Source>
const std::vector<MemberRow>& rows_of() {
  static const std::vector<MemberRow> list = rows(Of<Source>()).list;
  return list;
}

/// The value on a condition, else none.
template <class T>
std::optional<T> only_if(bool condition, T value) {
  return condition ? std::optional<T>(std::move(value)) : std::nullopt;
}

/// The values of a list by their names, for an object whose members they are.
template <class List, class Name, class Value>
auto by_name(const List& list, Name name, Value value) {
  using Item = std::ranges::range_value_t<List>;
  std::vector<std::pair<std::string, std::decay_t<std::invoke_result_t<Value, const Item&>>>> all;
  for (const Item& item : list) all.emplace_back(std::invoke(name, item), std::invoke(value, item));
  return all;
}

/// An item, the object that has it, and its index there: the source of rows that tell more than the item
/// knows. Its rows may name members of the item.
template <class Item, class Whole>
struct In {
  Item item;
  const Whole& whole;
  std::size_t i = 0;

  const Item& operator*() const { return item; }
  const Item* operator->() const { return &item; }
};

template <class T, class Whole>
auto items_of(const T& value, const Whole& whole) {
  if constexpr (kind::is_optional<T>) {
    return value ? std::optional(items_of(*value, whole)) : std::nullopt;
  } else if constexpr (kind::List<T>) {
    std::vector<In<std::ranges::range_value_t<const T>, Whole>> all;
    for (const auto& item : value) all.push_back({item, whole, all.size()});
    return all;
  } else {
    return In<T, Whole>{value, whole};
  }
}

/// The getter of an item or of the items of a list, each with the object that has them.
template <class Getter>
auto within(Getter getter) {
  return [getter](const auto& whole) { return items_of(std::invoke(getter, whole), whole); };
}

template <class T>
Json json_of(const T& value) {
  if constexpr (kind::is_optional<T>) {
    return value ? json_of(*value) : Json();
  } else if constexpr (kind::Map<T>) {
    Json object = Json::object();
    for (const auto& [name, entry] : value) object[name] = json_of(entry);
    return object;
  } else if constexpr (kind::List<T>) {
    Json list = Json::array();
    for (const auto& item : value) list.push_back(json_of(item));
    return list;
  } else if constexpr (std::floating_point<T>) {
    return std::isfinite(value) ? Json(value) : Json();
  } else if constexpr (kind::Text<T>) {
    return std::string(std::string_view(value));
  } else if constexpr (std::is_arithmetic_v<T> || std::same_as<T, Json>) {
    return value;
  } else {
    return object_of(rows_of<T>(), &value);
  }
}

template <class T>
Json schema_of() {
  if constexpr (kind::is_optional<T>)
    return schema::or_null(schema_of<typename T::value_type>());
  else if constexpr (kind::Map<T>)
    return schema::map(schema_of<decltype(std::ranges::range_value_t<const T>::second)>());
  else if constexpr (kind::List<T>)
    return schema::list(schema_of<std::ranges::range_value_t<const T>>());
  else if constexpr (kind::Text<T>)
    return schema::text();
  else if constexpr (std::same_as<T, bool>)
    return schema::boolean();
  else if constexpr (std::is_arithmetic_v<T>)
    return schema::number();
  else if constexpr (std::same_as<T, Json>)
    return Json::object();
  else
    return schema_of(rows_of<T>());
}

/// Cells of CSV as RFC 4180 has them; a row ends with "\r\n".

/// The text with hidden characters escaped (core/text.hpp), quoted where it would be read otherwise. A text
/// that a spreadsheet would take for a formula, and that is no quantity such as `-5 deg`, starts with an
/// apostrophe, which column_name (input/csv.hpp) removes.
std::string csv_cell(const std::string& text);

/// The shortest digits that read back as the same double; `inf` of what is unbounded; empty, which plotting
/// tools read as missing, of what is not known.
std::string csv_number(double value);
std::string csv_number(const std::optional<double>& value);

/// Cells of an object's members; a path such as `limits.lower` names those of an object in it. Empty:
/// missing.
std::string csv_cells(const Json& object, const std::vector<std::string>& paths);

/// The paths of all members that are no objects. @param schema  of an object
std::vector<std::string> csv_paths(const Json& schema);

/// One row for each item, with a column for each of its members but those `without`.
template <class T>
std::string csv_of(const std::vector<T>& items, const std::set<std::string>& without = {}) {
  std::vector<std::string> paths = csv_paths(schema_of<T>());
  std::erase_if(paths, [&](const std::string& path) { return without.contains(path); });
  std::string out;
  for (const std::string& path : paths) out += (out.empty() ? "" : ",") + path.substr(path.rfind('.') + 1);
  for (const T& item : items) out += "\r\n" + csv_cells(json_of(item), paths);
  return out + "\r\n";
}

}  // namespace qerr
