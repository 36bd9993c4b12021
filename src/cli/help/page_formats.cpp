#include <algorithm>
#include <cctype>
#include <stdexcept>

#include "cli/help/page.hpp"
#include "core/text.hpp"
#include "report/page/page.hpp"
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
  for (const std::string& line : lines_of(text)) out += (line.empty() ? "" : "  " + line) + '\n';
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

namespace {

/// Characters that roff would interpret, escaped.
std::string escaped_roff(std::string_view text) {
  std::string out;
  for (const char c : text) {
    if (c == '\\')
      out += "\\e";
    else if (c == '-')
      out += "\\-";
    else if (c == '\'')
      out += "\\(aq";
    else if (c == '^')
      out += "\\(ha";
    else if (c == '~')
      out += "\\(ti";
    else
      out += c;
  }
  // A control line starts with a dot.
  return out.starts_with('.') ? "\\&" + out : out;
}

/// A paragraph: code and strong parts in bold.
std::string inline_roff(const std::string& text) {
  std::string out;
  for (const Part& part : parts_of(text)) {
    const std::string plain = escaped_roff(part.text);
    out += part.code || part.strong ? "\\fB" + plain + "\\fR" : plain;
  }
  return out;
}

std::string verbatim_roff(const std::string& text) {
  std::string out = ".PP\n.RS 4\n.nf\n";
  for (const std::string& line : lines_of(text)) out += escaped_roff(line) + '\n';
  return out + ".fi\n.RE\n";
}

/// A table for tbl(1); cells of the last column are filled to the page.
std::string table_roff(const Block& block) {
  const std::size_t columns = block.rows.empty() ? 0 : block.rows.front().size();
  std::string format;
  for (std::size_t i = 0; i < columns; ++i) format += i + 1 == columns ? "lx" : "l ";
  std::string out = ".PP\n.TS\n" + format + ".\n";
  for (const auto& row : block.rows) {
    for (std::size_t i = 0; i < row.size(); ++i)
      out += (i ? "\t" : "") + ("T{\n" + inline_roff(row[i]) + "\nT}");
    out += '\n';
  }
  return out + ".TE\n";
}

std::string upper(std::string text) {
  std::ranges::transform(text, text.begin(), [](unsigned char c) { return std::toupper(c); });
  return text;
}

std::string roff_of(const Block& block) {
  switch (block.kind) {
    case Block::Kind::heading:
      return ".SH " + escaped_roff(block.text == "Usage" ? "SYNOPSIS" : upper(block.text)) + '\n';
    case Block::Kind::paragraph:
      return ".PP\n" + inline_roff(block.text) + '\n';
    case Block::Kind::verbatim:
      return verbatim_roff(block.text);
    case Block::Kind::item:
      return ".IP \\(bu 2\n" + inline_roff(block.text) + '\n';
    case Block::Kind::term:
      return ".TP\n\\fB" + escaped_roff(block.term) + "\\fR\n" + inline_roff(block.text) + '\n';
    case Block::Kind::table:
      return table_roff(block);
  }
  return "";
}

std::string title_of(const Page& page) { return page.name.empty() ? "qerr" : "qerr-" + page.name; }

}  // namespace

std::string man_section(const Page& page) { return page.name.empty() || command_of(page.name) ? "1" : "7"; }

std::string man_file(const Page& page) { return title_of(page) + '.' + man_section(page); }

std::string to_man(const Page& page) {
  // The first line asks man(1) to run tbl(1).
  std::string out = "'\\\" t\n.TH " + escaped_roff(upper(title_of(page))) + ' ' + man_section(page) +
                    " \"\" \"qerr " + std::string(version()) + "\" \"qerr\"\n.ad l\n.nh\n.SH NAME\n" +
                    escaped_roff(title_of(page)) + " \\- " + escaped_roff(page.summary) + '\n';
  if (!page.blocks.empty() && page.blocks.front().kind != Block::Kind::heading) out += ".SH DESCRIPTION\n";
  for (const Block& block : page.blocks) out += roff_of(block);
  return out;
}

namespace {

using page::escaped_markup;

std::string link_to(std::string_view name, const std::string& shown) {
  return "<a href=\"" + html_file(name) + "\">" + shown + "</a>";
}

bool is_page(std::string_view name) { return contains(page_names(), name); }

/// Code that is `qerr help NAME` leads to that page.
std::string inline_html(const std::string& text) {
  constexpr std::string_view help = "qerr help ";
  std::string out;
  for (const Part& part : parts_of(text)) {
    std::string shown = escaped_markup(part.text);
    if (part.code) shown = "<code>" + shown + "</code>";
    if (part.strong) shown = "<strong>" + shown + "</strong>";
    const std::string name = part.code && part.text.starts_with(help) ? part.text.substr(help.size()) : "";
    out += !name.empty() && is_page(name) ? link_to(name, shown) : shown;
  }
  return out;
}

std::string table_html(const Block& block) {
  std::string out = "<div class=\"wide\"><table>";
  for (std::size_t i = 0; i < block.rows.size(); ++i) {
    const std::string cell = i == 0 ? "th" : "td";
    out += "<tr>";
    for (const std::string& text : block.rows[i])
      out += '<' + cell + '>' + inline_html(text) + "</" + cell + '>';
    out += "</tr>\n";
  }
  return out + "</table></div>\n";
}

/// The element of a list, without the list.
std::string html_of(const Block& block) {
  switch (block.kind) {
    case Block::Kind::heading:
      return "";
    case Block::Kind::paragraph:
      return "<p>" + inline_html(block.text) + "</p>\n";
    case Block::Kind::verbatim:
      return "<pre>" + escaped_markup(block.text) + "</pre>\n";
    case Block::Kind::item:
      return "<li>" + inline_html(block.text) + "</li>\n";
    case Block::Kind::term: {
      const std::string term = escaped_markup(block.term);
      return "<dt>" + (is_page(block.term) ? link_to(block.term, term) : "<code>" + term + "</code>") +
             "</dt><dd>" + inline_html(block.text) + "</dd>\n";
    }
    case Block::Kind::table:
      return table_html(block);
  }
  return "";
}

/// The element that holds blocks of this kind; "" if they stand alone.
std::string list_of(Block::Kind kind) {
  return kind == Block::Kind::item ? "ul" : kind == Block::Kind::term ? "dl" : "";
}

}  // namespace

std::string html_file(std::string_view name) {
  return (name.empty() ? "index" : std::string(name)) + ".html";
}

std::string to_html(const Page& page) {
  page::Page site{
      .title = "qerr" + (page.name.empty() ? "" : ' ' + page.name), .answer = page.summary, .sections = {}};
  if (!page.name.empty()) site.about = "<p>" + link_to("", "all pages") + "</p>\n";
  std::string* body = &site.about;
  std::string open;
  const auto change_list = [&](const std::string& list) {
    if (list == open) return;
    if (!open.empty()) *body += "</" + open + ">\n";
    if (!list.empty()) *body += '<' + list + ">\n";
    open = list;
  };
  for (const Block& block : page.blocks) {
    change_list(list_of(block.kind));
    if (block.kind == Block::Kind::heading)
      body = &site.sections.emplace_back(page::PageSection{block.text, ""}).body;
    *body += html_of(block);
  }
  change_list("");
  return page::markup(site);
}

}  // namespace qerr::cli
