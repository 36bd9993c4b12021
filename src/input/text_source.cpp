#include "input/text_source.hpp"

#include <algorithm>
#include <array>
#include <cstring>

#include "core/text.hpp"
#include "qerr/core/error.hpp"

namespace qerr {

namespace {

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
    BinaryFormat{"ULog\x01\x12\x35", "this is a log of PX4: ulog2csv of pyulog makes CSV files"},
    BinaryFormat{"TDSm", "this is a TDMS file of LabVIEW: export it as CSV, as with Python's nptdms"},
    BinaryFormat{"MDF     ", "this is a measurement file (MDF): export it as CSV, as with Python's asammdf"},
};

}  // namespace

std::string binary_format(std::string_view head) {
  for (const BinaryFormat& f : binary_formats)
    if (head.starts_with(f.magic)) return std::string(f.remedy);
  return {};
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
  if (!why.empty()) throw Error({{source_.name(), 1, 1}, "", "the table must be a text", "", why});
  const bool little = bytes_.starts_with("\xFF\xFE"), big = bytes_.starts_with("\xFE\xFF");
  if ((little || big) && !recognize_)
    throw Error({{source_.name(), 1, 1},
                 "",
                 "the table must be UTF-8 text",
                 "",
                 "this looks like UTF-16: save the file as UTF-8"});
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
