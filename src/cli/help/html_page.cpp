#include <algorithm>

#include "cli/help/page.hpp"
#include "report/page/markup.hpp"
#include "report/page/page.hpp"

namespace qerr::cli {

namespace {

using page::escaped_markup;

std::string link_to(std::string_view name, const std::string& shown) {
  return "<a href=\"" + html_file(name) + "\">" + shown + "</a>";
}

bool is_page(std::string_view name) {
  const std::vector<std::string> names = page_names();
  return std::find(names.begin(), names.end(), name) != names.end();
}

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
