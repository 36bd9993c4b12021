#pragma once

#include <atomic>
#include <cstdint>
#include <limits>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "qerr/input/read_log.hpp"
#include "qerr/report/analysis.hpp"

namespace qerr::cli {

/// A program that runs commands within its own process, such as Python: reports and warnings go to it in
/// place of standard output and standard error.
struct Caller {
  std::vector<std::string> formats;            ///< in which it wants the report
  std::vector<LogArray> log;                   ///< in place of the files of a log
  std::map<std::string, std::string> reports;  ///< by format
  std::vector<std::string> warnings;
  bool wants_columns = false;  ///< of `analyze`: the figures of every configuration
  ConfigurationColumns columns;
  std::atomic<bool> stops = false;  ///< set by the caller: the work that shows progress ends with Stopped
};

struct Stopped {};

/// The caller of the running command; null: the program `qerr` itself.
inline Caller*& caller() {
  static Caller* current = nullptr;
  return current;
}

/// How an option is written, and how its text is checked.
enum class OptionKind {
  flag,      ///< without a value
  text,      ///< one value
  repeat,    ///< one value each time the option is given
  list,      ///< as `repeat`, and values may be separated by commas
  pair,      ///< two values
  optional,  ///< one value or none: the next word is its value if `is_value` says so
  number,    ///< a number between `least` and `most`
  whole,     ///< a whole number between `least` and `most`
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
  /// Whether a word is the value of an `optional` option, and no argument or option of its own; `implied` is
  /// the value where none is given.
  bool (*is_value)(const std::string&) = nullptr;
  std::string_view implied = {};
  /// The permitted words; null: any text.
  std::vector<std::string> (*choices)() = nullptr;
  bool open = false;                 ///< the choices are proposals: any other text is permitted, too
  std::string_view choice = {};      ///< what a word is, in messages: `format`
  std::string_view endings = {};     ///< of the files that it may name, such as `.json .txt`; "": any
  std::string_view stands_for = {};  ///< of a flag: the option in full, such as `--format=json`
  /// The permitted words behind the argument before, where they depend on it; null: they do not.
  std::vector<std::string> (*choices_behind)(const std::string& before) = nullptr;

  bool positional() const { return !name.starts_with('-'); }
  bool takes_value() const { return positional() || kind != OptionKind::flag; }
  bool needs_value() const { return takes_value() && kind != OptionKind::optional; }
  bool repeats() const { return kind == OptionKind::repeat || kind == OptionKind::list; }
  std::string long_name() const;   ///< `--output` of `-o,--output`; `SPEC` of `SPEC`
  std::string short_name() const;  ///< `-o`; "" if it has none
  std::string key() const;         ///< `output`: the name by which Values has it
  std::string range() const;       ///< `1 to 1024` of a number; "" of other kinds

  Option& within(double lowest, double highest) { return least = lowest, most = highest, *this; }
  Option& otherwise(std::string_view text) { return fallback = text, *this; }
  Option& one_of(std::vector<std::string> (*words)(), std::string_view what) {
    return choices = words, choice = what, *this;
  }
  Option& with(std::string_view other) { return needs = other, *this; }
  Option& must() { return required = true, *this; }
};

/// Rows of options without and with a value. @param value  its name in the help
inline Option flag(std::string_view name, std::string_view meaning) {
  return {.name = name, .kind = OptionKind::flag, .meaning = meaning};
}
inline Option valued(std::string_view name, std::string_view value, std::string_view meaning,
                     OptionKind kind = OptionKind::text) {
  return {.name = name, .value = value, .kind = kind, .meaning = meaning};
}

/// Values of the command line, by the key of their rows. A key that the command does not have is a
/// logic_error.
class Values {
 public:
  using Texts = std::map<std::string, std::vector<std::string>, std::less<>>;

  /// @param given  every key of the command, with no texts where the command line does not have it
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

/// A command line to copy, and what it answers.
struct Example {
  std::string_view line;
  std::string_view answer;
};

/// A row: one command, its line in the help, its own options, its work, and what its help shows. The parser,
/// the help, the man pages and the completions read it.
struct Command {
  std::string_view name;
  std::string_view summary;
  std::vector<Option> options;
  int (*run)(const Values&);             ///< returns the exit code
  std::vector<Example> examples = {};    ///< at least one
  std::vector<std::string> topics = {};  ///< names of help topics to read next
};

/// Every command, in the order of the help, with the options that all have. To add one: a file that defines
/// its row, and a line in command_line.cpp.
const std::vector<Command>& commands();

/// The row of this name; null if there is none.
const Command* command_of(std::string_view name);
std::vector<std::string> command_names();

/// `qerr analyze [OPTION...] SPEC`
std::string usage_line(const Command&);

/// Options that every command has, and that may also stand before its name.
const std::vector<Option>& global_options();

Command analyze_command();
Command check_command();
Command compare_command();
Command design_command();
Command filter_command();
Command simulate_command();
Command diagnose_command();
Command sweep_command();
Command merge_command();
Command threshold_command();
Command robot_command();
Command list_command();
Command schema_command();
Command help_command();
Command completion_command();

/// Parses the arguments by the rows and runs the command.
/// @param words  without the name of the program
/// @returns the exit code
/// @throws Error (usage) for arguments that do not fit the rows
int run_command_line(const std::vector<std::string>& words);

}  // namespace qerr::cli
