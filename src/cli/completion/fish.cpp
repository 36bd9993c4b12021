#include "cli/completion/scripts.hpp"

namespace qerr::cli {

namespace {

/// The text in single quotes: fish escapes them by a backslash.
std::string fish_quoted(std::string_view text) {
  std::string out = "'";
  for (const char c : text) {
    if (c == '\'' || c == '\\') out += '\\';
    out += c;
  }
  return out + '\'';
}

/// A line for completions where all words have been seen.
std::string line(const std::vector<std::string>& seen, const std::string& rest) {
  std::string condition;
  for (const std::string& word : seen)
    condition += (condition.empty() ? "" : "; and ") + ("__fish_seen_subcommand_from " + word);
  return "complete -c qerr -n " + fish_quoted(condition) + ' ' + rest + '\n';
}

std::string option(const std::string& command, const Option& row) {
  std::string rest = row.short_name().empty() ? "" : "-s " + row.short_name().substr(1) + ' ';
  rest += "-l " + row.key();
  if (row.choices)
    rest += " -x -a " + fish_quoted(spaced(row.choices()));
  else if (row.needs_value())
    rest += " -r";
  return line({command}, rest + " -d " + fish_quoted(row.meaning));
}

std::string branches(const Command& command) {
  const std::string name(command.name);
  std::string out;
  const Option* before = nullptr;
  for (const Option& row : command.options) {
    if (!row.positional()) {
      out += option(name, row);
      continue;
    }
    if (row.choices) out += line({name}, "-f -a " + fish_quoted(spaced(row.choices())));
    if (row.choices_behind && before)
      for (const std::string& word : before->choices())
        out += line({name, word}, "-f -a " + fish_quoted(spaced(row.choices_behind(word))));
    before = &row;
  }
  return out;
}

}  // namespace

std::string fish_completion() {
  std::string out =
      "# fish completion of qerr, made by: qerr completion fish\ncomplete -c qerr -n __fish_use_subcommand "
      "-f\n";
  for (const Command& command : commands())
    out += "complete -c qerr -n __fish_use_subcommand -a " + std::string(command.name) + " -d " +
           fish_quoted(command.summary) + '\n';
  for (const Command& command : commands()) out += branches(command);
  return out;
}

}  // namespace qerr::cli
