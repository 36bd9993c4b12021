#include <algorithm>
#include <filesystem>
#include <stdexcept>

#include "cli/command.hpp"
#include "cli/help/page.hpp"
#include "cli/shared.hpp"
#include "core/suggest.hpp"
#include "core/text.hpp"
#include "report/text_table.hpp"

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

bool is_global(const Option& row) { return find_named(global_options(), row.name) != nullptr; }

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
  append(names, names_of(topics()));
  return names;
}

Page page_of(std::string_view name) {
  if (name.empty()) return overview_page();
  if (const Command* command = command_of(name)) return command_page(*command);
  for (const Page& topic : topics())
    if (topic.name == name) return topic;
  throw std::logic_error("no page of the help has the name '" + std::string(name) + "'");
}

namespace {

/// Every page in a file of its own.
/// @param option  that names the folder, for messages
/// @param place   of a page, relative to the folder
void write_pages(const Values& v, const std::string& option, std::string (*place)(const Page&),
                 std::string (*text)(const Page&)) {
  const std::filesystem::path folder = v.text(option);
  std::vector<std::string> names = page_names();
  names.emplace_back("");
  for (const std::string& name : names) {
    const Page page = page_of(name);
    const std::filesystem::path path = folder / place(page);
    std::error_code failure;
    std::filesystem::create_directories(path.parent_path(), failure);
    if (failure)
      throw Error({path.parent_path().string()}, "--" + option,
                  "the folder cannot be created: " + failure.message(), "", "name another one",
                  Trouble::file_system);
    OutputFile file(path.string());
    finish(file, text(page));
  }
}

/// As man(1) looks for them: man1 and man7.
std::string man_place(const Page& page) { return "man" + man_section(page) + '/' + man_file(page); }

std::string html_place(const Page& page) { return html_file(page.name); }

/// A page by its name; else where the words stand.
Page asked_page(const std::vector<std::string>& words) {
  const std::vector<std::string> names = page_names();
  if (words.empty()) return page_of("");
  if (words.size() == 1 && contains(names, words[0])) return page_of(words[0]);
  if (std::optional<Page> found = search_pages(words)) return *found;
  const std::string asked = qerr::joined(words, " "), near = nearest(asked, names);
  const std::string remedy =
      near.empty() ? "commands and topics: " + qerr::joined(names) : "did you mean '" + near + "'?";
  throw Error({"qerr help"}, "", "no page has this word", qerr::quoted(asked), remedy, Trouble::usage);
}

int run_help(const Values& v) {
  if (v.given("man")) write_pages(v, "man", man_place, to_man);
  if (v.given("html")) write_pages(v, "html", html_place, to_html);
  if (v.given("man") || v.given("html")) return 0;
  OutputFile out("-");
  finish(out, to_terminal(asked_page(v.texts("WORD")), terminal_style(v)));
  return 0;
}

}  // namespace

Command help_command() {
  return {"help",
          "The commands and topics, one of them, or the pages that have a word",
          {{.name = "WORD",
            .kind = OptionKind::repeat,
            .meaning = "a command, a topic, or words to search for",
            .choices = page_names,
            .open = true,
            .choice = "command or topic"},
           valued("--man", "FOLDER", "write all pages as man pages there; man -M FOLDER shows them"),
           valued("--html", "FOLDER", "write all pages there as a static site: index.html")},
          run_help,
          {{"qerr help", "the commands and the topics"},
           {"qerr help encoders", "how to specify an encoder, with the words of its data sheet"},
           {"qerr help figures", "what the figures of a report mean, and on what they depend"},
           {"qerr help TCP", "every page that has the word"},
           {"qerr help --html site", "all pages as a static site"}}};
}

}  // namespace qerr::cli
