#pragma once

#include <string>
#include <vector>

#include "cli/command.hpp"
#include "core/text.hpp"

namespace qerr::cli {

/// Scripts that complete the words of a qerr command line in a shell, made from the rows of the commands.

std::string bash_completion();
std::string zsh_completion();
std::string fish_completion();

/// The words with blanks between.
std::string spaced(const std::vector<std::string>& words);

/// The arguments of a command, in their order.
std::vector<const Option*> arguments_of(const Command&);

}  // namespace qerr::cli
