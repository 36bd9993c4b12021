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
};

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

}  // namespace qerr
