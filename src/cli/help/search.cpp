#include <algorithm>
#include <cctype>
#include <tuple>

#include "cli/help/page.hpp"
#include "core/text.hpp"
#include "report/text_table.hpp"

namespace qerr::cli {

namespace {

constexpr std::size_t most_shown_pages = 5, most_shown_places = 3, most_shown_characters = 240;

char lower(char c) { return static_cast<char>(std::tolower(static_cast<unsigned char>(c))); }

bool is_letter(char c) { return std::isalnum(static_cast<unsigned char>(c)) || (c & 0x80); }

/// The place of a word of the text that begins with `word`; npos if there is none.
std::size_t place_of(std::string_view word, std::string_view text) {
  const auto same = [](char a, char b) { return lower(a) == lower(b); };
  for (auto from = text.begin();; ++from) {
    from = std::search(from, text.end(), word.begin(), word.end(), same);
    if (from == text.end()) return std::string_view::npos;
    if (from == text.begin() || !is_letter(from[-1])) return static_cast<std::size_t>(from - text.begin());
  }
}

bool has_all(const std::vector<std::string>& words, std::string_view text) {
  return std::all_of(words.begin(), words.end(),
                     [&](const std::string& word) { return place_of(word, text) != std::string_view::npos; });
}

/// The lines of a verbatim block, the rows of a table below its header, the text of any other block.
std::vector<std::string> texts_of(const Block& block) {
  std::vector<std::string> texts;
  if (block.kind == Block::Kind::verbatim) {
    for (const std::string& line : lines_of(block.text)) texts.push_back('`' + line + '`');
  } else if (block.kind == Block::Kind::table) {
    for (std::size_t r = 1; r < block.rows.size(); ++r) {
      texts.emplace_back();
      for (const std::string& cell : block.rows[r])
        texts.back() += (texts.back().empty() ? "" : &cell == &block.rows[r][1] ? ": " : "; ") + cell;
    }
  } else {
    texts.push_back(block.term.empty() ? block.text : block.term + ": " + block.text);
  }
  return texts;
}

/// The part of a long text around the first word, from a blank to a blank.
std::string excerpt(const std::string& text, const std::string& word) {
  if (text.size() <= most_shown_characters) return text;
  const std::size_t place = place_of(word, text);
  std::size_t begin =
      place < most_shown_characters / 2 ? 0 : text.rfind(' ', place - most_shown_characters / 3);
  if (begin == std::string::npos) begin = 0;
  const std::size_t end = std::min(text.find(' ', begin + most_shown_characters), text.size());
  std::string part = text.substr(begin, end - begin);
  // A mark whose other end is outside would reach over what follows.
  if (std::count(part.begin(), part.end(), '`') % 2) std::erase(part, '`');
  return (begin ? "..." : "") + part + (end < text.size() ? " ..." : "");
}

struct Found {
  const Page* page;
  int rank;                         ///< 2: the page's name has the words; 1: its summary; 0: its text alone
  std::vector<std::string> places;  ///< excerpts below their heading; of prose, then of code
  std::size_t prose = 0;            ///< how many of them are prose
};

Found found_in(const Page& page, const std::vector<std::string>& words) {
  Found found{&page, has_all(words, page.name) ? 2 : has_all(words, page.name + ": " + page.summary), {}};
  std::vector<std::string> code;
  std::string heading;
  for (const Block& block : page.blocks) {
    if (block.kind == Block::Kind::heading) heading = block.text;
    for (const std::string& text : texts_of(block))
      if (heading != "Common options" && has_all(words, text)) {
        const bool alone = heading.empty() || block.kind == Block::Kind::heading;
        (block.kind == Block::Kind::verbatim ? code : found.places)
            .push_back((alone ? "" : heading + ": ") + excerpt(text, words.front()));
      }
  }
  found.prose = found.places.size();
  found.places.insert(found.places.end(), code.begin(), code.end());
  return found;
}

}  // namespace

std::optional<Page> search_pages(const std::vector<std::string>& words) {
  std::vector<Page> pages;
  for (const Page& topic : topics()) pages.push_back(topic);
  for (const Command& command : commands()) pages.push_back(command_page(command));
  std::vector<Found> all;
  for (const Page& page : pages) {
    Found found = found_in(page, words);
    if (found.rank > 0 || !found.places.empty()) all.push_back(std::move(found));
  }
  if (all.empty()) return std::nullopt;
  std::stable_sort(all.begin(), all.end(), [](const Found& a, const Found& b) {
    return std::tie(a.rank, a.prose) > std::tie(b.rank, b.prose);
  });
  Page result{"help " + qerr::joined(words, " "), counted(all.size(), "page") + " of the help", {}};
  std::string others;
  for (std::size_t i = 0; i < all.size(); ++i) {
    const Page& page = *all[i].page;
    if (i >= most_shown_pages) {
      others += (others.empty() ? "" : ", ") + page.name;
      continue;
    }
    result.blocks.push_back({.kind = Block::Kind::heading, .text = "qerr help " + page.name});
    result.blocks.push_back({.kind = Block::Kind::paragraph, .text = page.summary});
    const auto& places = all[i].places;
    for (std::size_t k = 0; k < std::min(places.size(), most_shown_places); ++k)
      result.blocks.push_back({.kind = Block::Kind::item, .text = places[k]});
    if (places.size() > most_shown_places)
      result.blocks.push_back({.kind = Block::Kind::item,
                               .text = "and " + std::to_string(places.size() - most_shown_places) + " more"});
  }
  if (!others.empty()) {
    result.blocks.push_back({.kind = Block::Kind::heading, .text = "Also in"});
    result.blocks.push_back({.kind = Block::Kind::paragraph, .text = others});
  }
  return result;
}

}  // namespace qerr::cli
