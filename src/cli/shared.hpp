#pragma once

#include <atomic>
#include <cstdint>
#include <exception>
#include <functional>
#include <initializer_list>
#include <limits>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/output_file.hpp"
#include "input/spec_variants.hpp"
#include "qerr/bound/workspace.hpp"
#include "qerr/core/error.hpp"
#include "qerr/input/read_log.hpp"
#include "qerr/input/spec.hpp"
#include "qerr/report/analysis.hpp"
#include "qerr/report/write.hpp"

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

// What several commands share: options, the spec, the form of results and messages.

/// Colours as --color says, the width of lines (COLUMNS, else the terminal's, else 80), and pictures in ASCII
/// unless the locale is UTF-8.
/// @param on_standard_output  whether the text goes there; a file has no colours unless they are asked for
Style terminal_style(const Values&, bool on_standard_output = true);

/// The width of messages on standard error; 0 where they are not for a terminal and each has one line.
std::size_t message_width();

/// Shows on a terminal's standard error, at most ten times a second, the part that is done, how much is done
/// in a second and the remaining time; nothing elsewhere, and nothing with --quiet.
/// @param noun  what is counted: `configurations`
std::function<void(std::uint64_t done, std::uint64_t total)> progress(const Values&,
                                                                      std::string_view noun = "");

/// Shows the progress of searches whose number is not known, as `progress` does: which one it is, and how
/// much of the work after which it ends at the latest.
std::function<void(std::size_t search, double part)> search_progress(const Values&);

/// What Ctrl-C leaves on a terminal, in a line of its own: how to go on, if a command has said so. Allocates
/// nothing.
std::string_view interrupt_message() noexcept;
void say_on_interrupt(const std::string& how_to_go_on);

/// `12 s`, `3 min 20 s`, `2 h 5 min`, `12 days`.
std::string duration(double seconds);

/// Removes the line of the progress, if there is one, before something else is printed.
void clear_progress();

/// A message on standard error, below the progress.
void print_error(const std::string& text);

/// The argument SPEC, and the options that change a spec and its evaluation.
std::vector<Option> spec_options(std::string_view meaning = "the spec (YAML); '-' reads standard input");
/// `--allow-long`, of commands that call limit_work.
std::vector<Option> long_work_option();
/// `--format` and `--output` of a command whose report has a page, of one whose report has none, and of one
/// that has Markdown, too.
std::vector<Option> output_options();
std::vector<Option> output_options_without_page();
std::vector<Option> output_options_with_markdown();
/// `-o,--output` of a command whose output has one format.
/// @param endings  of the files that hold this format
Option text_output_option(std::string_view endings = {});
std::vector<Option> joined(std::initializer_list<std::vector<Option>> groups);

/// An error in the use of the command line.
Error usage(const std::string& option, const std::string& rule, const std::string& found,
            const std::string& remedy);

SpecOverrides overrides(const Values&);

/// The spec with the changes of --set and --seed, and among its warnings those of changes that the report
/// does not show.
/// @param unused  sections of the spec that the command does not use
/// @param report  what the command says of a spec, at some configurations if it evaluates many
Spec load(const std::string& path, const Values&, const std::vector<std::string_view>& unused,
          const ReportText& report = {});

/// Only one of the inputs of a run may be standard input.
/// @param option  that names the second one, for the message
/// @throws Error (usage)
void refuse_shared_input(const std::vector<std::string>& paths, const std::string& option);

unsigned threads(const Values&);
/// Threads and progress of an evaluation of configurations.
WorkspaceOptions workspace_options(const Values&);

/// `--prove [GAP]`.
Option prove_option(std::string_view meaning);
/// The gap of --prove, 1 % if it is absent; `all` is not set.
/// @throws Error (usage) for a gap that is none
ProofRequest proof_request(const Values&);

/// A part such as `2%` or `0.02` that an option gives.
/// @throws Error (usage) with the rule if it is not between `least` and `most`
double part_of(const Values&, const std::string& option, double least, double most, const std::string& rule,
               const std::string& remedy);

/// The format of --format, else the one of the output's ending.
std::string chosen_format(const Values&);
Style style(const Values&);

/// The output of an option, opened before the computation, so that a path that cannot be written fails early;
/// null if the option is absent and has no fallback.
std::unique_ptr<OutputFile> opened(const Values&, const std::string& option);

/// The output of the report; null if one of the other options has standard output, and neither --output nor
/// --format asks for a report beside it.
std::unique_ptr<OutputFile> opened_report(const Values&, std::initializer_list<const char*> others);

/// Refuses an output whose ending is no format of the command, before any work.
/// @throws Error (usage)
void require_known_ending(const std::vector<Option>& of_command, const Values&);

/// Writes outputs of which one that fails does not lose the others: the first error is thrown at the end.
class Outputs {
 public:
  template <class Write>
  void write(Write write_one) {
    try {
      write_one();
    } catch (const Error&) {
      if (!failure_) failure_ = std::current_exception();
    }
  }
  /// Writes a further part of an output: nothing if one has failed.
  template <class Write>
  void write_next(Write write_one) {
    if (good()) write(write_one);
  }
  /// Whether all have been written so far.
  bool good() const { return !failure_; }
  void finish() const {
    if (failure_) std::rethrow_exception(failure_);
  }

 private:
  std::exception_ptr failure_;
};

/// Writes a text to a file that is already open, and closes it.
void finish(OutputFile& file, const std::string& text);

/// Writes a spec to a file that is already open, and closes it; a later run may replace the spec while it is
/// as it was written.
void finish_spec(OutputFile& file, const std::string& text, const std::string& path);

/// Writes a report to a file that is already open, and closes it; or gives it to the caller.
template <class Report>
void finish(OutputFile& file, const Report& report, const std::string& format, const Style& style,
            const std::string& above = "") {
  if (!caller()) return finish(file, above + write(report, format, style));
  for (const std::string& wanted : caller()->formats)
    caller()->reports[wanted] = write(report, wanted, style);
}

template <class Report>
void finish(OutputFile& file, const Report& report, const Values& v) {
  finish(file, report, chosen_format(v), style(v));
}

/// Refuses work that takes hours unless --allow-long permits it: more than 1e10 configurations or samples.
/// @param key  of the spec, which decides how much it is
/// @throws Error (input) with the time that it would take
/// @param rate  how many a second; by default configurations or samples of an arm of 7 joints, 6 coordinates
///   and 2 filters on two cores of 2023
void limit_work(const Spec&, double amount, const std::string& key, const std::string& noun, const Values&,
                double rate = 2e7);
void limit_configurations(const Spec&, const Values&);

/// Warnings to standard error, one line each, unless --quiet.
void warn(const std::vector<std::string>& warnings, const Values&);

/// The warnings of each spec, by its file.
using SpecWarnings = std::vector<std::pair<std::string, std::vector<std::string>>>;

/// Each warning once, behind the names of its specs where there are several.
void warn(const SpecWarnings&, const Values&);

}  // namespace qerr::cli
