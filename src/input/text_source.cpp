#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <optional>
#include <system_error>

#include "core/run_files.hpp"
#include "core/text.hpp"
#include "input/csv.hpp"
#include "input/log_table.hpp"

namespace qerr {

namespace {

[[noreturn]] void unreadable(const std::string& path, const std::string& rule,
                             const std::string& remedy = {}) {
  throw Error({path}, "", rule, "", remedy, Trouble::file_system);
}

std::string reason(int code) { return std::generic_category().message(code); }

int open_input(const std::string& path) {
  note_input(path);
  if (path == "-") return STDIN_FILENO;
  if (path.empty()) unreadable(path, "the name of a file is empty", "is a variable of the shell not set?");
  if (path.find('\0') != std::string::npos) unreadable(path, "a file name cannot contain a NUL byte");
  struct stat status {};
  // Checked before opening: opening a device can act on it or block.
  if (::stat(path.c_str(), &status) != 0) unreadable(path, "cannot be opened: " + reason(errno));
  if (S_ISDIR(status.st_mode)) unreadable(path, "is a directory", "name a file in it");
  if (!S_ISREG(status.st_mode) && !S_ISFIFO(status.st_mode))
    unreadable(path, "must be a regular file or a pipe");
  const int descriptor = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor < 0) unreadable(path, "cannot be opened: " + reason(errno));
  return descriptor;
}

constexpr std::size_t most_bytes = 16'000'000;

constexpr std::size_t most_lines = 60;  // that decide; a table of other lines is none of these

bool begins_name(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_'; }
bool is_label_character(char c) {
  return begins_name(c) || (c >= '0' && c <= '9') || c == '.' || c == '-' || c == '/' || c == '[' || c == ']';
}

struct Label {
  std::size_t begin, end;  ///< in the line, the mark behind it included
  std::string_view name;
};

/// The next `name=`, `name:` or `"name":` at or behind `at`.
std::optional<Label> next_label(std::string_view line, std::size_t at) {
  for (; at < line.size(); ++at) {
    const bool quoted = line[at] == '"';
    const std::size_t begin = at + quoted;
    if (begin >= line.size() || !begins_name(line[begin]) || (at > 0 && is_label_character(line[at - 1])))
      continue;
    std::size_t end = begin;
    while (end < line.size() && (quoted ? line[end] != '"' : is_label_character(line[end]))) ++end;
    std::size_t mark = std::min(end + quoted, line.size());
    while (mark < line.size() && line[mark] == ' ') ++mark;
    if (mark < line.size() && (line[mark] == ':' || line[mark] == '='))
      return Label{at, mark + 1, line.substr(begin, end - begin)};
    at = end;
  }
  return std::nullopt;
}

std::vector<std::string> labels_of(std::string_view line) {
  std::vector<std::string> names;
  for (auto label = next_label(line, 0); label; label = next_label(line, label->end))
    names.emplace_back(label->name);
  return names;
}

bool is_framed(std::string_view line) {
  line = trimmed(line);
  return line.size() > 2 &&
         ((line.front() == '[' && line.back() == ']') || (line.front() == '(' && line.back() == ')') ||
          (line.front() == '|' && line.back() == '|'));
}

/// `|---|---:|`
bool is_rule(std::string_view line) {
  return line.find('-') != std::string_view::npos &&
         line.find_first_not_of("|-: \r\n") == std::string_view::npos;
}

constexpr std::size_t sample_bytes = 1 << 16;  // by which the encoding is recognized

/// Windows-1252 from 0x80 to 0x9F; five bytes that it leaves free are the control characters of Latin-1.
constexpr std::array<char16_t, 32> windows_1252{
    0x20AC, 0x81,   0x201A, 0x0192, 0x201E, 0x2026, 0x2020, 0x2021, 0x02C6, 0x2030, 0x0160,
    0x2039, 0x0152, 0x8D,   0x017D, 0x8F,   0x90,   0x2018, 0x2019, 0x201C, 0x201D, 0x2022,
    0x2013, 0x2014, 0x02DC, 0x2122, 0x0161, 0x203A, 0x0153, 0x9D,   0x017E, 0x0178};

void append_utf8(std::string& text, unsigned c) {
  const auto tail = [&](unsigned shift) { text += static_cast<char>(0x80 | ((c >> shift) & 0x3F)); };
  if (c < 0x80) {
    text += static_cast<char>(c);
  } else if (c < 0x800) {
    text += static_cast<char>(0xC0 | (c >> 6)), tail(0);
  } else if (c < 0x10000) {
    text += static_cast<char>(0xE0 | (c >> 12)), tail(6), tail(0);
  } else {
    text += static_cast<char>(0xF0 | (c >> 18)), tail(12), tail(6), tail(0);
  }
}

/// Whether the bytes are UTF-8, apart from a character that their end cuts off.
bool is_utf8(std::string_view bytes) {
  for (std::size_t i = 0; i < bytes.size();) {
    const std::size_t length = utf8_length(bytes, i);
    if (length == 0)
      return bytes.size() - i < 4 && static_cast<unsigned char>(bytes[i]) >= 0xC2 &&
             std::all_of(bytes.begin() + static_cast<std::ptrdiff_t>(i) + 1, bytes.end(),
                         [](char c) { return (static_cast<unsigned char>(c) & 0xC0) == 0x80; });
    i += length;
  }
  return true;
}

/// Where UTF-16 without a mark has the zeros of its ASCII: 1 in the second bytes, -1 in the first, 0 nowhere.
int zeros_of_utf16(std::string_view bytes) {
  const std::size_t pairs = std::min<std::size_t>(bytes.size() / 2, 64);
  std::size_t first = 0, second = 0;
  for (std::size_t i = 0; i < pairs; ++i) first += bytes[2 * i] == '\0', second += bytes[2 * i + 1] == '\0';
  const auto most = [&](std::size_t zeros, std::size_t others) {
    return 10 * zeros > 9 * pairs && others == 0;
  };
  return most(second, first) ? 1 : most(first, second) ? -1 : 0;
}

struct BinaryFormat {
  std::string_view magic, remedy;
};

constexpr std::string_view spreadsheet = "this is a zip archive or a spreadsheet: export it as CSV";
constexpr std::array binary_formats{
    BinaryFormat{"\x89MCAP0", "this is a bag: it can be a log only, by the name of its file"},
    BinaryFormat{"SQLite format 3",
                 "this is a database: a bag of rosbag2 can be a log only, by the name of its file"},
    BinaryFormat{"\x1F\x8B", "this is a gzip archive: unpack it, with gzip -d"},
    BinaryFormat{"\x28\xB5\x2F\xFD", "this is compressed by Zstandard: unpack it, with zstd -d"},
    BinaryFormat{"\x04\x22\x4D\x18", "this is compressed by LZ4: unpack it, with lz4 -d"},
    BinaryFormat{"\xFD"
                 "7zXZ",
                 "this is compressed by xz: unpack it, with xz -d"},
    BinaryFormat{"BZh", "this is compressed by bzip2: unpack it, with bzip2 -d"},
    BinaryFormat{"PK\x03\x04", spreadsheet},
    BinaryFormat{"\xD0\xCF\x11\xE0", "this is a spreadsheet (.xls): export it as CSV"},
    BinaryFormat{"#ROSBAG V2.0",
                 "this is a bag of ROS 1: `mcap convert log.bag log.mcap` makes a file that is read"},
    BinaryFormat{"MATLAB 7.3 MAT",
                 "this is a file of MATLAB 7.3: export it there, with writetable(array2table([t q r], "
                 "'VariableNames', {'time', 'JOINT.measured', 'JOINT.reference'}), 'log.csv')"},
    BinaryFormat{"MATLAB 5.0 MAT",
                 "this is a file of MATLAB: export it there, with writetable(array2table([t q r], "
                 "'VariableNames', {'time', 'JOINT.measured', 'JOINT.reference'}), 'log.csv')"},
    BinaryFormat{"\x89HDF\r\n\x1A\n",
                 "this is an HDF5 file: export its columns as CSV, as with Python's h5py and pandas: "
                 "pandas.DataFrame({'time': f['t'][:], ...}).to_csv('log.csv', index=False)"},
    BinaryFormat{"PAR1",
                 "this is a Parquet file: export it as CSV, with Python: "
                 "pandas.read_parquet('log.parquet').to_csv('log.csv', index=False)"},
    BinaryFormat{"ARROW1",
                 "this is an Arrow file: export it as CSV, with Python: "
                 "pandas.read_feather('log.feather').to_csv('log.csv', index=False)"},
    BinaryFormat{"\x93NUMPY",
                 "this is an array of NumPy: export it as CSV, with numpy.savetxt('log.csv', "
                 "numpy.load('log.npy'), delimiter=',', header='time,...', comments='')"},
    BinaryFormat{"[{", "this is a list of JSON: write an object a line, with jq -c '.[]' log.json"},
    BinaryFormat{"ULog\x01\x12\x35", "this is a log of PX4: ulog2csv of pyulog makes CSV files"},
    BinaryFormat{"TDSm", "this is a TDMS file of LabVIEW: export it as CSV, as with Python's nptdms"},
    BinaryFormat{"MDF     ", "this is a measurement file (MDF): export it as CSV, as with Python's asammdf"},
};

/// Remedy for a file that begins like a known binary format: what exports it as a text; "" for any other.
std::string binary_format(std::string_view head) {
  for (const BinaryFormat& f : binary_formats)
    if (head.starts_with(f.magic)) return std::string(f.remedy);
  return {};
}

}  // namespace

ByteSource::ByteSource(const std::string& path)
    : name_(path == "-" ? "(standard input)" : path), descriptor_(open_input(path)) {
  struct stat status {};
  regular_ = fstat(descriptor_, &status) == 0 && S_ISREG(status.st_mode);
  // Standard input may begin within its file, as behind `head` in a shell's brackets.
  const off_t begin = regular_ ? lseek(descriptor_, 0, SEEK_CUR) : -1;
  if (begin >= 0 && begin < status.st_size) size_ = static_cast<std::uint64_t>(status.st_size - begin);
}

ByteSource::~ByteSource() {
  if (descriptor_ > STDIN_FILENO) ::close(descriptor_);  // standard input stays open
}

std::size_t ByteSource::read(char* buffer, std::size_t most) {
  while (true) {
    const ssize_t count = ::read(descriptor_, buffer, most);
    if (count == 0 && most > 0 && position_ < size_)
      unreadable(name_, "became shorter while it was read", "repeat this when the file is whole");
    if (count >= 0) {
      position_ += static_cast<std::uint64_t>(count);
      return static_cast<std::size_t>(count);
    }
    if (errno != EINTR) unreadable(name_, "cannot be read: " + reason(errno));
  }
}

Place place_of_byte(const std::string& text, std::size_t byte, const std::string& file) {
  Place place{file, 1, 1};
  for (std::size_t i = 0; i < byte; ++i) {
    if (text[i] == '\n') {
      ++place.line;
      place.column = 1;
    } else if ((static_cast<unsigned char>(text[i]) & 0xC0u) != 0x80u) {
      ++place.column;
    }
  }
  return place;
}

std::string read_text(const std::string& path) {
  if (auto text = piped_text(path)) return *text;
  ByteSource source(path);
  const std::string& file = source.name();
  std::string text;
  char block[65536];
  while (const std::size_t count = source.read(block, sizeof block)) {
    text.append(block, count);
    if (text.size() > most_bytes)
      throw Error({file, 1, 1}, "", "an input document must have at most 16 MB", "more", "");
  }
  check_text(text, file);
  if (text.starts_with("\xEF\xBB\xBF")) text.erase(0, 3);
  if (!source.regular()) keep_piped(path, text);
  return text;
}

void check_text(const std::string& text, const std::string& file) {
  if (text.size() > most_bytes)
    throw Error({file, 1, 1}, "", "an input document must have at most 16 MB", "more", "");
  const bool utf16 = text.starts_with("\xFF\xFE") || text.starts_with("\xFE\xFF");
  for (std::size_t i = 0; i < text.size();) {
    const std::size_t length = utf8_length(text, i);
    if (length == 0) {
      throw Error(place_of_byte(text, i, file), "", "the text must be UTF-8",
                  "byte 0x" + hexadecimal(static_cast<unsigned char>(text[i])),
                  utf16 ? "this looks like UTF-16: save the file as UTF-8" : "save the file as UTF-8");
    }
    if (text[i] == '\0') {
      throw Error(place_of_byte(text, i, file), "", "the text must not contain a NUL byte", "",
                  "is this a text file?");
    }
    i += length;
  }
}

LineLayout::LineLayout(std::string_view head) {
  returns_ = head.find('\n') == std::string_view::npos && std::count(head.begin(), head.end(), '\r') > 1;
  std::vector<std::string_view> lines;
  for (std::size_t at = 0; at < head.size() && lines.size() < most_lines;) {
    const std::size_t end = head.find(line_end(), at);
    if (end == std::string_view::npos) break;  // cut off
    if (const std::string_view line = trimmed(head.substr(at, end - at)); !line.empty() && line[0] != '#')
      lines.push_back(line);
    at = end + 1;
  }
  if (lines.size() < 2) return;
  const auto all = [&](auto&& holds) { return std::all_of(lines.begin(), lines.end(), holds); };
  std::vector<std::string> labels = labels_of(lines.front());
  if (labels.size() > 1 && all([&](std::string_view line) { return labels_of(line) == labels; }))
    labels_ = std::move(labels);
  else
    framed_ = all(is_framed);
  const auto arrow_at = [](std::string_view line) { return line.find("->"); };
  if (all([&](std::string_view line) { return arrow_at(line) != std::string_view::npos; })) {
    const std::string_view cells = lines.back().substr(arrow_at(lines.back()) + 2);
    arrow_ = ' ';
    for (const char mark : {',', ';', '\t'})
      if (cells.find(mark) != std::string_view::npos) arrow_ = mark;
    // The monitor's stamps, beside those of the board.
    const bool own = std::any_of(labels_.begin(), labels_.end(), is_time_name);
    if (!labels_.empty()) labels_.insert(labels_.begin(), own ? "received" : "timestamp");
  }
}

std::string LineLayout::description() const {
  std::string text = returns_ ? "lines end with carriage returns" : "";
  const auto add = [&](const std::string& part) { text += (text.empty() ? "" : ", ") + part; };
  if (!labels_.empty()) add("a label before each value");
  if (framed_) add("rows between brackets or pipes");
  if (arrow_ != '\0') add("stamps before ->");
  return text;
}

void LineLayout::make_plain(char* begin, char* end) const {
  if (returns_) std::replace(begin, end, '\r', '\n');
  const std::string_view line(begin, static_cast<std::size_t>(end - begin));
  if (arrow_ != '\0')
    if (const std::size_t at = line.find("->"); at != std::string_view::npos)
      begin[at] = ' ', begin[at + 1] = arrow_;
  for (auto label = labels_.empty() ? std::nullopt : next_label(line, 0); label;
       label = next_label(line, label->end))
    std::fill(begin + label->begin, begin + label->end, ' ');
  if (!labels_.empty())
    for (char* p = begin; p != end; ++p)
      if (*p == '{' || *p == '}') *p = ' ';
  if (!framed_) return;
  if (is_rule(line)) {
    std::replace_if(
        begin, end, [](char c) { return c != '\n'; }, ' ');
    return;
  }
  const std::string_view inner = trimmed(line);
  if (inner.size() < 2) return;
  char *const first = begin + (inner.data() - line.data()), *const last = first + inner.size() - 1;
  if (*first == '|') std::replace(first + 1, last, '|', ';');
  *first = *last = ' ';
}

TextSource::TextSource(const std::string& path, bool recognize) : source_(path), recognize_(recognize) {}

std::string_view TextSource::encoding() const {
  return encoding_ == Encoding::utf8 ? "" : encoding_ == Encoding::windows_1252 ? "Windows-1252" : "UTF-16";
}

/// Reads more behind the bytes that are left. @returns false at the end
bool TextSource::refill() {
  bytes_.erase(0, at_);
  at_ = 0;
  const std::size_t left = bytes_.size();
  bytes_.resize(left + sample_bytes);
  const std::size_t count = source_.read(bytes_.data() + left, sample_bytes);
  bytes_.resize(left + count);
  ended_ = count == 0;
  return !ended_;
}

void TextSource::recognize_encoding() {
  begun_ = true;
  while (bytes_.size() < (recognize_ ? sample_bytes : 16) && refill()) {
  }
  const std::string why = binary_format(bytes_);
  if (!why.empty()) throw Error({source_.name(), 1, 1}, "", "the table must be a text", "", why);
  const bool little = bytes_.starts_with("\xFF\xFE"), big = bytes_.starts_with("\xFE\xFF");
  if ((little || big) && !recognize_)
    throw Error({source_.name(), 1, 1}, "", "the table must be UTF-8 text", "",
                "this looks like UTF-16: save the file as UTF-8");
  if (!recognize_) return;
  if (little || big) {
    encoding_ = little ? Encoding::utf16_little : Encoding::utf16_big;
    at_ = 2;
  } else if (const int zeros = zeros_of_utf16(bytes_); zeros != 0) {
    encoding_ = zeros > 0 ? Encoding::utf16_little : Encoding::utf16_big;
  } else if (!is_utf8(bytes_) && bytes_.find('\0') == std::string::npos) {
    encoding_ = Encoding::windows_1252;
  }
}

/// Appends the character at byte `at`. @returns the bytes that it takes; 0 if it is not complete
std::size_t TextSource::decoded(std::size_t at, std::string& utf8) const {
  const auto byte = [&](std::size_t i) {
    return static_cast<unsigned>(static_cast<unsigned char>(bytes_[i]));
  };
  if (encoding_ == Encoding::windows_1252) {
    const unsigned c = byte(at);
    append_utf8(utf8, c >= 0x80 && c < 0xA0 ? windows_1252[c - 0x80] : c);
    return 1;
  }
  const bool little = encoding_ == Encoding::utf16_little;
  const auto unit = [&](std::size_t i) {
    return little ? byte(i) | byte(i + 1) << 8 : byte(i + 1) | byte(i) << 8;
  };
  const auto is_low = [](unsigned u) { return u >= 0xDC00 && u < 0xE000; };
  constexpr unsigned replacement = 0xFFFD;
  if (at + 2 > bytes_.size()) return ended_ ? (append_utf8(utf8, replacement), 1) : 0;
  const unsigned first = unit(at);
  const bool high = first >= 0xD800 && first < 0xDC00;
  if (high && at + 4 > bytes_.size() && !ended_) return 0;
  const bool pair = high && at + 4 <= bytes_.size() && is_low(unit(at + 2));
  append_utf8(utf8, pair                    ? 0x10000 + ((first - 0xD800) << 10) + (unit(at + 2) - 0xDC00)
                    : high || is_low(first) ? replacement
                                            : first);
  return pair ? 4 : 2;
}

std::size_t TextSource::read_text(char* buffer, std::size_t most) {
  if (encoding_ == Encoding::utf8) {
    if (at_ == bytes_.size()) return source_.read(buffer, most);
    const std::size_t count = std::min(most, bytes_.size() - at_);
    std::memcpy(buffer, bytes_.data() + at_, count);
    at_ += count;
    return count;
  }
  std::string text;
  while (text.size() + 4 <= most) {
    const std::size_t taken = at_ < bytes_.size() ? decoded(at_, text) : 0;
    at_ += taken;
    if (taken == 0 && (!text.empty() || !refill())) break;
  }
  std::memcpy(buffer, text.data(), text.size());
  return text.size();
}

/// Reads whole lines, and makes them plain.
std::size_t TextSource::read_lines(char* buffer, std::size_t most) {
  while (passed_ == plain_ && !(text_ended_ && plain_ == text_.size())) {
    text_.erase(0, passed_);
    passed_ = plain_ = 0;
    if (!text_ended_) {
      const std::size_t left = text_.size();
      text_.resize(left + sample_bytes);
      const std::size_t count = read_text(text_.data() + left, sample_bytes);
      text_.resize(left + count);
      text_ended_ = count == 0;
    }
    for (std::size_t end = 0; plain_ < text_.size(); plain_ = end) {
      const std::size_t found = text_.find(layout_.line_end(), plain_);
      if (found == std::string::npos && !text_ended_) break;
      end = found == std::string::npos ? text_.size() : found + 1;
      layout_.make_plain(text_.data() + plain_, text_.data() + end);
    }
  }
  const std::size_t count = std::min(most, plain_ - passed_);
  std::memcpy(buffer, text_.data() + passed_, count);
  passed_ += count;
  return count;
}

std::size_t TextSource::read(char* buffer, std::size_t most) {
  if (!begun_) {
    recognize_encoding();
    if (recognize_) {
      text_.resize(sample_bytes);
      text_.resize(read_text(text_.data(), sample_bytes));
      layout_ = LineLayout(text_.starts_with("\xEF\xBB\xBF") ? std::string_view(text_).substr(3) : text_);
      plain_ = layout_.is_plain() ? text_.size() : 0;
    }
  }
  if (!layout_.is_plain() || passed_ < plain_) return read_lines(buffer, most);
  return read_text(buffer, most);
}

}  // namespace qerr
