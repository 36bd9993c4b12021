/// The only file that includes CLI11: it declares the rows of the commands, and collects what was given.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <optional>

#include "cli/command.hpp"
#include "core/suggest.hpp"
#include "core/text.hpp"
#include "qerr/core/error.hpp"
#include "qerr/core/quantity.hpp"
#include "qerr/report/write.hpp"

namespace qerr::cli {

namespace {

using Texts = Values::Texts;

/// `output` of `-o,--output`, `SPEC` of `SPEC`.
std::string key_of(const Option& row) {
  const std::string_view longest = row.name.substr(row.name.rfind(',') + 1);
  return std::string(longest.substr(longest.starts_with("--") ? 2 : 0));
}

/// What is wrong with a word that is not among the choices; "" if it is.
std::string fault_of_choice(const Option& row, const std::string& text) {
  const std::vector<std::string> words = row.choices();
  if (std::find(words.begin(), words.end(), text) != words.end()) return "";
  return "unknown " + std::string(row.choice) + " '" + text + "'; " + did_you_mean(text, words);
}

std::string text_of(double end) { return end == 0x1p53 ? "2^53" : significant(end, 9); }

std::string range_of(const Option& row) { return text_of(row.least) + " to " + text_of(row.most); }

bool has_range(const Option& row) { return row.kind == OptionKind::number || row.kind == OptionKind::whole; }

/// The meaning, with the range and the fallback of the row.
std::string described(const Option& row) {
  std::string more = has_range(row) ? range_of(row) : "";
  if (!row.fallback.empty()) more += (more.empty() ? "default " : "; default ") + std::string(row.fallback);
  return std::string(row.meaning) + (more.empty() ? "" : " (" + more + ')');
}

std::string fault_of_number(const Option& row, const std::string& text) {
  const auto number = parse_number(text);
  const bool whole = row.kind == OptionKind::whole;
  if (number && *number >= row.least && *number <= row.most && (!whole || *number == std::floor(*number)))
    return "";
  return "'" + text + "' is not a " + (whole ? "whole " : "") + "number from " + range_of(row);
}

void add_value_option(CLI::App& app, const Option& row, std::vector<std::string>& texts) {
  CLI::Option* option = app.add_option(std::string(row.name), texts, described(row));
  if (!row.value.empty()) option->type_name(std::string(row.value));
  if (row.required) option->required();
  const bool positional = !row.name.starts_with('-');
  switch (row.kind) {
    case OptionKind::list:
      option->delimiter(',');
      [[fallthrough]];
    case OptionKind::repeat:
      option->take_all();
      if (!positional) option->allow_extra_args(false);
      break;
    case OptionKind::pair:
      option->expected(2);
      break;
    case OptionKind::number:
    case OptionKind::whole:
      option->check([&row](const std::string& text) { return fault_of_number(row, text); });
      [[fallthrough]];
    default:
      option->expected(1)->allow_extra_args(false);
  }
  if (row.choices) option->check([&row](const std::string& text) { return fault_of_choice(row, text); });
}

void add_options(CLI::App& app, const std::vector<Option>& rows, Texts& texts,
                 std::map<std::string, bool>& flags) {
  for (const Option& row : rows)
    if (row.kind == OptionKind::flag)
      app.add_flag(std::string(row.name), flags[key_of(row)], std::string(row.meaning));
    else
      add_value_option(app, row, texts[key_of(row)]);
  for (const Option& row : rows)
    if (!row.needs.empty()) app.get_option("--" + key_of(row))->needs(app.get_option(std::string(row.needs)));
}

/// A flag that is set has its own name as text.
Values values_of(const std::vector<Option>& rows, Texts texts, const std::map<std::string, bool>& flags) {
  for (const auto& [name, set] : flags) texts[name] = set ? std::vector{name} : std::vector<std::string>{};
  Texts fallbacks;
  for (const Option& row : rows)
    if (!row.fallback.empty()) fallbacks[key_of(row)] = {std::string(row.fallback)};
  return Values(std::move(texts), std::move(fallbacks));
}

std::vector<std::string> command_names() {
  std::vector<std::string> names;
  for (const Command& c : commands()) names.emplace_back(c.name);
  return names;
}

/// A message about the first option that the command does not have; "" if it has all.
std::string fault_of_options(const Command& command, int argc, char** argv) {
  std::vector<std::string> known{"--help"};
  for (const Option& row : command.options)
    if (row.name.starts_with('-')) known.push_back("--" + key_of(row));
  for (int i = 2; i < argc; ++i) {
    const std::string word = std::string(argv[i]).substr(0, std::string(argv[i]).find('='));
    if (word == "--") break;
    if (word.starts_with("--") && std::find(known.begin(), known.end(), word) == known.end())
      return "unknown option, found '" + word + "'; " + did_you_mean(word, known);
  }
  return {};
}

const Command* command_of(std::string_view name) {
  for (const Command& c : commands())
    if (c.name == name) return &c;
  return nullptr;
}

[[noreturn]] void refuse(const std::string& rule, const std::string& found, const std::string& remedy) {
  throw Error({{}, "", rule, found, remedy}, Trouble::usage);
}

}  // namespace

int run_command_line(int argc, char** argv) {
  const std::string word = argc > 1 ? argv[1] : "";
  const Command* named = command_of(word);
  // CLI11 answers a misspelt command with "A subcommand is required".
  if (!named && !word.empty() && word[0] != '-')
    refuse("unknown command", "'" + word + "'", did_you_mean(word, command_names()));

  CLI::App app{
      "qerr: bounds of the errors that a robot's encoders cause at its tip, and in filtered velocity and "
      "acceleration"};
  app.set_version_flag("--version", "qerr " + std::string(version()));
  app.require_subcommand(1);
  app.get_formatter()->column_width(28);
  Texts texts;
  std::map<std::string, bool> flags;
  for (const Command& command : commands()) {
    CLI::App* sub = app.add_subcommand(std::string(command.name), std::string(command.summary));
    if (&command == named) add_options(*sub, command.options, texts, flags);
  }
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    if (e.get_exit_code() == static_cast<int>(CLI::ExitCodes::Success)) return app.exit(e);
    const std::string help = "see qerr " + (named ? word + " " : "") + "--help";
    const std::string unknown = named ? fault_of_options(*named, argc, argv) : "";
    refuse(!unknown.empty() ? unknown : argc == 1 ? "a command is missing" : e.what(), "", help);
  }
  if (!named) refuse("a command is missing", "", "see qerr --help");
  return named->run(values_of(named->options, std::move(texts), flags));
}

}  // namespace qerr::cli
