#include "cli/completion/scripts.hpp"

namespace qerr::cli {

namespace {

/// A branch of `case $command:$before`: the words behind an option or behind an argument.
std::string branch(const std::string& command, const std::string& before,
                   const std::vector<std::string>& words) {
  return "    " + command + ':' + before + ") words=" + shell_quoted(spaced(words)) + " ;;\n";
}

std::string branches(const Command& command) {
  const std::string name(command.name);
  std::string out;
  for (const Option& row : command.options)
    if (!row.positional() && row.choices) out += branch(name, row.long_name(), row.choices());
  std::vector<std::string> before{name};
  for (const Option* row : arguments_of(command)) {
    if (row->choices)
      for (const std::string& word : before) out += branch(name, word, row->choices());
    if (row->choices_behind)
      for (const std::string& word : before) out += branch(name, word, row->choices_behind(word));
    before = row->choices ? row->choices() : std::vector<std::string>{};
  }
  return out;
}

std::string options_of(const Command& command) {
  std::vector<std::string> names;
  for (const Option& row : command.options)
    if (!row.positional()) names.push_back(row.long_name());
  return "    " + std::string(command.name) + ") words=" + shell_quoted(spaced(names)) + " ;;\n";
}

}  // namespace

std::string bash_completion() {
  std::string names, choices, options;
  for (const Command& command : commands()) {
    names += (names.empty() ? "" : "|") + std::string(command.name);
    choices += branches(command);
    options += options_of(command);
  }
  return R"(# bash completion of qerr, made by: qerr completion bash
_qerr() {
  local word=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD - 1]} command='' words='' i
  if [[ $word == '=' ]]; then
    word=''
  elif [[ $before == '=' ]]; then
    before=${COMP_WORDS[COMP_CWORD - 2]}
  fi
  for ((i = 1; i < COMP_CWORD; ++i)); do
    case ${COMP_WORDS[i]} in
    )" + names +
         R"()
      command=${COMP_WORDS[i]}
      break
      ;;
    esac
  done
  case $command:$before in
)" + choices +
         R"(  esac
  if [[ -z $words && -z $command ]]; then
    words=)" +
         shell_quoted(spaced(command_names())) + R"(
  elif [[ -z $words && $word == -* ]]; then
    case $command in
)" + options +
         R"(    esac
  fi
  if [[ -n $words ]]; then
    mapfile -t COMPREPLY < <(compgen -W "$words" -- "$word")
  else
    mapfile -t COMPREPLY < <(compgen -f -- "$word")
  fi
}
complete -o filenames -F _qerr qerr
)";
}

}  // namespace qerr::cli
