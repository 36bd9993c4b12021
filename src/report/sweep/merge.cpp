#include "report/sweep/merge.hpp"

#include <charconv>
#include <cstdint>
#include <deque>
#include <map>

#include "core/text.hpp"
#include "input/byte_source.hpp"
#include "qerr/core/error.hpp"
#include "report/sweep/csv_lines.hpp"

namespace qerr {

namespace {

/// The file of a shard.
class ShardReader {
 public:
  explicit ShardReader(const std::string& path)
      : path_(path), source_(path), lines_([this](std::uint64_t, std::size_t most) {
          std::string text(most, '\0');
          text.resize(source_.read(text.data(), most));
          return text;
        }) {
    const std::optional<ShardHeader>& header = lines_.read_header();
    if (!header)
      refuse("is no shard of qerr sweep", "give the files that this version of qerr sweep --shard wrote", 1);
    header_ = *header;
    require_end();
  }

  const std::string& path() const { return path_; }
  const ShardHeader& header() const { return header_; }

  /// The lines of a variant, which must be the next one.
  std::string take(std::uint64_t variant, SweepCounts& counts) {
    if (!lines_.next())
      refuse("variant " + std::to_string(variant) + " is missing at the end of the file",
             "complete it: qerr sweep ... -o " + shell_word(path_) + " --resume", lines_.number());
    require_end();
    if (!lines_.whole() || lines_.variant() != variant || !count_verdict(counts, lines_.verdict()))
      refuse("variant " + std::to_string(variant) + " was changed after it was written",
             "compute it anew: qerr sweep ... -o " + shell_word(path_) + " --resume", lines_.number());
    return lines_.text();
  }

  void require_no_more() {
    if (lines_.next())
      refuse("the file has more variants than its shard", "compute this shard anew", lines_.number());
  }

  [[noreturn]] void refuse(const std::string& rule, const std::string& remedy, std::uint64_t line = 0,
                           const std::string& found = {}) const {
    throw Error(Fault{{path_, static_cast<int>(line), 0}, "", rule, found, remedy});
  }

 private:
  void require_end() const {
    if (!lines_.ended())
      refuse("the file is not complete", "complete it: qerr sweep ... -o " + shell_word(path_) + " --resume",
             lines_.number());
  }

  std::string path_;
  ByteSource source_;
  ShardLines lines_;
  ShardHeader header_;
};

/// All shards, by their numbers.
class Shards {
 public:
  Shards(const std::vector<std::string>& files, const RunRecord* expected) {
    for (const std::string& file : files) {
      const ShardReader& shard = readers_.emplace_back(file);
      const ShardHeader& header = shard.header();
      if (expected) require_same(shard, *expected, "the sweep of the spec");
      const ShardHeader& first = readers_.front().header();
      require_same(shard, first.record, quoted(readers_.front().path()));
      if (header.columns != first.columns)
        shard.refuse("has other columns than " + quoted(readers_.front().path()), one_sweep);
      if (header.shard.stride != first.shard.stride)
        shard.refuse("is divided into another number of shards than " + quoted(readers_.front().path()),
                     one_sweep, 0,
                     std::to_string(header.shard.stride) + ", not " + std::to_string(first.shard.stride));
      const auto [same, is_new] = by_number_.emplace(header.shard.first, &readers_.back());
      if (!is_new)
        shard.refuse(
            "is shard " + name(header.shard.first) + ", which " + quoted(same->second->path()) + " is, too",
            "give each shard once");
    }
    for (std::uint64_t k = 0; k < count(); ++k)
      if (!by_number_.contains(k))
        readers_.front().refuse("shard " + name(k) + " is missing", "give the files of all shards", 0,
                                counted(readers_.size(), "file"));
  }

  std::uint64_t count() const { return readers_.front().header().shard.stride; }
  ShardReader& of_variant(std::uint64_t variant) { return *by_number_.at(variant % count()); }
  const ShardHeader& header() const { return readers_.front().header(); }
  void require_no_more() {
    for (ShardReader& reader : readers_) reader.require_no_more();
  }

 private:
  static constexpr const char* one_sweep = "merge the shards of one sweep, divided into the same number";

  static void require_same(const ShardReader& shard, const RunRecord& other, const std::string& name) {
    const std::string changed = shard.header().record.difference(other);
    if (!changed.empty())
      shard.refuse("is of another sweep than " + name,
                   "compute this shard anew, or give the shards, the spec and the options of one sweep", 0,
                   "different: " + changed);
  }

  std::string name(std::uint64_t k) const { return std::to_string(k + 1) + '/' + std::to_string(count()); }

  std::deque<ShardReader> readers_;  // at fixed addresses
  std::map<std::uint64_t, ShardReader*> by_number_;
};

}  // namespace

SweepCounts merge_shards(const std::vector<std::string>& files, const RunRecord* expected,
                         const std::function<void(const std::string&)>& write) {
  Shards shards(files, expected);
  const std::string total = shards.header().record.value("variants");
  std::uint64_t variants = 0;
  std::from_chars(total.data(), total.data() + total.size(), variants);
  write(shards.header().columns + std::string(csv_line_break));
  SweepCounts counts;
  for (std::uint64_t variant = 0; variant < variants; ++variant)
    write(shards.of_variant(variant).take(variant, counts));
  shards.require_no_more();
  return counts;
}

}  // namespace qerr
