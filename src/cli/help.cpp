#include <filesystem>

#include "cli/command.hpp"
#include "cli/help/page.hpp"
#include "cli/shared.hpp"

namespace qerr::cli {

namespace {

/// As man(1) looks for them: FOLDER/man1 and FOLDER/man7.
void write_man_pages(const std::string& folder) {
  std::vector<std::string> names = page_names();
  names.emplace_back("");
  for (const std::string& name : names) {
    const Page page = page_of(name);
    const std::string section = folder + "/man" + man_section(page);
    std::error_code failure;
    std::filesystem::create_directories(section, failure);
    if (failure)
      throw Error(
          {{section}, "--man", "the folder cannot be created: " + failure.message(), "", "name another one"},
          Trouble::file_system);
    OutputFile file(section + '/' + man_file(page));
    finish(file, to_man(page));
  }
}

int run(const Values& v) {
  if (v.given("man")) {
    write_man_pages(v.text("man"));
    return 0;
  }
  OutputFile out("-");
  finish(out, to_terminal(page_of(v.text("PAGE")), terminal_style(v)));
  return 0;
}

}  // namespace

Command help_command() {
  return {"help",
          "The commands and topics, or one of them",
          {{.name = "PAGE",
            .meaning = "a command or a topic",
            .choices = page_names,
            .choice = "command or topic"},
           {.name = "--man",
            .value = "FOLDER",
            .meaning = "write all pages as man pages there; man -M FOLDER shows them"}},
          run,
          {{"qerr help", "the commands and the topics"},
           {"qerr help encoders", "how to specify an encoder, with the words of its data sheet"},
           {"qerr help figures", "what the figures of a report mean, and on what they depend"}}};
}

}  // namespace qerr::cli
