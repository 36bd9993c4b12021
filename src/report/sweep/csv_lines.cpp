#include "report/sweep/csv_lines.hpp"

namespace qerr {

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
