#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "cli/command.hpp"
#include "qerr/report/write.hpp"

/// Pages of the help: of each command, made from its row, and of topics, written in Markdown
/// (src/cli/topics). A page is printed on a terminal, or is a man page.
namespace qerr::cli {

struct Block {
  enum class Kind {
    heading,    ///< `text`
    paragraph,  ///< `text` on one line, with `code` and **strong** parts
    verbatim,   ///< `text` with its line breaks
    item,       ///< `text` of a list
    term,       ///< `term`, and `text`, which explains it
    table       ///< `rows`, the first one the header
  };
  Kind kind;
  std::string text = {};
  std::string term = {};
  std::vector<std::vector<std::string>> rows = {};
};

struct Page {
  std::string name;  ///< `analyze`, `encoders`; "" of the overview
  std::string summary;
  std::vector<Block> blocks;
};

Page overview_page();
Page command_page(const Command&);

/// The topics, sorted by name. To add one: a file in src/cli/topics.
const std::vector<Page>& topics();

/// Every file of src/cli/topics, embedded by the build.
const std::vector<std::string_view>& topic_texts();

/// The page of a command, or of a topic; the overview for "".
/// @pre the name is one of page_names(), or ""
Page page_of(std::string_view name);
std::vector<std::string> page_names();

/// The subset of Markdown of the topics: a first line `# NAME: SUMMARY`, `##` headings, paragraphs, fenced
/// blocks, lists with `- `, tables; `<!-- list KIND -->` stands for the rows of `qerr list KIND`.
Page parse_markdown(std::string_view text);

std::string to_terminal(const Page&, const Style&);

/// A man page (roff).
std::string to_man(const Page&);
/// `1` of commands, `7` of topics.
std::string man_section(const Page&);
/// `qerr-analyze.1`, `qerr-encoders.7`, `qerr.1`.
std::string man_file(const Page&);

}  // namespace qerr::cli
