#include <algorithm>
#include <cctype>

#include "cli/help/page.hpp"

namespace qerr::cli {

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
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = text.find('\n', at);
    out += escaped_roff(text.substr(at, end - at)) + '\n';
    at = end + 1;
  }
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
  std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return std::toupper(c); });
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

}  // namespace qerr::cli
