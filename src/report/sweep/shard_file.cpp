#include <algorithm>
#include <charconv>

#include "qerr/core/error.hpp"
#include "report/sweep/shards.hpp"

namespace qerr {

namespace {

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
