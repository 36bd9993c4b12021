#include "cli/completion/scripts.hpp"

namespace qerr::cli {

namespace {

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

}  // namespace

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

}  // namespace qerr::cli
