#include <algorithm>

#include "cli/arguments.hpp"
#include "cli/command.hpp"
#include "cli/shared.hpp"
#include "core/parallel.hpp"
#include "core/run_files.hpp"
#include "core/suggest.hpp"
#include "core/text.hpp"

namespace qerr::cli {

namespace {

using Words = std::vector<std::string>;

const Option* global_option(const std::string& word) {
  for (const Option& row : global_options())
    if (word == row.short_name() || word.substr(0, word.find('=')) == row.long_name()) return &row;
  return nullptr;
}

/// The place of the command's name: behind the global options.
Words::const_iterator command_place(const Words& words) {
  auto at = words.begin();
  while (at != words.end() && at->starts_with('-')) {
    const Option* row = global_option(*at);
    if (!row) throw usage(*at, "options stand behind a command", "", "e.g. qerr analyze SPEC " + *at);
    const bool value_follows = row->needs_value() && at->find('=') == std::string::npos;
    at += value_follows && at + 1 != words.end() ? 2 : 1;
  }
  return at;
}

bool has_flag(const Words& words, const char* key) {
  const auto end = std::find(words.begin(), words.end(), "--");
  return std::any_of(words.begin(), end, [&](const std::string& word) {
    const Option* row = global_option(word);
    return row && !row->takes_value() && row->key() == key;
  });
}

[[noreturn]] void refuse_command(const std::string& word) {
  const std::string near = nearest(word, command_names());
  std::string remedy = near.empty() ? "qerr help lists the commands" : "did you mean 'qerr " + near + "'?";
  if (word.ends_with(".yaml") || word.ends_with(".yml"))
    remedy = "a spec stands behind a command: qerr analyze " + word;
  throw usage("", "unknown command", quoted(word), remedy);
}

/// `--help` is the command `help` about this page, with the colours asked for.
int show_help(const std::string& page, const Words& words) {
  Words about;
  if (!page.empty()) about.push_back(page);
  for (auto at = words.begin(); at != words.end(); ++at) {
    const bool color = at->starts_with("--color");
    if (color || *at == "--no-color") about.push_back(*at);
    if (color && at->find('=') == std::string::npos && at + 1 != words.end()) about.push_back(*++at);
  }
  const Command& help = *command_of("help");
  return help.run(parse_arguments(help, about));
}

int show_version() {
  OutputFile out("-");
  finish(out, "qerr " + std::string(version()) + '\n');
  return 0;
}

}  // namespace

int run_command_line(const Words& words) {
  const auto place = command_place(words);
  Words rest(words.begin(), place);
  if (place != words.end()) rest.insert(rest.end(), place + 1, words.end());
  if (has_flag(rest, "version")) return show_version();
  const bool help = has_flag(rest, "help");
  if (place == words.end()) {
    if (help) return show_help("", rest);
    throw usage("", "a command is missing", "", "e.g. qerr analyze arm.yaml; qerr help lists the commands");
  }
  const Command* command = command_of(*place);
  if (!command) refuse_command(*place);
  if (help) return show_help(*place, rest);
  const Values values = parse_arguments(*command, rest);
  require_known_ending(command->options, values);
  if (values.given("force")) permit_replacing_specs();
  const int code = command->run(values);
  if (threads_refused())
    warn({"the system permits fewer threads than asked for: slower, with the same result"}, values);
  return code;
}

}  // namespace qerr::cli
