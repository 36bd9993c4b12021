#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "cli/shared.hpp"
#include "core/lists.hpp"
#include "core/parallel.hpp"
#include "core/run_files.hpp"
#include "core/text.hpp"
#include "qerr/core/quantity.hpp"
#include "report/text_table.hpp"

namespace qerr::cli {

namespace {

using Words = std::vector<std::string>;

const Option* option_of(const std::vector<Option>& rows, const std::string& word) {
  for (const Option& row : rows)
    if (!row.positional() && !word.empty() && (row.long_name() == word || row.short_name() == word))
      return &row;
  return nullptr;
}

/// What CLI11 makes of a command line.
struct SortedWords {
  Values::Texts texts;                 ///< of each option, by its key; of one without a value "true"
  Words others;                        ///< arguments, `--`, and options that no row has
  const Option* incomplete = nullptr;  ///< the option whose values the command line ends before
};

/// Written as with GNU programs: `--runs 3`, `--runs=3`, `-o FILE`, `-oFILE`, `-qo FILE`; `--` ends the
/// options.
/// @param whole  whether options behind the first argument count, too
SortedWords sort_words(const std::vector<Option>& rows, const Words& words, bool whole = true) {
  CLI::App app;
  app.set_help_flag();
  app.allow_extras();
  app.prefix_command(!whole);
  for (const Option& row : rows) {
    if (row.positional()) continue;
    const std::string name(row.name);
    CLI::Option* option = row.needs_value() ? app.add_option(name) : app.add_flag(name);
    if (row.kind == OptionKind::pair) option->type_size(2);
    option->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  }
  SortedWords sorted;
  try {
    app.parse(Words(words.rbegin(), words.rend()));
  } catch (const CLI::ArgumentMismatch& e) {  // begins with the name of the option
    const std::string text = e.what();
    sorted.incomplete = option_of(rows, text.substr(0, text.find(':')));
  }
  for (const Option& row : rows)
    sorted.texts[row.key()] = row.positional() ? Words() : app.get_option(row.long_name())->results();
  sorted.others = app.remaining();
  return sorted;
}

/// Checks the sorted words by the rows of a command.
class Parser {
 public:
  Parser(const Command& command, const Words& words) : command_(command), words_(words) {}

  Values parse() {
    const SortedWords sorted = sort_words(command_.options, with_optional_values());
    const auto mark = std::ranges::find(sorted.others, "--");
    for (auto at = sorted.others.begin(); at != mark; ++at)
      if (at->size() > 1 && at->starts_with('-')) refuse_option(*at);
    for (const Option& row : command_.options) add_values(row, sorted.texts.at(row.key()));
    if (const Option* row = sorted.incomplete) refuse_missing(*row, texts_[row->key()].size(), "");
    for (auto at = sorted.others.begin(); at != sorted.others.end(); ++at)
      if (at != mark) add_argument(*at);
    check_complete();
    Values::Texts fallbacks;
    for (const Option& row : command_.options)
      if (!row.fallback.empty()) fallbacks[row.key()] = {std::string(row.fallback)};
    return Values(std::move(texts_), std::move(fallbacks));
  }

 private:
  /// The words as CLI11 shall read them: `--prove=1%` for `--prove 1%`, as it cannot tell a value from an
  /// argument. It would read `--seed=` as `--seed`, and `--quiet=true` as `--quiet`.
  Words with_optional_values() const {
    Words joined;
    const auto mark = std::ranges::find(words_, "--");
    for (auto at = words_.begin(); at != mark; ++at) {
      const Option* before = joined.empty() ? nullptr : option_of(command_.options, joined.back());
      if (before && before->kind == OptionKind::optional && before->is_value(*at)) {
        joined.back() += '=' + *at;
        continue;
      }
      const std::size_t equals = at->find('=');
      const Option* row =
          equals == std::string::npos ? nullptr : option_of(command_.options, at->substr(0, equals));
      if (row && !row->takes_value())
        refuse(row->long_name(), "takes no value", qerr::quoted(at->substr(equals + 1)), "leave it out");
      if (row && equals + 1 == at->size()) refuse_missing(*row, 0, "");
      const Option* flag = option_of(command_.options, *at);
      joined.push_back(flag && !flag->stands_for.empty() ? std::string(flag->stands_for) : *at);
    }
    joined.insert(joined.end(), mark, words_.end());
    return joined;
  }

