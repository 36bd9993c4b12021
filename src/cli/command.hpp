#pragma once

#include <string_view>
#include <vector>

#include "cli/option.hpp"

namespace qerr::cli {

/// A row: one command, its line in the help, its own options, and its work.
struct Command {
  std::string_view name;
  std::string_view summary;
  std::vector<Option> options;
  int (*run)(const Values&);  ///< returns the exit code
};

/// Every command, in the order of the help. To add one: a file that defines its row, and a line in
/// commands.cpp.
const std::vector<Command>& commands();

Command analyze_command();
Command check_command();
Command filter_command();
Command simulate_command();
Command diagnose_command();
Command threshold_command();
Command robot_command();
Command list_command();
Command schema_command();

/// Parses the arguments by the rows and runs the command.
/// @returns the exit code
/// @throws Error (usage) for arguments that do not fit the rows
int run_command_line(int argc, char** argv);

}  // namespace qerr::cli
