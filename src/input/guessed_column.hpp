#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace qerr {

enum class ColumnRole { none, other, position, counts, velocity, effort, command, temperature, tip };

/// A column of the log, as far as it is understood.
struct GuessedColumn {
  std::size_t index = 0;
  std::string name, unit;  ///< of the header
  std::vector<std::string> words;
  std::vector<double> values;
  ColumnRole role = ColumnRole::none;
  std::optional<std::size_t> joint;  ///< of a tip: the coordinate
  int side = 0;                      ///< > 0: of the load; > 1: of a sensor beside the robot
  std::string unknown_unit;          ///< of the header

  bool whole() const;
  double largest() const;
  /// The smallest step between neighbours: that of a quantized column; 0 of one that rests.
  double smallest_step() const;
};

/// Words and numbers of a name, in lower case: `actualQ_0` is actual, q, 0.
std::vector<std::string> words_in(const std::string& name);

/// Whether a word is one of those in a text, which has a blank before and behind each.
bool has_word(std::string_view words, const std::string& word);

/// What a column is by the words of its name, in English, German or French.
ColumnRole role_of(const std::vector<std::string>& words);

/// Whether a word says what a column is, or on which side of the gear it is.
bool is_known_word(const std::string& word);
/// -1 for a word of the motor's side, 1 for one of the load's, 2 for one of a sensor beside the robot.
int side_of(const std::string& word);
/// Whether it is of a sensor beside the robot.
bool is_of_sensor(const std::string& word);

/// The numbers among the first cells of a column, dates and times as seconds.
std::vector<double> numbers_of(const std::vector<std::string>& texts);

/// Correlation coefficient of two columns of one table; 0 if one of them rests, or has gaps.
double correlation_of(const std::vector<double>& x, const std::vector<double>& y);

}  // namespace qerr
