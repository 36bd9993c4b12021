#include "report/sweep/merge.hpp"

#include <algorithm>
#include <optional>

#include "cli/command.hpp"
#include "cli/sweep_parts.hpp"
#include "core/run_files.hpp"
#include "input/read_text.hpp"

namespace qerr::cli {

namespace {

/// The sweep of a spec, of which merge computes single variants.
struct SpecSweep {
  SpecVariants variants;
  SweepGrid grid;
  std::optional<SweepRun> run;
  ExpectedSweep expected;

  SpecSweep(const std::string& path, const Values& v)
      : variants(read_text(path), path, overrides(v)), grid(variants.base()) {
    SweepJob job{.variants = variants,
                 .grid = grid,
                 .statistics = chosen_statistics(v),
                 .threads = threads(v),
                 .text = {}};
    expected.header = chosen_rows(job, v).header;
    run.emplace(std::move(job));
    expected.count = grid.count();
    expected.cells = [this](std::uint64_t variant) { return cells_of_variant(grid, variant); };
    expected.lines = [this](std::uint64_t variant) { return run->text(variant); };
  }
  SpecSweep(const SpecSweep&) = delete;
  SpecSweep& operator=(const SpecSweep&) = delete;
};

int run(const Values& v) {
  const std::vector<std::string>& files = v.texts("FILE");
  refuse_shared_input(files, "FILE");
  std::optional<SpecSweep> spec;
  if (v.given("spec")) spec.emplace(v.text("spec"), v);
  const ExpectedSweep* const expected = spec ? &spec->expected : nullptr;
  // An error leaves nothing on standard output: there the files are read once before, to check them.
  const bool pipes = std::find(files.begin(), files.end(), "-") != files.end();
  if (v.text("output") == "-" && !pipes) merge_shards(files, expected, [](const std::string&) {});
  for (const std::string& file : files) note_input(file);
  OutputFile out(v.text("output"), "--output");
  merge_shards(files, expected, [&](const std::string& text) { out.write(text); });
  out.close();
  return 0;
}

/// The options of sweep on which the rows depend; they say what the files should hold.
std::vector<Option> spec_comparison() {
  std::vector<Option> options = joined({spec_options(), sweep_row_options()});
  options.front() = {.name = "--spec",
                     .value = "SPEC",
                     .meaning = "compare values and some figures with the sweep of this spec"};
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
              {text_output_option()}}),
      run,
      {{"qerr merge 1.csv 2.csv 3.csv 4.csv 5.csv --spec arm.yaml -o sweep.csv", "one file of all variants"},
       {"qerr merge shards/*.csv --spec arm.yaml -o sweep.csv",
        "the same, and none of them is of another spec"}},
      {"variants"}};
}

}  // namespace qerr::cli
