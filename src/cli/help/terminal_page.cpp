#include "cli/help/page.hpp"
#include "report/text_table.hpp"

namespace qerr::cli {

namespace {

/// Text without the marks of strong parts; code keeps its quotes.
std::string plain(const std::string& text) {
  std::string out;
  bool code = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] == '`') code = !code;
    if (!code && text.compare(i, 2, "**") == 0)
      ++i;
    else
      out += text[i];
  }
  return out;
}

std::string indented(const std::string& text) {
  std::string out;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = text.find('\n', at);
    const std::string line = text.substr(at, end - at);
    out += (line.empty() ? "" : "  " + line) + '\n';
    at = end + 1;
  }
  return out;
}

std::string table_of(const Block& block, std::size_t width) {
  std::vector<std::vector<std::string>> rows;
  for (const auto& row : block.rows) {
    rows.emplace_back();
    for (const std::string& cell : row) rows.back().push_back(plain(cell));
  }
  return wrapped_table(rows, width);
}

std::string text_of(const Block& block, const Style& style) {
  switch (block.kind) {
    case Block::Kind::heading:
      return painted(plain(block.text), Paint::bold, style) + '\n';
    case Block::Kind::paragraph:
      return wrapped(plain(block.text), style.width);
    case Block::Kind::verbatim:
      return indented(block.text);
    case Block::Kind::item:
      return wrapped(plain(block.text), style.width, "  ", "- ");
    case Block::Kind::term:
      return defined(block.term, plain(block.text), style.width);
    case Block::Kind::table:
      return table_of(block, style.width);
  }
  return "";
}

/// Headings, and blocks that continue a list of the same kind, follow without an empty line.
bool is_close(const Block& before, const Block& block) {
  const bool list = block.kind == Block::Kind::item || block.kind == Block::Kind::term;
  return before.kind == Block::Kind::heading || (list && before.kind == block.kind);
}

}  // namespace

std::string to_terminal(const Page& page, const Style& style) {
  std::string out =
      wrapped("qerr" + (page.name.empty() ? "" : ' ' + page.name) + ": " + page.summary, style.width);
  const Block* before = nullptr;
  for (const Block& block : page.blocks) {
    if (!before || !is_close(*before, block)) out += '\n';
    out += text_of(block, style);
    before = &block;
  }
  return out;
}

}  // namespace qerr::cli
