#include <cerrno>
#include <cstdio>
#include <cstring>
#include <optional>

#include "cli/command.hpp"
#include "cli/sweep_parts.hpp"
#include "core/run_files.hpp"
#include "input/byte_source.hpp"
#include "report/sweep/shards.hpp"

namespace qerr::cli {

namespace {

/// The record of the sweep of a spec.
RunRecord record_of_spec(const std::string& path, const Values& v) {
  const SpecVariants variants(read_text(path), path, overrides(v));
  refuse_varied(variants.base(), overrides(v));
  const SweepGrid grid(variants.base());
  return record_of({.variants = variants, .grid = grid, .statistics = {}, .text = {}}, v);
}

/// What is not to be written before it is whole: an error leaves nothing on standard output.
class Spool {
 public:
  Spool() : file_(std::tmpfile()) {
    if (!file_) fail();
  }
  Spool(const Spool&) = delete;
  Spool& operator=(const Spool&) = delete;
  ~Spool() { std::fclose(file_); }

  void write(const std::string& text) {
    if (std::fwrite(text.data(), 1, text.size(), file_) != text.size()) fail();
  }
  void copy_to(OutputFile& out) {
    std::rewind(file_);
    std::string block(std::size_t{1} << 16, '\0');
    while (const std::size_t count = std::fread(block.data(), 1, block.size(), file_))
      out.write(std::string_view(block).substr(0, count));
    if (std::ferror(file_) != 0) fail();
  }

 private:
  [[noreturn]] static void fail() {
    throw Error(Fault{{"temporary file"},
                      "",
                      std::string("cannot be written: ") + std::strerror(errno),
                      "",
                      "name the output: -o FILE.csv"},
                Trouble::file_system);
  }

  std::FILE* file_;
};

int run(const Values& v) {
  std::vector<std::string> files = v.texts("FILE");
  if (v.given("spec")) files.push_back(v.text("spec"));
  refuse_shared_input(files, "FILE");
  std::optional<RunRecord> expected;
  if (v.given("spec")) expected = record_of_spec(v.text("spec"), v);
  for (const std::string& file : v.texts("FILE")) note_input(file);
  OutputFile out(v.text("output"), "--output");
  std::optional<Spool> spool;
  if (v.text("output") == "-") spool.emplace();
  const SweepCounts counts =
      merge_shards(v.texts("FILE"), expected ? &*expected : nullptr,
                   [&](const std::string& text) { spool ? spool->write(text) : out.write(text); });
  if (spool) spool->copy_to(out);
  out.close();
  say_failed(counts);
  return 0;
}

/// The options of sweep on which the rows depend; they say what the files should hold.
std::vector<Option> spec_comparison() {
  std::vector<Option> options = joined({spec_options(), sweep_row_options()});
  options.front() = {.name = "--spec",
                     .value = "SPEC",
                     .meaning = "refuse shards of another spec, other files that it names, other options"};
  for (Option& option : options)
    if (option.name == "--set" || option.name == "--statistics" || option.name == "--wide")
      option.needs = "--spec";
  return options;
}

}  // namespace

Command merge_command() {
  return {
      "merge",
      "Join the files of the shards of a sweep: the bytes of one run",
      joined({{{.name = "FILE",
                .kind = OptionKind::repeat,
                .meaning = "a file of each shard, in any order",
                .required = true}},
              spec_comparison(),
              {text_output_option(".csv .txt")}}),
      run,
      {{"qerr merge 1.csv 2.csv 3.csv 4.csv 5.csv --spec arm.yaml -o sweep.csv", "one file of all variants"},
       {"qerr merge shards/*.csv --spec arm.yaml -o sweep.csv",
        "the same, and none of them is of another spec"}},
      {"variants"}};
}

}  // namespace qerr::cli
