#include "report/sweep/run_record.hpp"

#include <algorithm>
#include <filesystem>

#include "core/run_files.hpp"
#include "core/sha256.hpp"
#include "input/byte_source.hpp"
#include "input/spec_format.hpp"
#include "qerr/core/error.hpp"
#include "qerr/report/write.hpp"

namespace qerr {

namespace {

using Entries = std::vector<std::pair<std::string, std::string>>;

/// A record must fit into the extended attribute of a file, of which 4 KB are common: that many names of
/// files of at most that many bytes; more are one entry.
constexpr std::size_t most_files = 24, longest_name = 60;

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
  for (const char c : text.substr(0, longest_name))
    out += c < ' ' || c > '~' || std::string_view(",;=\"").find(c) != std::string_view::npos ? '_' : c;
  return out;
}

/// Reads the files that the steps of the sweep name, so that they are among the inputs of the run.
void read_named_files(const SpecVariants& variants, const SweepGrid& grid) {
  std::vector<std::size_t> steps(grid.axes().size());
  for (std::size_t a = 0; a < steps.size(); ++a) {
    const SweepAxis& axis = grid.axes()[a];
    if (std::none_of(axis.keys.begin(), axis.keys.end(), spec_format::may_name_a_file)) continue;
    for (steps[a] = 0; steps[a] < axis.steps.size(); ++steps[a]) try {
        grid.spec(variants, steps);
      } catch (const Error& e) {
        if (e.trouble() != Trouble::input) throw;  // the variant's rows say what is wrong
      }
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
  std::sort(files.begin(), files.end());
  if (files.size() > most_files) {
    std::string all;
    for (const auto& [name, value] : files) all += name + value;
    files = {{"input files", fingerprint(sha256(all))}};
  }
  entries.insert(entries.end(), files.begin(), files.end());
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
  std::sort(entries_.begin(), entries_.end());
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
  std::string text;
  for (const auto& [name, value] : entries_) text += (text.empty() ? "" : "; ") + name + '=' + value;
  return text;
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

}  // namespace qerr
