#include "report/sweep/csv_lines.hpp"

#include <charconv>

#include "core/sha256.hpp"
#include "core/text.hpp"

namespace qerr {

namespace {

constexpr std::string_view shard_word = "shard ";

/// 48 bits: one of 3e14 changes is not noticed.
constexpr std::size_t checksum_digits = 12;

std::string checksum(const std::string& lines, char verdict, const std::string& mark) {
  Sha256 sum;
  sum.add(mark);
  sum.add({&verdict, 1});
  sum.add(lines);
  return sum.digest().substr(0, checksum_digits);
}

/// `2/5`.
std::optional<Shard> shard_of(std::string_view text) {
  Shard shard;
  const char *const begin = text.data(), *const end = begin + text.size();
  const auto [slash, failure] = std::from_chars(begin, end, shard.first);
  if (failure != std::errc{} || slash == end || *slash != '/') return std::nullopt;
  if (std::from_chars(slash + 1, end, shard.stride).ptr != end) return std::nullopt;
  if (shard.first < 1 || shard.first > shard.stride) return std::nullopt;
  --shard.first;
  return shard;
}

}  // namespace

bool has_hidden(std::string_view line) {
  for (std::size_t at = 0; at < line.size();) {
    const auto byte = static_cast<unsigned char>(line[at]);
    const bool plain = 0x20 <= byte && byte < 0x7f;
    if (!plain && hidden_length(line, at) > 0) return true;
    at += plain ? 1 : utf8_length(line, at);
  }
  return false;
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

std::string shard_mark(const Shard& shard, const RunRecord& record) {
  return std::string(shard_word) + std::to_string(shard.first + 1) + '/' + std::to_string(shard.stride) +
         "; " + record.text();
}

std::string marked_lines(const std::string& lines, char verdict, const std::string& mark) {
  std::string text;
  for (std::size_t at = 0; at < lines.size();) {
    const std::size_t end = lines.find(csv_line_break, at), next = end + csv_line_break.size();
    text.append(lines, at, end - at) += ',';
    if (next == lines.size()) text.append(1, verdict) += checksum(lines, verdict, mark);
    text += csv_line_break;
    at = next;
  }
  return text;
}

const std::optional<ShardHeader>& ShardLines::read_header() {
  if (!lines_.next()) return header_;
  const std::string_view line = lines_.line();
  const std::size_t comma = line.rfind(',');
  if (comma == std::string_view::npos || !line.substr(comma + 1).starts_with(shard_word)) return header_;
  const std::string_view mark = line.substr(comma + 1);
  const std::size_t end = std::min(mark.find("; "), mark.size());
  if (const auto shard = shard_of(mark.substr(shard_word.size(), end - shard_word.size())))
    header_ = {std::string(line.substr(0, comma)), std::string(mark), *shard,
               RunRecord(mark.substr(std::min(mark.size(), end + 2)))};
  return header_;
}

bool ShardLines::next() {
  text_.clear();
  std::string last;
  while (last.empty() && lines_.next()) {
    const std::string_view line = lines_.line();
    const std::size_t comma = std::min(line.rfind(','), line.size());
    text_.append(line.substr(0, comma)).append(csv_line_break);
    last = line.substr(std::min(line.size(), comma + 1));
    end_ = lines_.begin() + line.size();
  }
  if (text_.empty()) return false;
  verdict_ = last.empty() ? '\0' : last.front();
  const auto number = std::from_chars(text_.data(), text_.data() + text_.size(), variant_);
  whole_ =
      number.ec == std::errc{} && !last.empty() && last.substr(1) == checksum(text_, verdict_, header_->mark);
  return true;
}

}  // namespace qerr
