#include <algorithm>
#include <filesystem>

#include "cli/command.hpp"
#include "cli/help/page.hpp"
#include "cli/shared.hpp"
#include "core/suggest.hpp"
#include "core/text.hpp"

namespace qerr::cli {

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
      throw Error({{path.parent_path().string()},
                   "--" + option,
                   "the folder cannot be created: " + failure.message(),
                   "",
                   "name another one"},
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
  if (words.size() == 1 && std::find(names.begin(), names.end(), words[0]) != names.end())
    return page_of(words[0]);
  if (std::optional<Page> found = search_pages(words)) return *found;
  std::string asked, all;
  for (const std::string& word : words) asked += (asked.empty() ? "" : " ") + word;
  for (const std::string& name : names) all += (all.empty() ? "" : ", ") + name;
  const std::string near = nearest(asked, names);
  const std::string remedy = near.empty() ? "commands and topics: " + all : "did you mean '" + near + "'?";
  throw Error(Fault{{"qerr help"}, "", "no page has this word", qerr::quoted(asked), remedy}, Trouble::usage);
}

int run(const Values& v) {
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
           {.name = "--man",
            .value = "FOLDER",
            .meaning = "write all pages as man pages there; man -M FOLDER shows them"},
           {.name = "--html",
            .value = "FOLDER",
            .meaning = "write all pages there as a static site: index.html"}},
          run,
          {{"qerr help", "the commands and the topics"},
           {"qerr help encoders", "how to specify an encoder, with the words of its data sheet"},
           {"qerr help figures", "what the figures of a report mean, and on what they depend"},
           {"qerr help TCP", "every page that has the word"},
           {"qerr help --html site", "all pages as a static site"}}};
}

}  // namespace qerr::cli
