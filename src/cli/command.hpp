#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "cli/option.hpp"

namespace qerr::cli {

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
/// its row, and a line in commands.cpp.
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
