#include "cli/command.hpp"

namespace qerr::cli {

namespace {

std::vector<std::string> when_words() { return {"auto", "always", "never"}; }

std::vector<Command> table() {
  std::vector<Command> rows{analyze_command(),  check_command(),     compare_command(),   sweep_command(),
                            merge_command(),    design_command(),    filter_command(),    simulate_command(),
                            diagnose_command(), threshold_command(), robot_command(),     list_command(),
                            schema_command(),   help_command(),      completion_command()};
  for (Command& command : rows)
    command.options.insert(command.options.end(), global_options().begin(), global_options().end());
  return rows;
}

}  // namespace

const std::vector<Option>& global_options() {
  static const std::vector<Option> rows{
      {.name = "-q,--quiet", .kind = OptionKind::flag, .meaning = "no warnings, no progress"},
      {.name = "--color",
       .value = "WHEN",
       .meaning = "always, never, or auto: on a terminal, unless NO_COLOR is set",
       .fallback = "auto",
       .choices = when_words,
       .choice = "choice"},
      {.name = "--no-color", .kind = OptionKind::flag, .meaning = "the same as --color never"},
      {.name = "--progress",
       .value = "WHEN",
       .meaning = "always, never, or auto: on a terminal, unless --quiet",
       .fallback = "auto",
       .choices = when_words,
       .choice = "choice"},
      {.name = "--force",
       .kind = OptionKind::flag,
       .meaning = "let an output replace a spec, URDF or catalogue, which a person may have edited"},
      {.name = "-h,--help", .kind = OptionKind::flag, .meaning = "this help"},
      {.name = "-V,--version", .kind = OptionKind::flag, .meaning = "the version of qerr"}};
  return rows;
}

const std::vector<Command>& commands() {
  static const std::vector<Command> rows = table();
  return rows;
}

const Command* command_of(std::string_view name) {
  for (const Command& command : commands())
    if (command.name == name) return &command;
  return nullptr;
}

std::vector<std::string> command_names() {
  std::vector<std::string> names;
  for (const Command& command : commands()) names.emplace_back(command.name);
  return names;
}

std::string usage_line(const Command& command) {
  std::string line = "qerr " + std::string(command.name) + " [OPTION...]";
  for (const Option& row : command.options)
    if (row.positional())
      line += (row.required ? " " : " [") + std::string(row.name) + (row.repeats() ? "..." : "") +
              (row.required ? "" : "]");
  return line;
}

}  // namespace qerr::cli
