#include <algorithm>
#include <stdexcept>

#include "cli/command.hpp"
#include "cli/help/page.hpp"

namespace qerr::cli {

namespace {

Block heading(std::string text) { return {.kind = Block::Kind::heading, .text = std::move(text)}; }
Block verbatim(std::string text) { return {.kind = Block::Kind::verbatim, .text = std::move(text)}; }
Block term(std::string term, std::string text) {
  return {.kind = Block::Kind::term, .text = std::move(text), .term = std::move(term)};
}

/// The meaning, with the range and the fallback of the row.
std::string described(const Option& row) {
  std::string more = row.range();
  if (!row.fallback.empty()) more += (more.empty() ? "default " : "; default ") + std::string(row.fallback);
  return std::string(row.meaning) + (more.empty() ? "" : " (" + more + ')');
}

std::string written(const Option& row) {
  const std::string names = row.short_name().empty() ? "" : row.short_name() + ", ";
  return names + row.long_name() + (row.value.empty() ? "" : ' ' + std::string(row.value));
}

bool is_global(const Option& row) {
  return std::any_of(global_options().begin(), global_options().end(),
                     [&](const Option& global) { return global.name == row.name; });
}

template <class Choice>
void add_options(Page& page, const std::string& title, const std::vector<Option>& rows, Choice choice) {
  if (std::none_of(rows.begin(), rows.end(), choice)) return;
  page.blocks.push_back(heading(title));
  for (const Option& row : rows)
    if (choice(row))
      page.blocks.push_back(term(row.positional() ? row.long_name() : written(row), described(row)));
}

void add_examples(Page& page, const std::vector<Example>& examples) {
  if (examples.empty()) return;
  page.blocks.push_back(heading("Examples"));
  std::string text;
  for (const Example& example : examples)
    text += (text.empty() ? "# " : "\n# ") + std::string(example.answer) + '\n' + std::string(example.line) +
            '\n';
  page.blocks.push_back(verbatim(text));
}

}  // namespace

Page command_page(const Command& command) {
  Page page{std::string(command.name), std::string(command.summary), {heading("Usage")}};
  page.blocks.push_back(verbatim(usage_line(command) + '\n'));
  add_options(page, "Arguments", command.options, [](const Option& row) { return row.positional(); });
  add_options(page, "Options", command.options,
              [](const Option& row) { return !row.positional() && !is_global(row); });
  add_options(page, "Common options", global_options(), [](const Option&) { return true; });
  add_examples(page, command.examples);
  if (!command.topics.empty()) {
    page.blocks.push_back(heading("See also"));
    std::string text;
    for (const std::string& topic : command.topics)
      text += (text.empty() ? "`qerr help " : ", `qerr help ") + topic + '`';
    page.blocks.push_back({.kind = Block::Kind::paragraph, .text = text});
  }
  return page;
}

Page overview_page() {
  Page page{"",
            "bounds of the errors that a robot's encoders cause at its tip, and in filtered velocity and "
            "acceleration",
            {heading("Usage")}};
  page.blocks.push_back(
      verbatim("qerr COMMAND [OPTION...] [ARGUMENT...]\nqerr help [COMMAND|TOPIC|WORD...]\n"));
  page.blocks.push_back(heading("Commands"));
  for (const Command& command : commands())
    page.blocks.push_back(term(std::string(command.name), std::string(command.summary)));
  page.blocks.push_back(heading("Topics"));
  for (const Page& topic : topics()) page.blocks.push_back(term(topic.name, topic.summary));
  add_options(page, "Common options", global_options(), [](const Option&) { return true; });
  add_examples(page, command_of("help")->examples);
  return page;
}

const std::vector<Page>& topics() {
  static const std::vector<Page> pages = [] {
    std::vector<Page> all;
    for (const std::string_view text : topic_texts()) all.push_back(parse_markdown(text));
    std::sort(all.begin(), all.end(), [](const Page& a, const Page& b) { return a.name < b.name; });
    return all;
  }();
  return pages;
}

std::vector<std::string> page_names() {
  std::vector<std::string> names = command_names();
  for (const Page& topic : topics()) names.push_back(topic.name);
  return names;
}

Page page_of(std::string_view name) {
  if (name.empty()) return overview_page();
  if (const Command* command = command_of(name)) return command_page(*command);
  for (const Page& topic : topics())
    if (topic.name == name) return topic;
  throw std::logic_error("no page of the help has the name '" + std::string(name) + "'");
}

}  // namespace qerr::cli
