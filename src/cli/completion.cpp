#include "cli/shared.hpp"
#include "core/text.hpp"
#include "report/text_table.hpp"

namespace qerr::cli {

namespace {

std::string spaced(const std::vector<std::string>& words) { return qerr::joined(words, " "); }

std::vector<const Option*> arguments_of(const Command& command) {
  std::vector<const Option*> rows;
  for (const Option& row : command.options)
    if (row.positional()) rows.push_back(&row);
  return rows;
}

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

std::string fish_branches(const Command& command) {
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

std::string fish_completion() {
  std::string out =
      "# fish completion of qerr, made by: qerr completion fish\ncomplete -c qerr -n __fish_use_subcommand "
      "-f\n";
  for (const Command& command : commands())
    out += "complete -c qerr -n __fish_use_subcommand -a " + std::string(command.name) + " -d " +
           fish_quoted(command.summary) + '\n';
  for (const Command& command : commands()) out += fish_branches(command);
  return out;
}

/// Text in a specification of _arguments: colons and brackets would end it.
std::string plain(std::string_view text) {
  std::string out;
  for (const char c : text) {
    if (c == ':' || c == '[' || c == ']' || c == '\\') out += '\\';
    out += c;
  }
  return out;
}

/// What completes a value: `(json csv)`, or files.
std::string action(const Option& row) { return row.choices ? "(" + spaced(row.choices()) + ")" : "_files"; }

std::string option(const Option& row) {
  std::string rest = "[" + plain(row.meaning) + "]";
  const std::string value(row.value.empty() ? row.key() : row.value);
  if (row.needs_value()) rest += ":" + plain(value) + ":" + action(row);
  if (row.kind == OptionKind::optional) rest += "::" + plain(value) + ":";
  if (row.kind == OptionKind::pair) rest += ":" + plain(value) + ":";
  if (row.repeats()) return "        " + shell_quoted("*" + row.long_name() + rest);
  if (row.short_name().empty()) return "        " + shell_quoted(row.long_name() + rest);
  const std::string both = row.short_name() + ' ' + row.long_name();
  return "        " + shell_quoted("(" + both + ")") + "{" + row.short_name() + "," + row.long_name() + "}" +
         shell_quoted(rest);
}

std::string argument(const Option& row, std::size_t place) {
  const std::string number = row.repeats() ? "*" : std::to_string(place);
  return "        " +
         shell_quoted(number + (row.required ? ":" : "::") + plain(row.name) + ":" + action(row));
}

/// The last argument, whose words depend on the one before.
std::string dependent_argument(const Option& before, const Option& row, std::size_t place) {
  std::string out = "      case $line[" + std::to_string(place) + "] in\n";
  for (const std::string& word : before.choices())
    out += "      " + word + ") compadd -- " + spaced(row.choices_behind(word)) + " ;;\n";
  return out + "      esac\n";
}

std::string branch(const Command& command) {
  std::string rows, behind;
  std::size_t place = 0;
  const Option* before = nullptr;
  for (const Option& row : command.options) {
    if (!row.positional()) {
      rows += " \\\n" + option(row);
      continue;
    }
    ++place;
    if (row.choices_behind && before) {
      rows += " \\\n        " + shell_quoted(std::to_string(place) + "::" + plain(row.name) + ":->behind");
      behind = dependent_argument(*before, row, place - 1);
    } else {
      rows += " \\\n" + argument(row, place);
    }
    before = &row;
  }
  const std::string choice =
      behind.empty() ? "" : "      [[ $state == behind ]] && {\n" + behind + "      }\n";
  return "    " + std::string(command.name) + ")\n      _arguments -s" + rows + "\n" + choice + "      ;;\n";
}

std::string zsh_completion() {
  std::string names, branches;
  for (const Command& command : commands()) {
    names += "    " + shell_quoted(std::string(command.name) + ':' + plain(command.summary)) + '\n';
    branches += branch(command);
  }
  return R"(#compdef qerr
# zsh completion of qerr, made by: qerr completion zsh
_qerr() {
  local curcontext=$curcontext state
  local -a line commands
  commands=(
)" + names +
         R"(  )
  _arguments -C '1:command:->command' '*::argument:->argument'
  case $state in
  command) _describe command commands ;;
  argument)
    case $line[1] in
)" + branches +
         R"(    esac
    ;;
  esac
}
if [[ $funcstack[1] == _qerr ]]; then
  _qerr "$@"
else
  compdef _qerr qerr
fi
)";
}

struct Shell {
  std::string_view name;
  std::string (*script)();
};

constexpr Shell shells[] = {{"bash", bash_completion}, {"zsh", zsh_completion}, {"fish", fish_completion}};

std::vector<std::string> shell_names() { return names_of(shells); }

int run_completion(const Values& v) {
  OutputFile out(v.text("output"));
  for (const Shell& shell : shells)
    if (shell.name == v.text("SHELL")) finish(out, shell.script());
  return 0;
}

}  // namespace

Command completion_command() {
  return {"completion",
          "The script that completes qerr's command lines in a shell",
          {valued("SHELL", "", "bash, zsh or fish").one_of(shell_names, "shell").must(),
           text_output_option(".bash .zsh .fish .sh .txt")},
          run_completion,
          {{"source <(qerr completion bash)", "complete in this bash; zsh likewise"},
           {"qerr completion fish | source", "complete in this fish"}}};
}

}  // namespace qerr::cli
