#include "report/sweep/merge.hpp"

#include <charconv>
#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <set>

#include "core/text.hpp"
#include "input/byte_source.hpp"
#include "qerr/core/error.hpp"
#include "report/sweep/csv_lines.hpp"

namespace qerr {

namespace {

/// The file of a shard, read variant by variant.
class ShardReader {
 public:
  explicit ShardReader(const std::string& path)
      : path_(path), source_(path), lines_([this](std::uint64_t, std::size_t most) {
          std::string text(most, '\0');
          text.resize(source_.read(text.data(), most));
          return text;
        }) {
    if (!lines_.next() || !lines_.line().starts_with("variant,"))
      refuse("is no CSV of qerr sweep", "", "give the files that qerr sweep --shard wrote");
    header_ = lines_.line();
    cells_ = cells_of(header_);
    marked_ = header_.ends_with(shard_column);
    if (marked_) header_.resize(header_.size() - shard_column.size());
    require_break();
    more_ = lines_.next();
    read_number();
  }

  const std::string& path() const { return path_; }
  const std::string& header() const { return header_; }
  /// Whether each line ends with the shard that it is of.
  bool marked() const { return marked_; }
  /// That shard; empty if the file has no line.
  const std::string& shard() const { return shard_; }
  /// The variant that `take` returns next; empty at the end.
  std::optional<std::uint64_t> variant() const { return variant_; }

  /// The lines of the next variant.
  std::string take() {
    std::string text;
    const std::uint64_t taken = *variant_;
    while (variant_ == taken) {
      text.append(line_).append(csv_line_break);
      require_break();
      more_ = lines_.next();
      read_number();
    }
    return text;
  }

  [[noreturn]] void refuse(const std::string& rule, const std::string& found,
                           const std::string& remedy) const {
    throw Error(Fault{{path_, static_cast<int>(lines_.number()), 0}, "", rule, found, remedy});
  }

 private:
  void require_break() const {
    if (!lines_.ended())
      refuse("the file is not complete", "",
             "complete it: qerr sweep ... -o " + shell_word(path_) + " --resume");
  }

  void read_number() {
    variant_.reset();
    if (!more_) return;
    line_ = lines_.line();
    if (lines_.ended()) require_whole_line();
    if (marked_ && lines_.ended()) read_shard();
    const std::string_view line = line_;
    std::uint64_t number = 0;
    const auto [end, failure] = std::from_chars(line.data(), line.data() + line.size(), number);
    if (failure == std::errc{} && end != line.data() + line.size() && *end == ',')
      variant_ = number;
    else if (lines_.ended())
      refuse("a line does not begin with the number of a variant", "",
             "give the files that qerr sweep --shard wrote");
    else
      require_break();
  }

  /// A line that was damaged on its way, which the figures of one variant alone would not show.
  void require_whole_line() {
    if (const std::string damage = damage_of(line_, before_, cells_); !damage.empty())
      refuse(damage, quoted(line_.substr(0, 60)), "compute this shard anew");
    before_ = line_;
  }

  /// Takes the last cell off the line.
  void read_shard() {
    const std::string cell = line_.substr(line_.rfind(',') + 1);
    if (cell.find('/') == std::string::npos || !(shard_.empty() || shard_ == cell))
      refuse("a line does not end with the shard that it is of", "", "compute this shard anew");
    shard_ = cell;
    line_.resize(line_.size() - cell.size() - 1);
  }

  std::string path_;
  ByteSource source_;
  CsvLines lines_;
  std::string header_, line_, shard_, before_;  // before_: the line before, as it is in the file
  std::size_t cells_ = 0;                       // of every line
  bool more_ = false, marked_ = false;
  std::optional<std::uint64_t> variant_;
};

/// All shards, of which the variants are numbered 0, 1, 2, ...
class Merge {
 public:
  Merge(const std::vector<std::string>& files, const ExpectedSweep* expected) : expected_(expected) {
    for (const std::string& file : files) {
      ShardReader& shard = shards_.emplace_back(file);
      if (expected_ && shard.header() != expected_->header)
        shard.refuse("has other columns than the sweep of the spec", "", of_one_spec);
      if (shard.header() != shards_.front().header())
        shard.refuse("has other columns than " + quoted(shards_.front().path()) + ": it is of another sweep",
                     "", "merge the shards of one sweep, written with the same options");
      if (shard.marked() != shards_.front().marked())
        shard.refuse("is divided into another number of shards than " + quoted(shards_.front().path()), "",
                     "merge the shards of one sweep, divided into the same number of shards");
      put_back(shard);
    }
    if (shards_.front().marked() && !expected_) check_marks();
  }