  void add_values(const Option& row, const Words& values) {
    const std::size_t once = row.kind == OptionKind::pair ? 2 : 1;
    texts_[row.key()];
    for (std::size_t i = 0; i < values.size(); ++i) {
      const std::string& text = values[i];
      if (i == once && row.takes_value() && !row.repeats())
        refuse(row.long_name(), "can be given once", qerr::quoted(texts_[row.key()].front()) + " before",
               "leave out one of the two");
      const bool no_value = text.empty() || text.starts_with("--") || option_of(command_.options, text);
      if (no_value && contains(words_, text)) refuse_missing(row, i % once, qerr::quoted(text) + " instead");
      if (!row.needs_value() && text == "true")  // CLI11's word for no value
        texts_[row.key()].emplace_back(row.takes_value() ? row.implied : row.name);
      else
        add_value(row, text);
    }
  }

  void add_value(const Option& row, const std::string& text) {
    if (row.kind == OptionKind::list && text.find(',') != std::string::npos) {
      const std::size_t comma = text.find(',');
      add_value(row, text.substr(0, comma));
      return add_value(row, text.substr(comma + 1));
    }
    if (row.kind == OptionKind::number || row.kind == OptionKind::whole) check_number(row, text);
    if (row.choices && !row.open) check_choice(row, text, row.choices());
    if (row.choices_behind) check_choice(row, text, row.choices_behind(last_argument_));
    if (row.positional()) last_argument_ = text;
    texts_[row.key()].push_back(text);
  }

  void add_argument(const std::string& word) {
    for (const Option& row : command_.options)
      if (row.positional() && (texts_[row.key()].empty() || row.repeats())) return add_value(row, word);
    const bool override = word.find('=') != std::string::npos && option_of(command_.options, "--set");
    refuse(
        "", "one argument too many", qerr::quoted(word),
        override ? "did you mean --set " + qerr::quoted(word) + "?" : "the usage is " + usage_line(command_));
  }

  void check_complete() {
    for (const Option& row : command_.options) {
      if (row.required && texts_[row.key()].empty())
        refuse("", std::string(row.name) + " is missing: " + std::string(row.meaning), "",
               "e.g. " +
                   std::string(command_.examples.empty() ? usage_line(command_) : command_.examples[0].line));
      if (!row.needs.empty() && !texts_[row.key()].empty() &&
          texts_[std::string(row.needs.substr(2))].empty())
        refuse(row.long_name(), "needs " + std::string(row.needs), "", "add " + std::string(row.needs));
    }
  }

  [[noreturn]] void refuse(const std::string& option, const std::string& rule, const std::string& found,
                           const std::string& remedy) const {
    throw Error({"qerr " + std::string(command_.name)}, option, rule, found, remedy, Trouble::usage);
  }

  /// @param count  of the values that are there
  [[noreturn]] void refuse_missing(const Option& row, std::size_t count, const std::string& found) const {
    refuse(row.long_name(), count ? "the second value is missing" : "the value is missing", found,
           "write " + row.long_name() + ' ' + std::string(row.value));
  }

  [[noreturn]] void refuse_option(std::string word) const {
    if (word.starts_with("--")) word = word.substr(0, word.find('='));
    std::vector<std::string> known;
    for (const Option& row : command_.options)
      if (!row.positional()) known.push_back(row.long_name());
    const std::string near = nearest(word, known);
    refuse(word, "unknown option", "",
           near.empty() ? "qerr help " + std::string(command_.name) + " lists the options of this command"
                        : "did you mean '" + near + "'?");
  }

  void check_choice(const Option& row, const std::string& text, const std::vector<std::string>& words) const {
    if (!contains(words, text))
      refuse(row.long_name(), "unknown " + std::string(row.choice), qerr::quoted(text),
             did_you_mean(text, words));
  }

  void check_number(const Option& row, const std::string& text) const {
    const auto number = parse_number(text);
    const bool whole = row.kind == OptionKind::whole;
    const bool good = number && *number >= row.least && *number <= row.most;
    if (!good || (whole && *number != std::floor(*number)))
      refuse(row.long_name(),
             std::string("must be a ") + (whole ? "whole " : "") + "number from " + row.range(),
             qerr::quoted(text), row.fallback.empty() ? "" : "the default is " + std::string(row.fallback));
  }

