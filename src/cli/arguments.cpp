#include "cli/arguments.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/suggest.hpp"
#include "core/text.hpp"
#include "qerr/core/error.hpp"
#include "qerr/core/quantity.hpp"

namespace qerr::cli {

namespace {

const Option* option_of(const Command& command, const std::string& word) {
  for (const Option& row : command.options)
    if (!row.positional() && (row.long_name() == word || row.short_name() == word)) return &row;
  return nullptr;
}

/// Whether the word can only be an option, so that the value in front of it is missing.
bool is_option(const Command& command, const std::string& word) {
  return word.starts_with("--") || option_of(command, word);
}

std::string written(const Option& row) {
  return row.value.empty() ? row.long_name() : row.long_name() + ' ' + std::string(row.value);
}

/// Collects the texts of every row.
class Parser {
 public:
  explicit Parser(const Command& command) : command_(command) {
    for (const Option& row : command.options) texts_[row.key()];
  }

  Values parse(const std::vector<std::string>& words) {
    for (at_ = words.begin(), end_ = words.end(); at_ != end_;) {
      const std::string word = *at_++;
      if (word == "--") {
        for (; at_ != end_; ++at_) add_argument(*at_);
        break;
      }
      if (word.starts_with("--"))
        long_option(word);
      else if (word.size() > 1 && word[0] == '-')
        short_options(word);
      else
        add_argument(word);
    }
    check_complete();
    Values::Texts fallbacks;
    for (const Option& row : command_.options)
      if (!row.fallback.empty()) fallbacks[row.key()] = {std::string(row.fallback)};
    return Values(std::move(texts_), std::move(fallbacks));
  }

 private:
  void long_option(const std::string& word) {
    const std::size_t equals = word.find('=');
    const std::string name = word.substr(0, equals);
    const Option* row = option_of(command_, name);
    if (!row) refuse_option(name);
    const bool has_value = equals != std::string::npos;
    if (!row->takes_value()) {
      if (has_value) refuse(name, "takes no value", quoted(word.substr(equals + 1)), "leave it out");
      if (!row->stands_for.empty()) return long_option(std::string(row->stands_for));
      texts_[row->key()] = {row->key()};
    } else {
      take_values(*row, has_value ? std::optional(word.substr(equals + 1)) : std::nullopt);
    }
  }

  /// `-q`, `-o FILE`, `-oFILE`, `-qo FILE`.
  void short_options(const std::string& word) {
    for (std::size_t i = 1; i < word.size(); ++i) {
      const std::string name = std::string("-") + word[i];
      const Option* row = option_of(command_, name);
      if (!row) refuse_option(i == 1 ? word : name);
      if (row->takes_value()) {
        const std::string rest = word.substr(i + 1);
        return take_values(*row, rest.empty() ? std::nullopt : std::optional(rest));
      }
      texts_[row->key()] = {row->key()};
    }
  }

  void take_values(const Option& row, std::optional<std::string> first) {
    std::vector<std::string>& texts = texts_[row.key()];
    if (!texts.empty() && !row.repeats())
      refuse(row.long_name(), "can be given once", quoted(texts.front()) + " before",
             "leave out one of the two");
    if (row.kind == OptionKind::optional && !first && (at_ == end_ || !row.is_value(*at_)))
      return add_value(row, std::string(row.implied));
    const std::size_t values = row.kind == OptionKind::pair ? 2 : 1;
    for (std::size_t i = 0; i < values; ++i) {
      if (!first && (at_ == end_ || is_option(command_, *at_)))
        refuse(row.long_name(), i ? "the second value is missing" : "the value is missing",
               at_ == end_ ? "" : quoted(*at_) + " instead", "write " + written(row));
      add_value(row, first ? *first : *at_++);
      first.reset();
    }
  }

  void add_value(const Option& row, const std::string& text) {
    if (row.kind == OptionKind::list && text.find(',') != std::string::npos) {
      const std::size_t comma = text.find(',');
      add_value(row, text.substr(0, comma));
      return add_value(row, text.substr(comma + 1));
    }
    if (row.kind == OptionKind::number || row.kind == OptionKind::whole) check_number(row, text);
    if (row.choices) check_choice(row, text, row.choices());
    if (row.choices_behind) check_choice(row, text, row.choices_behind(last_argument_));
    if (row.positional()) last_argument_ = text;
    texts_[row.key()].push_back(text);
  }

  void add_argument(const std::string& word) {
    for (const Option& row : command_.options)
      if (row.positional() && (texts_[row.key()].empty() || row.repeats())) return add_value(row, word);
    const bool override = word.find('=') != std::string::npos && option_of(command_, "--set");
    refuse("", "one argument too many", quoted(word),
           override ? "did you mean --set " + quoted(word) + "?" : "the usage is " + usage_line(command_));
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
    throw Error({{"qerr " + std::string(command_.name)}, option, rule, found, remedy}, Trouble::usage);
  }

  [[noreturn]] void refuse_option(const std::string& word) const {
    std::vector<std::string> known;
    for (const Option& row : command_.options)
      if (!row.positional()) known.push_back(row.long_name());
    const std::string near = nearest(word, known);
    refuse(word, "unknown option", "",
           near.empty() ? "qerr help " + std::string(command_.name) + " lists the options of this command"
                        : "did you mean '" + near + "'?");
  }

  void check_choice(const Option& row, const std::string& text, const std::vector<std::string>& words) const {
    if (std::find(words.begin(), words.end(), text) == words.end())
      refuse(row.long_name(), "unknown " + std::string(row.choice), quoted(text), did_you_mean(text, words));
  }

  void check_number(const Option& row, const std::string& text) const {
    const auto number = parse_number(text);
    const bool whole = row.kind == OptionKind::whole;
    const bool good = number && *number >= row.least && *number <= row.most;
    if (!good || (whole && *number != std::floor(*number)))
      refuse(row.long_name(),
             std::string("must be a ") + (whole ? "whole " : "") + "number from " + row.range(), quoted(text),
             row.fallback.empty() ? "" : "the default is " + std::string(row.fallback));
  }

  const Command& command_;
  Values::Texts texts_;
  std::string last_argument_;
  std::vector<std::string>::const_iterator at_, end_;
};

}  // namespace

Values parse_arguments(const Command& command, const std::vector<std::string>& words) {
  return Parser(command).parse(words);
}

std::string usage_line(const Command& command) {
  std::string line = "qerr " + std::string(command.name) + " [OPTION...]";
  for (const Option& row : command.options)
    if (row.positional())
      line += (row.required ? " " : " [") + std::string(row.name) + (row.repeats() ? "..." : "") +
              (row.required ? "" : "]");
  return line;
}

}  // namespace qerr::cli
