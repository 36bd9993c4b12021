#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "cli/shared.hpp"
#include "qerr/report/write.hpp"

/// Pages of the help: of each command, made from its row, and of topics, written in Markdown
/// (src/cli/topics). A page is printed on a terminal, or is a man page or one of a static site.
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

/// The topics, sorted by name. To add one: a file in src/cli/topics.
const std::vector<Page>& topics();

/// Every file of src/cli/topics, embedded by the build.
const std::vector<std::string_view>& topic_texts();

/// The page of a command, or of a topic; the overview for "".
/// @pre the name is one of page_names(), or ""
Page page_of(std::string_view name);
std::vector<std::string> page_names();

/// Where words stand in the help: the pages that have a block with all of them. Those that have them in their
/// name stand first, then in their summary, then by the number of such blocks of prose; topics before
/// commands. A word fits the beginning of a word, not case-sensitive: `encoder` fits `encoders`, `ros` does
/// not fit `across`.
/// @returns empty if no page has them
std::optional<Page> search_pages(const std::vector<std::string>& words);

/// A piece of a block's text: `code`, **strong**, or neither.
struct Part {
  std::string text;
  bool code = false, strong = false;
};
std::vector<Part> parts_of(const std::string& text);

/// The subset of Markdown of the topics: a first line `# NAME: SUMMARY`, `##` headings, paragraphs, fenced
/// blocks, lists with `- `, tables; `<!-- list KIND -->` stands for the rows of `qerr list KIND`.
Page parse_markdown(std::string_view text);

std::string to_terminal(const Page&, const Style&);

/// A page of the site: HTML without scripts of its own, whose links are relative.
std::string to_html(const Page&);
/// `analyze.html`; `index.html` of the overview.
std::string html_file(std::string_view page);

/// A man page (roff).
std::string to_man(const Page&);
/// `1` of commands, `7` of topics.
std::string man_section(const Page&);
/// `qerr-analyze.1`, `qerr-encoders.7`, `qerr.1`.
std::string man_file(const Page&);

}  // namespace qerr::cli
