#include "report/sweep/csv_lines.hpp"

#include "core/text.hpp"

namespace qerr {

namespace {

bool has_hidden(std::string_view line) {
  for (std::size_t at = 0; at < line.size();) {
    const auto byte = static_cast<unsigned char>(line[at]);
    const bool plain = 0x20 <= byte && byte < 0x7f;
    if (!plain && hidden_length(line, at) > 0) return true;
    at += plain ? 1 : utf8_length(line, at);
  }
  return false;
}

}  // namespace

std::size_t cells_of(std::string_view line) {
  std::size_t cells = 1;
  bool within = false;
  for (const char c : line) {
    within = within != (c == '"');
    cells += c == ',' && !within;
  }
  return cells;
}

std::string damage_of(std::string_view line, std::string_view before, std::size_t cells) {
  if (const std::size_t own = cells_of(line); own != cells)
    return "the line has " + counted(own, "cell") + ", and the first line " + std::to_string(cells);
  if (has_hidden(line)) return "the line has characters that qerr does not write";
  if (line == before) return "the line repeats the one before";
  return "";
}

bool CsvLines::next() {
  constexpr std::size_t block_size = std::size_t{1} << 18;
  std::size_t end;
  while ((end = buffer_.find(csv_line_break, at_)) == std::string::npos) {
    buffer_.erase(0, at_);
    start_ += at_;
    at_ = 0;
    const std::string more = read_(start_ + buffer_.size(), block_size);
    if (more.empty()) break;
    buffer_ += more;
  }
  begin_ = start_ + at_;
  ended_ = end != std::string::npos;
  line_ = std::string_view(buffer_).substr(at_, (ended_ ? end : buffer_.size()) - at_);
  at_ = ended_ ? end + csv_line_break.size() : buffer_.size();
  ++number_;
  return ended_ || !line_.empty();
}

}  // namespace qerr