  const std::string& header() const { return shards_.front().header(); }

  /// The lines of the next variant; empty at the end.
  std::optional<std::string> next() {
    if (waiting_.empty()) {
      if (expected_ && variant_ < expected_->count) refuse_end();
      return std::nullopt;
    }
    ShardReader& shard = *waiting_.begin()->second;
    if (*shard.variant() != variant_) refuse_gap();
    waiting_.erase(waiting_.begin());
    std::string lines = shard.take();
    if (expected_) check_expected(shard, lines);
    check_stride(shard);
    put_back(shard);
    ++variant_;
    return lines;
  }

 private:
  static constexpr const char* of_one_spec =
      "give the spec and the options with which the shards were written";

  void check_expected(ShardReader& shard, const std::string& lines) {
    if (variant_ >= expected_->count || !lines.starts_with(expected_->cells(variant_)))
      shard.refuse("variant " + std::to_string(variant_) + " has other values than in the spec", "",
                   of_one_spec);
    if (!compared_.insert(&shard).second || lines == expected_->lines(variant_)) return;
    shard.refuse("variant " + std::to_string(variant_) + " has other figures than the spec gives", "",
                 of_one_spec);
  }

  [[noreturn]] void refuse_end() const {
    throw Error(Fault{{shards_.front().path()},
                      "",
                      "variant " + std::to_string(variant_) + " of " + std::to_string(expected_->count) +
                          " is missing, in this and all other files",
                      "",
                      "give the files of all shards"});
  }

  /// Of shards with one variant at most each, the number of files must be that of the shards: some of the
  /// last ones have none.
  void check_marks() const {
    std::string total;
    for (const ShardReader& shard : shards_) {
      if (shard.shard().empty()) continue;
      const std::string own = shard.shard().substr(shard.shard().find('/') + 1);
      if (!total.empty() && own != total)
        shard.refuse("is shard " + shard.shard() + ", and another file is one of " + total, "",
                     "merge the shards of one sweep, divided into the same number of shards");
      total = own;
    }
    if (total == std::to_string(shards_.size())) return;
    throw Error(Fault{{shards_.front().path()},
                      "",
                      total.empty() ? "no file has a variant"
                                    : "there are " + total + " shards, some of them without a variant",
                      counted(shards_.size(), "file"),
                      "give the file of each shard once"});
  }

  void put_back(ShardReader& shard) {
    const auto variant = shard.variant();
    if (!variant) return;
    const auto [same, is_new] = waiting_.emplace(*variant, &shard);
    if (!is_new)
      shard.refuse(
          "has variant " + std::to_string(*variant) + ", which " + quoted(same->second->path()) + " has, too",
          "", "give each shard once");
    if (*variant < variant_)
      shard.refuse("has variant " + std::to_string(*variant) + " once more", "", "compute this shard anew");
  }

  /// Shard K of N has every N-th variant.
  void check_stride(const ShardReader& shard) {
    if (!shard.variant()) return;
    const std::uint64_t step = *shard.variant() - variant_;
    if (*shard.variant() > variant_ && stride_ == 0) stride_ = step;
    if (step == stride_) return;
    shard.refuse("has variant " + std::to_string(*shard.variant()) + " after variant " +
                     std::to_string(variant_) + ", where one of " + counted(stride_, "shard") + " has " +
                     std::to_string(variant_ + stride_),
                 "", "merge the shards of one sweep, divided into the same number of shards");
  }

  [[noreturn]] void refuse_gap() const {
    const std::string missing = "variant " + std::to_string(variant_);
    std::string which = "the shard that has it";
    if (stride_ > 0)
      which = "shard " + std::to_string(variant_ % stride_ + 1) + '/' + std::to_string(stride_);
    throw Error(
        Fault{{waiting_.begin()->second->path()},
              "",
              missing + " is missing, and this file has variant " + std::to_string(waiting_.begin()->first),
              "",
              "give " + which + ", too, and complete"});
  }

  const ExpectedSweep* expected_;
  std::set<const ShardReader*> compared_;          // whose figures were
  std::deque<ShardReader> shards_;                 // at fixed addresses
  std::map<std::uint64_t, ShardReader*> waiting_;  // by their next variant
  std::uint64_t variant_ = 0, stride_ = 0;
};

}  // namespace

void merge_shards(const std::vector<std::string>& files, const ExpectedSweep* expected,
                  const std::function<void(const std::string&)>& write) {
  Merge merge(files, expected);
  write(merge.header() + std::string(csv_line_break));
  while (const auto lines = merge.next()) write(*lines);
}

}  // namespace qerr
