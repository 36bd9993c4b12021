#include "report/sweep/shard_file.hpp"

#include "core/text.hpp"
#include "qerr/core/error.hpp"
#include "report/sweep/csv_lines.hpp"

namespace qerr {

namespace {

/// Reads what a file holds of the variants that it should hold.
class HeldVariants {
 public:
  HeldVariants(GrowingFile& file, std::uint64_t count, const std::function<std::string(std::uint64_t)>& cells)
      : path_(file.path()),
        lines_([&](std::uint64_t from, std::size_t most) { return file.read(from, most); }),
        count_(count),
        cells_(cells) {}

  /// @returns whether the file has a header: else nothing of it is whole
  bool read_header(const std::string& header) {
    if (!lines_.next()) return false;
    const std::string line = header + std::string(csv_line_break);
    header_cells_ = cells_of(header);
    if (!lines_.ended() && line.starts_with(lines_.line())) return false;
    if (lines_.ended() && lines_.line() == header) return true;
    if (!lines_.line().starts_with("variant,")) refuse("is no CSV of qerr sweep", "");
    refuse("has other columns than this sweep", shown(lines_.line()));
  }

  /// Reads all lines. Those of the last variant that is seen may be incomplete.
  void read_variants() {
    next_cells_ = cells_of_variant(0);
    while (lines_.next()) {
      const std::string_view line = lines_.line();
      const bool same = seen_ > 0 && line.starts_with(cells_of_last_);
      if (!same && !begins_next(line)) {
        if (!lines_.ended() && (next_cells_.starts_with(line) || cells_of_last_.starts_with(line))) return;
        refuse(seen_ == count_ && lines_.ended() ? "has more variants than this sweep"
                                                 : "has another variant where this sweep has '" +
                                                       next_cells_.substr(0, next_cells_.size() - 1) + "'",
               shown(line));
      }
      // A damaged line, too, is not whole: what follows is computed anew.
      if (lines_.ended() && !damage_of(line, line_before_, header_cells_).empty()) return;
      line_before_ = line;
      last_ += line;
      last_ += csv_line_break;
    }
  }

  std::uint64_t whole() const { return seen_ > 0 ? seen_ - 1 : 0; }
  /// Where the line break before the variant begins that is not whole.
  std::uint64_t end_of_whole() const { return end_of_whole_; }

  /// Compares a variant that is whole, and is computed anew, with the file.
  void compare(std::uint64_t variant, const std::string& lines) const {
    if (lines == (variant == 0 ? first_ : before_last_)) return;
    throw Error(
        Fault{{path_},
              "--resume",
              "holds other figures than this sweep has",
              "'" + cells_(variant) + "...'",
              "the spec, an option or the version differs from the run that is resumed: repeat it as it "
              "was, or leave out --resume to begin anew"});
  }

 private:
  std::string cells_of_variant(std::uint64_t i) const { return i < count_ ? cells_(i) : std::string(); }

  bool begins_next(std::string_view line) {
    if (seen_ == count_ || !line.starts_with(next_cells_)) return false;
    if (seen_ == 1) first_ = last_;
    before_last_ = std::move(last_);
    last_.clear();
    cells_of_last_ = next_cells_;
    next_cells_ = cells_of_variant(++seen_);
    end_of_whole_ = lines_.begin() - csv_line_break.size();
    return true;
  }

  static std::string shown(std::string_view line) { return quoted(std::string(line.substr(0, 60))); }

  [[noreturn]] void refuse(const std::string& rule, const std::string& found) const {
    throw Error(Fault{{path_, static_cast<int>(lines_.number()), 0},
                      "--resume",
                      "the file " + rule,
                      found,
                      "repeat the spec and the options of the run that is resumed, or leave out --resume to "
                      "begin anew"});
  }

  std::string path_;
  std::size_t header_cells_ = 0;
  std::string line_before_;
  CsvLines lines_;
  std::uint64_t count_;
  const std::function<std::string(std::uint64_t)>& cells_;
  std::uint64_t seen_ = 0, end_of_whole_ = 0;
  std::string cells_of_last_, next_cells_;
  std::string first_, before_last_, last_;  // lines of these variants
};

}  // namespace

ShardFile::ShardFile(const std::string& path, const std::string& option, std::string header, bool keep)
    : file_(path, option, keep), header_(std::move(header)) {
  if (!keep || !file_.regular()) file_.write(header_);
}

std::uint64_t ShardFile::resume(std::uint64_t count, const std::function<std::string(std::uint64_t)>& cells,
                                const std::function<std::string(std::uint64_t)>& lines) {
  if (!file_.regular()) return 0;
  HeldVariants held(file_, count, cells);
  if (held.read_header(header_)) {
    held.read_variants();
    const std::uint64_t whole = held.whole();
    if (whole > 0) held.compare(0, lines(0));
    if (whole > 1) held.compare(whole - 1, lines(whole - 1));
    if (whole > 0) {
      file_.cut(held.end_of_whole());
      return whole;
    }
  }
  file_.cut(0);
  file_.write(header_);
  return 0;
}

void ShardFile::write(std::string_view lines) {
  if (lines.empty()) return;
  lines.remove_suffix(csv_line_break.size());
  file_.write(std::string(csv_line_break).append(lines));
}

void ShardFile::close() {
  file_.write(csv_line_break);
  file_.close();
}

}  // namespace qerr