  const Command& command_;
  const Words& words_;
  Values::Texts texts_;
  std::string last_argument_;
};

/// The number of words in front of the command's name: the global options.
std::size_t leading_words(const Words& words) {
  const SortedWords sorted = sort_words(global_options(), words, false);
  if (!sorted.others.empty() && sorted.others.front().starts_with('-'))
    throw usage(sorted.others.front(), "options stand behind a command", "",
                "e.g. qerr analyze SPEC " + sorted.others.front());
  return words.size() - sorted.others.size();
}

[[noreturn]] void refuse_command(const std::string& word) {
  const std::string near = nearest(word, command_names());
  std::string remedy = near.empty() ? "qerr help lists the commands" : "did you mean 'qerr " + near + "'?";
  if (word.ends_with(".yaml") || word.ends_with(".yml"))
    remedy = "a spec stands behind a command: qerr analyze " + word;
  throw usage("", "unknown command", qerr::quoted(word), remedy);
}

bool asks_for(const Words& words, std::string_view long_name, std::string_view short_name) {
  return std::any_of(words.begin(), std::ranges::find(words, "--"),
                     [&](const std::string& word) { return word == long_name || word == short_name; });
}

/// `--help` is the command `help` about this page, with the colours asked for.
int show_help(const std::string& page, const Words& words) {
  const SortedWords sorted = sort_words(global_options(), words);
  Words about;
  if (!page.empty()) about.push_back(page);
  for (const std::string& when : sorted.texts.at("color")) about.insert(about.end(), {"--color", when});
  if (!sorted.texts.at("no-color").empty()) about.emplace_back("--no-color");
  const Command& help = *command_of("help");
  return help.run(Parser(help, about).parse());
}

int show_version() {
  OutputFile out("-");
  finish(out, "qerr " + std::string(version()) + '\n');
  return 0;
}

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

int run_command_line(const Words& words) {
  const auto place = words.begin() + static_cast<std::ptrdiff_t>(leading_words(words));
  Words rest(words.begin(), place);
  if (place != words.end()) rest.insert(rest.end(), place + 1, words.end());
  if (asks_for(rest, "--version", "-V")) return show_version();
  const bool help = asks_for(rest, "--help", "-h");
  if (place == words.end()) {
    if (help) return show_help("", rest);
    throw usage("", "a command is missing", "", "e.g. qerr analyze arm.yaml; qerr help lists the commands");
  }
  const Command* command = command_of(*place);
  if (!command) refuse_command(*place);
  if (help) return show_help(*place, rest);
  const Values values = Parser(*command, rest).parse();
  require_known_ending(command->options, values);
  if (values.given("force")) permit_replacing_specs();
  const int code = command->run(values);
  if (threads_refused())
    warn({"the system permits fewer threads than asked for: slower, with the same result"}, values);
  return code;
}

const std::vector<Option>& global_options() {
  static const std::vector<Option> rows{
      flag("-q,--quiet", "no warnings, no progress"),
      valued("--color", "WHEN", "always, never, or auto: on a terminal, unless NO_COLOR is set")
          .otherwise("auto")
          .one_of(when_words, "choice"),
      flag("--no-color", "the same as --color never"),
      valued("--progress", "WHEN", "always, never, or auto: on a terminal, unless --quiet")
          .otherwise("auto")
          .one_of(when_words, "choice"),
      flag("--force", "let an output replace a spec, URDF or catalogue, which a person may have edited"),
      flag("-h,--help", "this help"),
      flag("-V,--version", "the version of qerr")};
  return rows;
}

const std::vector<Command>& commands() {
  static const std::vector<Command> rows = table();
  return rows;
}

const Command* command_of(std::string_view name) { return find_named(commands(), name); }

std::vector<std::string> command_names() { return names_of(commands()); }

std::string usage_line(const Command& command) {
  std::string line = "qerr " + std::string(command.name) + " [OPTION...]";
  for (const Option& row : command.options)
    if (row.positional())
      line += (row.required ? " " : " [") + std::string(row.name) + (row.repeats() ? "..." : "") +
              (row.required ? "" : "]");
  return line;
}

std::string Option::long_name() const { return std::string(name.substr(name.rfind(',') + 1)); }

std::string Option::short_name() const {
  const std::size_t comma = name.find(',');
  return comma == std::string_view::npos ? "" : std::string(name.substr(0, comma));
}

std::string Option::key() const { return long_name().substr(positional() ? 0 : 2); }

std::string Option::range() const {
  if (kind != OptionKind::number && kind != OptionKind::whole) return "";
  return significant(least, 9) + " to " + (most == 0x1p53 - 1 ? "2^53 - 1" : significant(most, 9));
}

Values::Values(Texts given, Texts fallbacks) : given_(std::move(given)), fallbacks_(std::move(fallbacks)) {}

bool Values::given(std::string_view name) const { return !texts(name).empty(); }

const std::string& Values::text(std::string_view name) const {
  static const std::string none;
  if (given(name)) return texts(name).front();
  const auto fallback = fallbacks_.find(name);
  return fallback == fallbacks_.end() ? none : fallback->second.front();
}

const std::vector<std::string>& Values::texts(std::string_view name) const {
  const auto found = given_.find(name);
  if (found == given_.end()) throw std::logic_error("the command has no option '" + std::string(name) + "'");
  return found->second;
}

double Values::number(std::string_view name) const { return parse_number(text(name)).value(); }

std::uint64_t Values::whole(std::string_view name) const { return static_cast<std::uint64_t>(number(name)); }

}  // namespace qerr::cli
