#pragma once

#include <algorithm>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "qerr/core/quantity.hpp"

namespace qerr {

/// Kind of a value in the spec.
///
/// `numbers` is a list of numbers; `matrix` is a number, a list of numbers or a list of rows of numbers.
enum class Kind { number, integer, boolean, text, choice, numbers, matrix, object, objects, map, any };

/// One key of the spec, a filter family, an encoder kind or an effect: the row that the strict reader, the
/// JSON Schema and `qerr list` use.
///
///     key::number("cutoff", "of the low-pass", dimension::frequency).above(0).needed()
struct Parameter {
  std::string_view name;
  Kind kind = Kind::number;
  Dimension dimension = {};       ///< of a number; see `coordinate` for joint coordinates
  std::string_view meaning = {};  ///< one line for `qerr list` and the schema
  bool required = false;
  std::optional<double> fallback = {};  ///< default of a number, in SI units
  double least = -std::numeric_limits<double>::infinity();
  double most = std::numeric_limits<double>::infinity();
  bool open_below = false;  ///< `least` itself is out of range
  bool open_above = false;
  bool nonzero = false;           ///< a number of either sign, but not 0
  std::string_view choices = {};  ///< of a choice: "matched|tustin"; the first one is the default
  bool coordinate = false;        ///< a joint coordinate: rad for a revolute joint, m for a prismatic one
  /// Largest usual magnitude in SI units: a number beyond it that is written without a unit was probably
  /// meant in another one (10 for 10 mm), and is warned of.
  double usual = std::numeric_limits<double>::infinity();
  bool angular = false;  ///< a frequency that may also be written as an angular one, in rad/s

  Parameter& needed() { return required = true, *this; }
  Parameter& otherwise(double value) { return fallback = value, *this; }
  Parameter& from(double value) { return least = value, *this; }
  Parameter& above(double value) { return open_below = true, from(value); }
  Parameter& up_to(double value) { return most = value, *this; }
  Parameter& within(double lowest, double highest) { return from(lowest).up_to(highest); }
  Parameter& below(double value) { return open_above = true, up_to(value); }
  Parameter& not_zero() { return nonzero = true, *this; }
  Parameter& usually_below(double value) { return usual = value, *this; }
  Parameter& or_angular() { return angular = true, *this; }
};

/// Rows of the kinds.
namespace key {

inline Parameter of_kind(Kind kind, std::string_view name, std::string_view meaning,
                         Dimension dimension = {}) {
  return {.name = name, .kind = kind, .dimension = dimension, .meaning = meaning};
}
inline Parameter number(std::string_view name, std::string_view meaning, Dimension dimension = {}) {
  return of_kind(Kind::number, name, meaning, dimension);
}
inline Parameter coordinate(std::string_view name, std::string_view meaning) {
  return {.name = name, .meaning = meaning, .coordinate = true};
}
inline Parameter integer(std::string_view name, std::string_view meaning) {
  return of_kind(Kind::integer, name, meaning);
}
inline Parameter text(std::string_view name, std::string_view meaning) {
  return of_kind(Kind::text, name, meaning);
}
inline Parameter any(std::string_view name, std::string_view meaning) {
  return of_kind(Kind::any, name, meaning);
}
inline Parameter map(std::string_view name, std::string_view meaning) {
  return of_kind(Kind::map, name, meaning);
}
inline Parameter object(std::string_view name, std::string_view meaning) {
  return of_kind(Kind::object, name, meaning);
}
inline Parameter objects(std::string_view name, std::string_view meaning) {
  return of_kind(Kind::objects, name, meaning);
}
inline Parameter numbers(std::string_view name, std::string_view meaning, Dimension dimension = {}) {
  return of_kind(Kind::numbers, name, meaning, dimension);
}
inline Parameter choice(std::string_view name, std::string_view choices, std::string_view meaning) {
  return {.name = name, .kind = Kind::choice, .meaning = meaning, .choices = choices};
}

}  // namespace key

/// The words of a list such as "matched|tustin".
inline std::vector<std::string> words_of(std::string_view list) {
  std::vector<std::string> words;
  for (std::size_t begin = 0; begin < list.size();) {
    const std::size_t bar = std::min(list.find('|', begin), list.size());
    words.emplace_back(list.substr(begin, bar - begin));
    begin = bar + 1;
  }
  return words;
}

/// The words of `choices`.
inline std::vector<std::string> choices_of(const Parameter& p) { return words_of(p.choices); }

/// Magnitudes that a quantity can have in a machine [SI units].
struct PhysicalRange {
  double smallest = 0;  ///< of those that are not 0
  double largest = 0;
};

/// What physics leaves for a dimension; a wide range of numbers, whose squares do not overflow, for those
/// that are not in the table (src/core/parameter.cpp).
PhysicalRange physical_range(const Dimension&);

/// The parameter with the bounds of physics where its row states none: the largest magnitude, and the
/// smallest one where only zero is excluded.
/// @param coordinate  of a joint coordinate, for rows that have one
Parameter with_physical_range(Parameter, const Dimension& coordinate);

}  // namespace qerr
