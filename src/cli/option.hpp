#pragma once

#include <cstdint>
#include <limits>
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace qerr::cli {

/// How an option is written, and how its text is checked.
enum class OptionKind {
  flag,    ///< without a value
  text,    ///< one value
  repeat,  ///< one value each time the option is given
  list,    ///< as `repeat`, and values may be separated by commas
  pair,    ///< two values
  number,  ///< a number between `least` and `most`
  whole,   ///< a whole number between `least` and `most`
};

/// A row: one option or argument of a command.
struct Option {
  std::string_view name;        ///< `--runs`; `-o,--output`; of a positional argument `SPEC`
  std::string_view value = {};  ///< the value's name in the help, such as `FILE.csv`
  OptionKind kind = OptionKind::text;
  std::string_view meaning;
  std::string_view fallback = {};  ///< value when the option is absent
  double least = -std::numeric_limits<double>::infinity();
  double most = std::numeric_limits<double>::infinity();
  bool required = false;
  std::string_view needs = {};  ///< another option that must be given, too
  /// The permitted words; null: any text.
  std::vector<std::string> (*choices)() = nullptr;
  std::string_view choice = {};  ///< what a word is, in messages: `format`
};

/// Values of the command line, by the long name of an option without its dashes, or the name of an argument.
/// A name that the command does not have is a logic_error.
class Values {
 public:
  using Texts = std::map<std::string, std::vector<std::string>, std::less<>>;

  /// @param given  every name of the command, with no texts where the command line does not have it
  Values(Texts given, Texts fallbacks);

  bool given(std::string_view name) const;                             ///< on the command line
  const std::string& text(std::string_view name) const;                ///< if absent its fallback, or ""
  const std::vector<std::string>& texts(std::string_view name) const;  ///< as given

  /// @pre the option is given, or its row has a fallback
  double number(std::string_view name) const;
  std::uint64_t whole(std::string_view name) const;

 private:
  Texts given_, fallbacks_;
};

}  // namespace qerr::cli
