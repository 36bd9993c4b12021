#include <stdexcept>

#include "cli/help/page.hpp"
#include "core/text.hpp"
#include "report/text_table.hpp"

namespace qerr::cli {

namespace {

/// `| a | b |`; `\|` is a bar in a cell.
std::vector<std::string> cells_of(const std::string& line) {
  std::vector<std::string> cells;
  std::string cell;
  for (std::size_t i = 1; i < line.size(); ++i) {
    const bool escaped_bar = line[i] == '\\' && i + 1 < line.size() && line[i + 1] == '|';
    if (line[i] == '|') {
      cells.emplace_back(trimmed(cell));
      cell.clear();
    } else {
      cell += line[escaped_bar ? ++i : i];
    }
  }
  return cells;
}

/// The rows of a family, each with its summary.
void add_list(Page& page, const std::string& kind) {
  for (const ListReport::Row& row : list_report(kind).rows)
    page.blocks.push_back({.kind = Block::Kind::term, .text = row.summary, .term = row.name});
}

class Reader {
 public:
  explicit Reader(std::string_view text) : lines_(lines_of(text)) {}

  Page page() {
    const std::string& title = lines_.at(at_++);
    const std::size_t colon = title.find(": ");
    if (!title.starts_with("# ") || colon == std::string::npos)
      throw std::logic_error("a topic starts with '# NAME: SUMMARY', not with '" + title + "'");
    page_ = {title.substr(2, colon - 2), title.substr(colon + 2), {}};
    while (at_ < lines_.size()) block();
    return std::move(page_);
  }

 private:
  bool starts(std::string_view with) const { return at_ < lines_.size() && lines_[at_].starts_with(with); }

  /// Whether the line continues a paragraph or an item.
  bool continues() const {
    return at_ < lines_.size() && !lines_[at_].empty() && !starts("#") && !starts("```") && !starts("- ") &&
           !starts("|") && !starts("<!--");
  }

  std::string joined_lines(std::string text) {
    while (continues()) text.append(1, ' ').append(trimmed(lines_[at_++]));
    return text;
  }

  void block() {
    if (lines_[at_].empty()) {
      ++at_;
    } else if (starts("## ")) {
      page_.blocks.push_back({.kind = Block::Kind::heading, .text = lines_[at_++].substr(3)});
    } else if (starts("```")) {
      verbatim();
    } else if (starts("|")) {
      table();
    } else if (starts("<!-- list ")) {
      const std::string& line = lines_[at_++];
      add_list(page_, std::string(trimmed(line.substr(10, line.find(" -->") - 10))));
    } else if (starts("- ")) {
      const std::string first = lines_[at_++].substr(2);
      page_.blocks.push_back({.kind = Block::Kind::item, .text = joined_lines(first)});
    } else {
      const std::string first = lines_[at_++];
      page_.blocks.push_back({.kind = Block::Kind::paragraph, .text = joined_lines(first)});
    }
  }

  void verbatim() {
    std::string text;
    for (++at_; at_ < lines_.size() && !starts("```"); ++at_) text += lines_[at_] + '\n';
    ++at_;
    page_.blocks.push_back({.kind = Block::Kind::verbatim, .text = text});
  }

  void table() {
    Block table{.kind = Block::Kind::table};
    for (; starts("|"); ++at_)
      if (!starts("|-") && !starts("|:")) table.rows.push_back(cells_of(lines_[at_]));
    page_.blocks.push_back(table);
  }

  std::vector<std::string> lines_;
  std::size_t at_ = 0;
  Page page_;
};

}  // namespace

std::vector<Part> parts_of(const std::string& text) {
  std::vector<Part> parts;
  Part part;
  for (std::size_t i = 0; i <= text.size(); ++i) {
    const bool star = !part.code && text.compare(std::min(i, text.size()), 2, "**") == 0;
    if (i < text.size() && text[i] != '`' && !star) {
      part.text += text[i];
      continue;
    }
    if (!part.text.empty()) parts.push_back(part);
    part.text.clear();
    star ? part.strong = !part.strong : part.code = !part.code;
    i += star;
  }
  return parts;
}

Page parse_markdown(std::string_view text) { return Reader(text).page(); }

}  // namespace qerr::cli
