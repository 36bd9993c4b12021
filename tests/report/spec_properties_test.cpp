#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>

#include "qerr/report/analysis.hpp"
#include "qerr/report/write.hpp"
#include "report/analysis/figures.hpp"
#include "report/sweep/sweep.hpp"
#include "support/random_spec.hpp"
#include "support/workspace_figures.hpp"

// Properties of random specs, from their text to their report.
namespace qerr {
namespace {

using testing::Dice;
using testing::RandomSpec;
using testing::Writing;

/// A folder for the files of one test.
class Folder {
 public:
  Folder() : path_(std::filesystem::temp_directory_path() / ("qerr_properties_" + std::to_string(getpid()))) {
    std::filesystem::create_directories(path_);
  }
  ~Folder() { std::filesystem::remove_all(path_); }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;

  std::string write(const std::string& name, const std::string& text) const {
    std::ofstream(path_ / name, std::ios::binary) << text;
    return (path_ / name).string();
  }
  std::string path(const std::string& name) const { return (path_ / name).string(); }

 private:
  std::filesystem::path path_;
};

Spec read_as(const Folder& folder, const RandomSpec& s, const Writing& writing) {
  folder.write("robot.urdf", s.urdf(writing));
  return parse_spec(s.text(writing, "robot.urdf"), folder.path("spec.yaml"));
}

std::vector<testing::WorkspaceFigure> figures_of(const Spec& spec) {
  const Analysis a = analyze(spec, {.threads = 1});
  return testing::workspace_figures(a.spec.model, filter_norms(spec), spec.configurations.ranges,
                                    a.workspace);
}

// Each number is rounded twice more in another unit, by 1.1e-16 each; of the figures, the l1 norm is the
// least accurate one: its interval has a relative width of up to 4e-12.
RC_GTEST_PROP(SpecProperties, UnitsChangeNothing, ()) {
  Dice dice(*rc::gen::arbitrary<std::uint64_t>());
  const Folder folder;
  const RandomSpec s = testing::random_spec(dice);
  const Spec si = read_as(folder, s, {}), other = read_as(folder, s, {.other_units = true});
  RC_ASSERT(testing::same_figures(figures_of(si), figures_of(other), 1e-11));
}

// A URDF is a set of links and joints, and the sections and encoders of a spec are mappings. Only the hash of
// the file tells one order from another.
RC_GTEST_PROP(SpecProperties, TheOrderOfJointsAndKeysChangesNoByte, ()) {
  Dice dice(*rc::gen::arbitrary<std::uint64_t>());
  const Folder folder;
  const RandomSpec s = testing::random_spec(dice);
  const auto report = [&](const Writing& writing) {
    Spec spec = read_as(folder, s, writing);
    spec.sha256.clear();
    return write(analyze(spec, {.threads = 1}), "json");
  };
  RC_ASSERT(report({}) == report({.shuffle = &dice}));
}

// As in ModelProperties, for the ways in which a data sheet states a resolution.
RC_GTEST_PROP(SpecProperties, TwiceAsManyCountsNeverRaiseABound, ()) {
  Dice dice(*rc::gen::arbitrary<std::uint64_t>());
  const Folder folder;
  RandomSpec s = testing::random_spec(dice);
  const std::vector<testing::WorkspaceFigure> coarse = figures_of(read_as(folder, s, {}));
  for (auto& [joint, encoder] : s.encoders) {
    const std::string kind = encoder.numbers.front().first;
    double& stated = encoder.number(kind).value;
    stated = kind == "bits" ? stated + 1 : kind == "resolution" ? stated / 2 : stated * 2;
  }
  const std::vector<testing::WorkspaceFigure> fine = figures_of(read_as(folder, s, {}));
  RC_ASSERT(coarse.size() == fine.size());
  for (std::size_t i = 0; i < fine.size(); ++i)
    RC_ASSERT(fine[i].value <= coarse[i].value + 1e-13 * coarse[i].size);
}

RC_GTEST_PROP(SpecProperties, ThreadsChangeNoByte, ()) {
  Dice dice(*rc::gen::arbitrary<std::uint64_t>());
  const Folder folder;
  RandomSpec s = testing::random_spec(dice);
  s.count = 1 + dice.below(2000);
  const Spec spec = read_as(folder, s, {});
  const auto report = [&](unsigned threads) {
    std::string rows;
    const Analysis a = analyze(spec, {.threads = threads}, [&](const std::string& text) { rows += text; });
    return write(a, "json") + rows;
  };
  RC_ASSERT(report(1) == report(2 + static_cast<unsigned>(dice.below(4))));
}

/// A sweep of the first encoder and the cut-off: also more than 64 variants, which are evaluated together.
std::string random_sweep(Dice& dice, const RandomSpec& s) {
  return "[{key: encoders." + s.encoders.front().first +
         ".resolution, from: 1e-5, to: 1e-3, scale: log, count: " + std::to_string(2 + dice.below(8)) +
         "}, {key: filters.velocity.lowpass.cutoff, from: 100, to: 400, count: " +
         std::to_string(2 + dice.below(11)) + "}]";
}

/// What merging the shards of a random sweep gives, and what one run writes.
std::pair<std::string, std::string> merged_and_whole(Dice& dice) {
  const Folder folder;
  RandomSpec s = testing::random_spec(dice);
  s.sweep = random_sweep(dice, s);
  folder.write("robot.urdf", s.urdf({}));
  const SpecVariants variants(s.text({}, "robot.urdf"), folder.path("spec.yaml"));
  const SweepGrid grid(variants.base());
  SweepJob job{.variants = variants, .grid = grid, .statistics = all_statistics(), .text = {}};
  job.judged = dice.chance(0.5);
  const SweepRows rows =
      job.judged ? wide_rows(grid, variants, job.statistics) : tidy_rows(grid, job.statistics);
  const RunRecord record(variants, grid, {});
  const auto table = [&](const Shard& shard, unsigned threads, bool marked) {
    job.shard = shard;
    job.threads = threads;
    const std::string mark = shard_mark(shard, record);
    job.text = [&, mark](const SweptVariant& v) {
      return marked ? marked_lines(rows.lines(v), verdict_of(v, job.judged), mark) : rows.lines(v);
    };
    std::string text = rows.header + (marked ? ',' + mark : std::string()) + "\r\n";
    run_sweep(job, {}, [&](const std::string& lines, const SweepCounts&) { text += lines; });
    return text;
  };
  const std::uint64_t shards = 1 + dice.below(5);
  std::vector<std::string> files;
  for (std::uint64_t k = 0; k < shards; ++k)
    files.push_back(folder.write(std::to_string(k) + ".csv",
                                 table({k, shards}, 1 + static_cast<unsigned>(dice.below(3)), true)));
  std::string merged;
  merge_shards(files, &record, [&](const std::string& text) { merged += text; });
  return {merged, table({}, 1, false)};
}

// A sweep takes 0.1 s: 12 seeds in place of the usual 100.
TEST(SpecProperties, ShardsAndThreadsOfASweepChangeNoByte) {
  for (std::uint64_t seed = 0; seed < 4; ++seed) {
    Dice dice(seed);
    const auto [merged, whole] = merged_and_whole(dice);
    EXPECT_TRUE(merged == whole) << "seed " << seed;
    EXPECT_GT(std::count(whole.begin(), whole.end(), '\n'), 4) << "seed " << seed;
  }
}

}  // namespace
}  // namespace qerr
