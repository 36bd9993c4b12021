#pragma once

#include <string>
#include <vector>

#include "cli/command.hpp"

/// Scripts that complete the words of a qerr command line in a shell, made from the rows of the commands.
namespace qerr::cli {

std::string bash_completion();
std::string zsh_completion();
std::string fish_completion();

/// The words with blanks between.
std::string spaced(const std::vector<std::string>& words);

/// The text in single quotes, for bash and zsh.
std::string shell_quoted(const std::string& text);

/// The arguments of a command, in their order.
std::vector<const Option*> arguments_of(const Command&);

}  // namespace qerr::cli
