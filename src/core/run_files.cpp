#include "core/run_files.hpp"

#include <sys/stat.h>
#include <sys/xattr.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <mutex>
#include <sstream>
#include <tuple>
#include <utility>

#include "qerr/core/error.hpp"

namespace qerr {

namespace {

using Words = std::array<std::uint32_t, 64>;

/// The first 32 bits of the fractional parts of the cube roots of the first 64 primes (FIPS 180-4, 4.2.2).
const Words& round_constants() {
  static const Words constants = [] {
    Words k{};
    std::size_t found = 0;
    for (std::uint32_t n = 2; found < k.size(); ++n) {
      bool prime = true;
      for (std::uint32_t d = 2; d * d <= n; ++d) prime = prime && n % d != 0;
      if (!prime) continue;
      // 35 bits suffice, since no root is close to a multiple of 2^-32.
      const long double root = std::cbrt(static_cast<long double>(n));
      k[found++] = static_cast<std::uint32_t>((root - std::floor(root)) * 0x1p32L);
    }
    return k;
  }();
  return constants;
}

void absorb(std::array<std::uint32_t, 8>& state, const unsigned char* block) {
  Words w{};
  for (std::size_t i = 0; i < 16; ++i)
    w[i] = std::uint32_t(block[4 * i]) << 24 | std::uint32_t(block[4 * i + 1]) << 16 |
           std::uint32_t(block[4 * i + 2]) << 8 | std::uint32_t(block[4 * i + 3]);
  for (std::size_t i = 16; i < 64; ++i) {
    const std::uint32_t s0 = std::rotr(w[i - 15], 7) ^ std::rotr(w[i - 15], 18) ^ (w[i - 15] >> 3);
    const std::uint32_t s1 = std::rotr(w[i - 2], 17) ^ std::rotr(w[i - 2], 19) ^ (w[i - 2] >> 10);
    w[i] = w[i - 16] + s0 + w[i - 7] + s1;
  }
  auto [a, b, c, d, e, f, g, h] = state;
  for (std::size_t i = 0; i < 64; ++i) {
    const std::uint32_t s1 = std::rotr(e, 6) ^ std::rotr(e, 11) ^ std::rotr(e, 25);
    const std::uint32_t t1 = h + s1 + ((e & f) ^ (~e & g)) + round_constants()[i] + w[i];
    const std::uint32_t s0 = std::rotr(a, 2) ^ std::rotr(a, 13) ^ std::rotr(a, 22);
    const std::uint32_t t2 = s0 + ((a & b) ^ (a & c) ^ (b & c));
    h = g, g = f, f = e, e = d + t1, d = c, c = b, b = a, a = t1 + t2;
  }
  const std::array<std::uint32_t, 8> change{a, b, c, d, e, f, g, h};
  for (std::size_t i = 0; i < 8; ++i) state[i] += change[i];
}

}  // namespace

void Sha256::add(std::string_view bytes) {
  size_ += bytes.size();
  constexpr std::size_t block = 64;
  const auto take = [&](std::string_view whole) {
    for (std::size_t at = 0; at + block <= whole.size(); at += block)
      absorb(state_, reinterpret_cast<const unsigned char*>(whole.data()) + at);
  };
  if (!rest_.empty()) {
    const std::size_t missing = std::min(block - rest_.size(), bytes.size());
    rest_.append(bytes.substr(0, missing));
    bytes.remove_prefix(missing);
    if (rest_.size() < block) return;
    take(rest_);
  }
  take(bytes);
  rest_ = bytes.substr(bytes.size() / block * block);
}

std::string Sha256::digest() const {
  Sha256 padded = *this;
  std::string end(1, '\x80');
  while ((rest_.size() + end.size()) % 64 != 56) end += '\0';
  for (int shift = 56; shift >= 0; shift -= 8) end += static_cast<char>(size_ * 8 >> shift & 0xFF);
  padded.add(end);
  std::string hex;
  for (const std::uint32_t word : padded.state_)
    for (int shift = 28; shift >= 0; shift -= 4) hex += "0123456789abcdef"[word >> shift & 0xF];
  return hex;
}

std::string sha256(std::string_view bytes) {
  Sha256 sum;
  sum.add(bytes);
  return sum.digest();
}

namespace {

/// Device and inode of a file, or those of its folder and its name in there.
using Identity = std::tuple<dev_t, ino_t, std::string>;

struct Noted {
  std::map<Identity, RunInput> inputs;
  std::map<Identity, std::string> outputs;   ///< with the names as given
  std::map<std::string, std::string> piped;  ///< texts by the names as given
  bool standard_output = false;
  bool replaces_specs = false;
};

std::mutex guard;
std::optional<Noted> noted;

std::optional<Identity> identity_of(const struct stat& status) {
  if (!S_ISREG(status.st_mode)) return {};
  return Identity{status.st_dev, status.st_ino, ""};
}

std::optional<Identity> identity_of(const std::string& path, int stream) {
  struct stat status {};
  if (path == "-") return fstat(stream, &status) == 0 ? identity_of(status) : std::nullopt;
  if (stat(path.c_str(), &status) == 0) return identity_of(status);
  const std::filesystem::path file(link_target(path));
  const std::string folder = file.has_parent_path() ? file.parent_path().string() : ".";
  if (stat(folder.c_str(), &status) != 0) return {};
  return Identity{status.st_dev, status.st_ino, file.filename().string()};
}

[[noreturn]] void refuse(const std::string& path, const std::string& option, const std::string& rule,
                         const std::string& other, const std::string& remedy) {
  const std::string found = other.empty() || other == path ? "" : "'" + other + "', which is the same file";
  throw Error({path}, option, rule, found, remedy, Trouble::usage);
}

constexpr const char* standard_input = "(standard input)";
constexpr const char* overwriting = "an output must not be an input of the same command";
constexpr const char* force_it = "name another file, or replace it with --force";
constexpr const char* rename_it = "give the output another name";

}  // namespace

std::string link_target(const std::string& path) {
  constexpr int most_links = 40;  // as the kernel's
  std::filesystem::path file(path);
  std::error_code none;
  for (int i = 0; i < most_links; ++i) {
    const std::filesystem::path target = std::filesystem::read_symlink(file, none);
    if (none) break;
    file = target.is_absolute() ? target : file.parent_path() / target;
  }
  return file.string();
}

namespace {

/// Whether a line of YAML begins with a key, or a mapping in braces.
bool begins_mapping(std::string_view line) {
  if (line.starts_with('{') || line == "---") return true;
  const std::size_t end = line.find_first_of(":\r");
  return end != std::string_view::npos && line[end] == ':' &&
         line.substr(0, end).find_first_not_of(
             "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-\"' ") ==
             std::string_view::npos;
}

/// Whether a file is a spec: it begins with a key, and a line of it with the key `qerr` and the version of
/// the format, which is a number; that of a JSON report is a text. Pages and help quote specs, and begin
/// otherwise.
bool is_spec(const std::string& path) {
  struct stat status {};
  if (stat(path.c_str(), &status) != 0 || !S_ISREG(status.st_mode)) return false;
  std::ifstream file(path, std::ios::binary);
  constexpr int most_lines = 100'000;
  int lines = 0;
  bool begun = false;
  for (std::string line; ++lines < most_lines && std::getline(file, line);) {
    const auto skip = [&](const char* characters) {
      line.erase(0, std::min(line.find_first_not_of(characters), line.size()));
    };
    if (lines == 1 && line.starts_with("\xef\xbb\xbf")) line.erase(0, 3);
    skip(" \t\r");
    if (line.empty() || line.starts_with('#')) continue;
    if (!begun && !begins_mapping(line)) return false;
    begun = true;
    skip("{\"' \t");
    if (!line.starts_with("qerr")) continue;
    line.erase(0, 4);
    skip(" \t\"'");
    if (!line.starts_with(':')) continue;
    line.erase(0, 1);
    skip(" \t");
    if (!line.empty() && line[0] >= '0' && line[0] <= '9') return true;
  }
  return false;
}

/// The begin of a file, where its kind is seen.
std::string begin_of(const std::string& path) {
  std::string begin(std::size_t{1} << 16, '\0');
  std::ifstream file(path, std::ios::binary);
  file.read(begin.data(), static_cast<std::streamsize>(begin.size()));
  begin.resize(file.gcount());
  if (begin.starts_with("\xef\xbb\xbf")) begin.erase(0, 3);
  return begin;
}

/// Whether a file is XML with an element `robot`. Pages escape what they quote.
bool is_urdf(const std::string& begin) {
  const std::size_t first = begin.find_first_not_of(" \t\r\n");
  return first != std::string::npos && begin[first] == '<' && begin.find("<robot") != std::string::npos;
}

/// Whether a file is a catalogue: its first line that is no comment has a column `name` in front, or beside
/// `price`. Of the tables of qerr only that of `list` begins with `name`; it has a column `parameter`.
bool is_catalogue(const std::string& begin) {
  std::istringstream lines(begin);
  std::string header;
  while (std::getline(lines, header) && (header.empty() || header.starts_with('#'))) {
  }
  std::vector<std::string> cells(1);
  for (const char c : header) {
    if (c == ',' || c == ';' || c == '\t')
      cells.emplace_back();
    else if (c != '"' && c != ' ' && c != '\r')
      cells.back() += c;
  }
  const auto has = [&](const std::string& name) {
    return std::ranges::any_of(
        cells, [&](const std::string& cell) { return cell == name || cell.starts_with(name + '['); });
  };
  return cells.size() > 1 && has("name") && !has("parameter") && (cells.front() == "name" || has("price"));
}

/// What a file is that a person may have written; "" if it is another one, or none.
std::string hand_written(const std::string& path) {
  struct stat status {};
  if (stat(path.c_str(), &status) != 0 || !S_ISREG(status.st_mode)) return "";
  if (is_spec(path)) return "a spec";
  const std::string begin = begin_of(path);
  return is_urdf(begin) ? "a URDF" : is_catalogue(begin) ? "a catalogue" : "";
}

constexpr const char* written_note = "user.qerr.written";

/// Of the bytes of a file.
std::string fingerprint_of(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  Sha256 sum;
  std::string block(std::size_t{1} << 16, '\0');
  while (file.read(block.data(), static_cast<std::streamsize>(block.size())), file.gcount() > 0)
    sum.add(std::string_view(block).substr(0, file.gcount()));
  return sum.digest();
}

bool is_as_written(const std::string& path) {
  std::string noted(64, '\0');
  return getxattr(path.c_str(), written_note, noted.data(), noted.size()) == 64 &&
         noted == fingerprint_of(path);
}

}  // namespace

void note_as_written(const std::string& path) {
  struct stat status {};
  if (path == "-" || stat(path.c_str(), &status) != 0 || !S_ISREG(status.st_mode)) return;
  const std::string sum = fingerprint_of(path);
  std::ignore = setxattr(path.c_str(), written_note, sum.data(), sum.size(), 0);
}

RunFiles::RunFiles() {
  const std::lock_guard lock(guard);
  noted.emplace();
}

RunFiles::~RunFiles() {
  const std::lock_guard lock(guard);
  noted.reset();
}

void permit_replacing_specs() {
  const std::lock_guard lock(guard);
  if (noted) noted->replaces_specs = true;
}

void note_input(const std::string& path) {
  const std::lock_guard lock(guard);
  const auto identity = noted ? identity_of(path, STDIN_FILENO) : std::nullopt;
  if (!identity) return;
  const std::string name = path == "-" ? standard_input : path;
  if (const auto output = noted->outputs.find(*identity); output != noted->outputs.end())
    refuse(output->second, "", overwriting, name, rename_it);
  noted->inputs.emplace(*identity, RunInput{name, "file"});
}

void name_input(const std::string& path, const std::string& role) {
  const std::lock_guard lock(guard);
  const auto identity = noted ? identity_of(path, STDIN_FILENO) : std::nullopt;
  if (!identity) return;
  if (const auto input = noted->inputs.find(*identity); input != noted->inputs.end())
    input->second.role = role;
}

std::vector<RunInput> run_inputs() {
  const std::lock_guard lock(guard);
  std::vector<RunInput> all;
  if (!noted) return all;
  for (const auto& [identity, input] : noted->inputs)
    if (input.path != standard_input) all.push_back(input);
  for (const auto& [path, text] : noted->piped)
    if (path != "-") all.push_back({path, "pipe"});
  return all;
}

std::optional<std::string> piped_text(const std::string& path) {
  const std::lock_guard lock(guard);
  if (!noted) return {};
  const auto text = noted->piped.find(path);
  return text == noted->piped.end() ? std::nullopt : std::optional(text->second);
}

void keep_piped(const std::string& path, const std::string& text) {
  const std::lock_guard lock(guard);
  if (noted) noted->piped[path] = text;
}

void note_output(const std::string& path, const std::string& option) {
  const std::lock_guard lock(guard);
  if (!noted) return;
  const std::string name = path == "-" ? "standard output" : path;
  if (path == "-" && std::exchange(noted->standard_output, true))
    refuse(name, option, "only one result can go to standard output", "",
           "name a file for the others, such as -o FILE");
  const auto identity = identity_of(path, STDOUT_FILENO);
  if (!identity) return;
  if (const auto input = noted->inputs.find(*identity); input != noted->inputs.end())
    refuse(name, option, overwriting, input->second.path, rename_it);
  const auto [other, is_new] = noted->outputs.emplace(*identity, name);
  if (!is_new)
    refuse(name, option, "two outputs must not be one file", other->second, "give each its own name");
  if (path == "-" || noted->replaces_specs || (option.starts_with("--write-") && is_as_written(path))) return;
  if (const std::string kind = hand_written(path); !kind.empty())
    refuse(name, option, "this file is " + kind + ", which a person may have edited", "", force_it);
  struct stat status {};
  if ((option == "--write-spec" || option == "--write-model") && stat(path.c_str(), &status) == 0 &&
      S_ISREG(status.st_mode) && status.st_size > 0)
    refuse(name, option, "this file exists, and is none that qerr has written", "", force_it);
}

}  // namespace qerr
