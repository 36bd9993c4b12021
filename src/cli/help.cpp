#include <algorithm>
#include <cctype>
#include <filesystem>
#include <stdexcept>
#include <tuple>

#include "cli/help/page.hpp"
#include "cli/shared.hpp"
#include "core/text.hpp"
#include "report/text_table.hpp"

namespace qerr::cli {

namespace {

Block heading(std::string text) { return {.kind = Block::Kind::heading, .text = std::move(text)}; }
Block verbatim(std::string text) { return {.kind = Block::Kind::verbatim, .text = std::move(text)}; }
Block term(std::string term, std::string text) {
  return {.kind = Block::Kind::term, .text = std::move(text), .term = std::move(term)};
}

/// The meaning, with the range and the fallback of the row.
std::string described(const Option& row) {
  std::string more = row.range();
  if (!row.fallback.empty()) more += (more.empty() ? "default " : "; default ") + std::string(row.fallback);
  return std::string(row.meaning) + (more.empty() ? "" : " (" + more + ')');
}

std::string written(const Option& row) {
  const std::string names = row.short_name().empty() ? "" : row.short_name() + ", ";
  return names + row.long_name() + (row.value.empty() ? "" : ' ' + std::string(row.value));
}

bool is_global(const Option& row) { return find_named(global_options(), row.name) != nullptr; }

template <class Choice>
void add_options(Page& page, const std::string& title, const std::vector<Option>& rows, Choice choice) {
  if (std::ranges::none_of(rows, choice)) return;
  page.blocks.push_back(heading(title));
  for (const Option& row : rows)
    if (choice(row))
      page.blocks.push_back(term(row.positional() ? row.long_name() : written(row), described(row)));
}

void add_examples(Page& page, const std::vector<Example>& examples) {
  if (examples.empty()) return;
  page.blocks.push_back(heading("Examples"));
  std::string text;
  for (const Example& example : examples)
    text += (text.empty() ? "# " : "\n# ") + std::string(example.answer) + '\n' + std::string(example.line) +
            '\n';
  page.blocks.push_back(verbatim(text));
}

Page command_page(const Command& command) {
  Page page{std::string(command.name), std::string(command.summary), {heading("Usage")}};
  page.blocks.push_back(verbatim(usage_line(command) + '\n'));
  add_options(page, "Arguments", command.options, [](const Option& row) { return row.positional(); });
  add_options(page, "Options", command.options,
              [](const Option& row) { return !row.positional() && !is_global(row); });
  add_options(page, "Common options", global_options(), [](const Option&) { return true; });
  add_examples(page, command.examples);
  if (!command.topics.empty()) {
    page.blocks.push_back(heading("See also"));
    std::string text;
    for (const std::string& topic : command.topics)
      text += (text.empty() ? "`qerr help " : ", `qerr help ") + topic + '`';
    page.blocks.push_back({.kind = Block::Kind::paragraph, .text = text});
  }
  return page;
}

Page overview_page() {
  Page page{"",
            "bounds of the errors that a robot's encoders cause at its tip, and in filtered velocity and "
            "acceleration",
            {heading("Usage")}};
  page.blocks.push_back(
      verbatim("qerr COMMAND [OPTION...] [ARGUMENT...]\nqerr help [COMMAND|TOPIC|WORD...]\n"));
  page.blocks.push_back(heading("Commands"));
  for (const Command& command : commands())
    page.blocks.push_back(term(std::string(command.name), std::string(command.summary)));
  page.blocks.push_back(heading("Topics"));
  for (const Page& topic : topics()) page.blocks.push_back(term(topic.name, topic.summary));
  add_options(page, "Common options", global_options(), [](const Option&) { return true; });
  add_examples(page, command_of("help")->examples);
  return page;
}

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
      throw Error({path.parent_path().string()}, "--" + option,
                  "the folder cannot be created: " + failure.message(), "", "name another one",
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
  if (words.size() == 1 && contains(names, words[0])) return page_of(words[0]);
  if (std::optional<Page> found = search_pages(words)) return *found;
  const std::string asked = qerr::joined(words, " "), near = nearest(asked, names);
  const std::string remedy =
      near.empty() ? "commands and topics: " + qerr::joined(names) : "did you mean '" + near + "'?";
  throw Error({"qerr help"}, "", "no page has this word", qerr::quoted(asked), remedy, Trouble::usage);
}

int run_help(const Values& v) {
  if (v.given("man")) write_pages(v, "man", man_place, to_man);
  if (v.given("html")) write_pages(v, "html", html_place, to_html);
  if (v.given("man") || v.given("html")) return 0;
  OutputFile out("-");
  finish(out, to_terminal(asked_page(v.texts("WORD")), terminal_style(v)));
  return 0;
}

constexpr std::size_t most_shown_pages = 5, most_shown_places = 3, most_shown_characters = 240;

char lower(char c) { return static_cast<char>(std::tolower(static_cast<unsigned char>(c))); }

bool is_letter(char c) { return std::isalnum(static_cast<unsigned char>(c)) || (c & 0x80); }

/// The place of a word of the text that begins with `word`; npos if there is none.
std::size_t place_of(std::string_view word, std::string_view text) {
  const auto same = [](char a, char b) { return lower(a) == lower(b); };
  for (auto from = text.begin();; ++from) {
    from = std::search(from, text.end(), word.begin(), word.end(), same);
    if (from == text.end()) return std::string_view::npos;
    if (from == text.begin() || !is_letter(from[-1])) return from - text.begin();
  }
}

bool has_all(const std::vector<std::string>& words, std::string_view text) {
  return std::ranges::all_of(
      words, [&](const std::string& word) { return place_of(word, text) != std::string_view::npos; });
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
  if (std::ranges::count(part, '`') % 2) std::erase(part, '`');
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

const std::vector<Page>& topics() {
  static const std::vector<Page> pages = [] {
    std::vector<Page> all;
    for (const std::string_view text : topic_texts()) all.push_back(parse_markdown(text));
    std::ranges::sort(all, [](const Page& a, const Page& b) { return a.name < b.name; });
    return all;
  }();
  return pages;
}

std::vector<std::string> page_names() {
  std::vector<std::string> names = command_names();
  append(names, names_of(topics()));
  return names;
}

Page page_of(std::string_view name) {
  if (name.empty()) return overview_page();
  if (const Command* command = command_of(name)) return command_page(*command);
  for (const Page& topic : topics())
    if (topic.name == name) return topic;
  throw std::logic_error("no page of the help has the name '" + std::string(name) + "'");
}

Command help_command() {
  return {"help",
          "The commands and topics, one of them, or the pages that have a word",
          {{.name = "WORD",
            .kind = OptionKind::repeat,
            .meaning = "a command, a topic, or words to search for",
            .choices = page_names,
            .open = true,
            .choice = "command or topic"},
           valued("--man", "FOLDER", "write all pages as man pages there; man -M FOLDER shows them"),
           valued("--html", "FOLDER", "write all pages there as a static site: index.html")},
          run_help,
          {{"qerr help", "the commands and the topics"},
           {"qerr help encoders", "how to specify an encoder, with the words of its data sheet"},
           {"qerr help figures", "what the figures of a report mean, and on what they depend"},
           {"qerr help TCP", "every page that has the word"},
           {"qerr help --html site", "all pages as a static site"}}};
}

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
  std::ranges::stable_sort(all, [](const Found& a, const Found& b) {
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
