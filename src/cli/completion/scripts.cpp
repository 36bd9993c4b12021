#include "cli/completion/scripts.hpp"

namespace qerr::cli {

std::string spaced(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : " ") + word;
  return text;
}

std::vector<const Option*> arguments_of(const Command& command) {
  std::vector<const Option*> rows;
  for (const Option& row : command.options)
    if (row.positional()) rows.push_back(&row);
  return rows;
}

}  // namespace qerr::cli
