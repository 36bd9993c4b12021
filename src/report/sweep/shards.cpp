#include <algorithm>
#include <charconv>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <map>

#include "core/lists.hpp"
#include "core/text.hpp"
#include "input/csv.hpp"
#include "input/read_sections.hpp"
#include "qerr/core/error.hpp"
#include "qerr/report/write.hpp"
#include "report/sweep/sweep.hpp"

namespace qerr {

namespace {

using Entries = std::vector<std::pair<std::string, std::string>>;

/// A record must fit into the extended attribute of a file, of which 4 KB are common: that many names of
/// files of at most that many bytes; more are one entry.
constexpr std::size_t most_files = 24, longest_shown_name = 60;

/// 64 bits: changes by accident or by a person are noticed, and nobody gains by hiding one.
std::string fingerprint(const std::string& digest) { return digest.substr(0, 16); }

std::string fingerprint_of_file(const RunInput& input) {
  if (const auto text = piped_text(input.path)) return fingerprint(sha256(*text));
  Sha256 sum;
  ByteSource source(input.path);
  std::string block(std::size_t{1} << 16, '\0');
  while (const std::size_t count = source.read(block.data(), block.size()))
    sum.add(std::string_view(block).substr(0, count));
  return fingerprint(sum.digest());
}

/// Printable ASCII without the characters that separate entries or cells.
std::string plain(const std::string& text) {
  std::string out;
  for (const char c : text.substr(0, longest_shown_name))
    out += c < ' ' || c > '~' || std::string_view(",;=\"").find(c) != std::string_view::npos ? '_' : c;
  return out;
}

/// Reads the files that the steps of the sweep name, so that they are among the inputs of the run.
void read_named_files(const SpecVariants& variants, const SweepGrid& grid) {
  std::vector<std::size_t> steps(grid.axes().size());
  for (std::size_t a = 0; a < steps.size(); ++a) {
    const SweepAxis& axis = grid.axes()[a];
    if (std::ranges::none_of(axis.keys, spec_format::may_name_a_file)) continue;
    for (steps[a] = 0; steps[a] < axis.steps.size(); ++steps[a])
      grid.readable(variants, steps);  // where it is not, the variant's rows say what is wrong
    steps[a] = 0;
  }
}

void add_files(const std::string& spec, Entries& entries) {
  Entries files;
  for (const RunInput& input : run_inputs())
    if (input.path != spec)
      files.emplace_back(input.role == "pipe"
                             ? input.role
                             : input.role + ' ' + plain(std::filesystem::path(input.path).filename()),
                         fingerprint_of_file(input));
  std::ranges::sort(files);
  if (files.size() > most_files) {
    std::string all;
    for (const auto& [name, value] : files) all += name + value;
    files = {{"input files", fingerprint(sha256(all))}};
  }
  entries.insert(entries.end(), files.begin(), files.end());
}

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
    throw Error({path_, static_cast<int>(line), 0}, "", rule, found, remedy);
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

using std::chrono::steady_clock;

/// What is computed after the last note is computed once more: a fifth of a second. A disk keeps what was
/// written ten seconds before its power fails.
constexpr auto note_interval = std::chrono::milliseconds(200);
constexpr auto synchronization_interval = std::chrono::seconds(10);

constexpr const char* begin_anew_remedy = "repeat the run as it was, or leave out --resume to begin anew";

/// The note of a file: up to which byte it was written, the sum of these bytes, the counts, and the record.
struct FileNote {
  std::uint64_t size = 0;
  std::string sum;
  SweepCounts counts;
  RunRecord record;
};

std::string text_of(const FileNote& note) {
  std::string text = "1 ";  // version of this form
  for (const std::uint64_t number :
       {note.size, note.counts.variants, note.counts.failed, note.counts.unmet, note.counts.unjudged})
    text += std::to_string(number) + ' ';
  return text + note.sum + ' ' + note.record.text();
}

std::optional<FileNote> note_of(std::string_view text) {
  const auto next = [&] {
    const std::string_view word = text.substr(0, text.find(' '));
    text.remove_prefix(std::min(text.size(), word.size() + 1));
    return word;
  };
  if (next() != "1") return std::nullopt;
  FileNote note;
  for (std::uint64_t* number :
       {&note.size, &note.counts.variants, &note.counts.failed, &note.counts.unmet, &note.counts.unjudged}) {
    const std::string_view word = next();
    if (std::from_chars(word.data(), word.data() + word.size(), *number).ec != std::errc{})
      return std::nullopt;
  }
  note.sum = next();
  note.record = RunRecord(text);
  return note;
}

}  // namespace

RunRecord::RunRecord(const SpecVariants& variants, const SweepGrid& grid,
                     const std::vector<std::pair<std::string, std::string>>& options) {
  read_named_files(variants, grid);
  entries_ = {{"version of qerr", plain(std::string(version()))},
              {"spec", fingerprint(variants.base().sha256)},
              {"variants", std::to_string(grid.count())}};
  for (const auto& [name, value] : options)
    entries_.emplace_back("option " + name, fingerprint(sha256(value)));
  add_files(variants.base().file, entries_);
  std::ranges::sort(entries_);
}

RunRecord::RunRecord(std::string_view text) {
  while (!text.empty()) {
    const std::string_view entry = text.substr(0, text.find("; "));
    text.remove_prefix(std::min(text.size(), entry.size() + 2));
    const std::size_t equals = entry.rfind('=');
    if (equals == std::string_view::npos) continue;
    entries_.emplace_back(entry.substr(0, equals), entry.substr(equals + 1));
  }
}

std::string RunRecord::text() const {
  return joined(entries_, "; ", [](const auto& entry) { return entry.first + '=' + entry.second; });
}

std::string RunRecord::difference(const RunRecord& other) const {
  Entries different;
  std::set_symmetric_difference(entries_.begin(), entries_.end(), other.entries_.begin(),
                                other.entries_.end(), std::back_inserter(different));
  std::string names;
  std::string last;
  for (const auto& [name, value] : different)
    // The number of variants follows from the others.
    if (name != std::exchange(last, name) && name != "variants")
      names += (names.empty() ? "the " : ", the ") + name;
  return names;
}

std::string RunRecord::value(std::string_view wanted) const {
  for (const auto& [name, value] : entries_)
    if (name == wanted) return value;
  return {};
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

ShardFile::ShardFile(const std::string& path, const std::string& option, std::string header,
                     const RunRecord& record, bool marked, bool keep)
    : file_(path, option, keep), header_(std::move(header)), record_(record), marked_(marked) {
  if (!keep || !file_.regular()) begin_anew();
}

void ShardFile::begin_anew() {
  if (file_.regular()) file_.cut(0);
  put(header_);
  store_note({});
}

SweepCounts ShardFile::resume(bool judged) {
  if (!file_.regular()) return {};
  const std::string first = header_ + std::string(csv_line_break), begin = file_.read(0, first.size());
  if (first.starts_with(begin) && begin.size() < first.size()) {
    begin_anew();  // nothing of it is whole
    return {};
  }
  return counts_ = marked_ ? resume_marked(judged) : resume_noted(judged);
}

void ShardFile::refuse(const std::string& rule, const std::string& found, std::uint64_t line,
                       const std::string& remedy) const {
  throw Error({file_.path(), static_cast<int>(line), 0}, "--resume", rule, found, remedy);
}

void ShardFile::refuse_other(const RunRecord& held) const {
  if (const std::string changed = held.difference(record_); !changed.empty())
    refuse("the file was begun with other inputs than this sweep has", "changed: " + changed, 0,
           begin_anew_remedy);
}

SweepCounts ShardFile::resume_marked(bool judged) {
  SweepCounts kept;
  ShardLines lines([&](std::uint64_t from, std::size_t most) { return file_.read(from, most); });
  const std::optional<ShardHeader>& header = lines.read_header();
  if (!header) refuse("the file is no shard of qerr sweep", "", 1, begin_anew_remedy);
  refuse_other(header->record);
  if (header->columns + ',' + header->mark != header_)
    refuse("the file is another shard", header->mark.substr(0, header->mark.find(';')), 1, begin_anew_remedy);
  std::uint64_t end = header_.size();
  while (lines.next()) {
    replaces_ = !lines.whole() && lines.ended();
    if (!lines.whole() || (judged && lines.verdict() == 'u')) break;
    count_verdict(kept, lines.verdict());
    end = lines.end();
  }
  file_.cut(end);
  return kept;
}

SweepCounts ShardFile::resume_noted(bool judged) {
  const std::optional<FileNote> note = note_of(file_.note());
  if (note) refuse_other(note->record);
  if (!file_.read(0, header_.size() + csv_line_break.size())
           .starts_with(header_ + std::string(csv_line_break)))
    refuse("the file has other columns than this sweep, or is none of qerr sweep", "", 1, begin_anew_remedy);
  unknown_ = !note;
  if (note && !(judged && note->counts.unjudged > 0)) {
    constexpr std::uint64_t block = std::uint64_t{1} << 18;
    Sha256 sum;
    std::uint64_t size = 0;
    while (size < note->size) {
      const std::string text = file_.read(size, std::min(block, note->size - size));
      if (text.empty()) break;
      sum.add(text);
      size += text.size();
    }
    if (size == note->size && sum.digest() == note->sum) {
      sum_ = sum;
      size_ = size;
      file_.cut(size);
      return note->counts;
    }
    replaces_ = size == note->size;
  }
  begin_anew();
  return {};
}

void ShardFile::put(std::string_view text) {
  if (!marked_ && file_.regular()) sum_.add(text);
  size_ += text.size();
  file_.write(text);
}

void ShardFile::write(std::string_view lines, const SweepCounts& counts) {
  if (lines.empty()) return;
  lines.remove_suffix(csv_line_break.size());
  put(std::string(csv_line_break).append(lines));
  if (steady_clock::now() - noted_ > note_interval) store_note(counts);
  counts_ = counts;
}

void ShardFile::store_note(const SweepCounts& counts) {
  const auto now = steady_clock::now();
  if (now - synchronized_ > synchronization_interval) {
    if (synchronized_ != steady_clock::time_point{}) file_.synchronize();
    synchronized_ = now;
  }
  noted_ = now;
  if (!marked_) file_.set_note(text_of({size_, sum_.digest(), counts, record_}));
}

void ShardFile::close() {
  // The note is that of a file that goes on: without its last line break.
  const std::string note = text_of({size_, sum_.digest(), counts_, record_});
  put(csv_line_break);
  if (!marked_) file_.set_note(note);
  file_.close();
}

}  // namespace qerr
