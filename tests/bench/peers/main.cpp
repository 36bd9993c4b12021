// Compares qerr's kernels with other libraries, interleaved in one run; scripts/compare_peers.sh builds and
// runs it. One row of contestants.cpp is one contestant.

#include <CLI/CLI.hpp>
#include <cstdio>

#include "core/output_file.hpp"
#include "core/text.hpp"
#include "qerr/core/error.hpp"
#include "report.hpp"
#include "self_test.hpp"

namespace {

using namespace qerr;
using namespace qerr::bench;

struct Arguments {
  std::vector<std::string> robots{QERR_SOURCE_DIR "/configs/kuka_lwr/spec.yaml"};
  std::string base, tip, json;
  std::uint64_t configurations = 100'000;
  RaceOptions race;
  std::vector<std::string> instruction_sets, only;
  bool markdown = false, list = false, self_test = false;
};

[[noreturn]] void refuse(const std::string& rule, const std::string& found, const std::string& remedy) {
  throw Error({"", 0, 0}, "", rule, "'" + found + "'", remedy, Trouble::usage);
}

/// The peaks of the requested instruction sets, or of all that this machine supports.
std::vector<FmaPeak> chosen_peaks(const std::vector<std::string>& wanted) {
  std::vector<FmaPeak> chosen;
  std::vector<std::string> known;
  for (const FmaPeak& peak : fma_peaks()) {
    if (peak.runs_here) known.push_back(peak.instruction_set);
    if (peak.runs_here && (wanted.empty() || std::count(wanted.begin(), wanted.end(), peak.instruction_set)))
      chosen.push_back(peak);
  }
  for (const std::string& name : wanted)
    if (!std::count(known.begin(), known.end(), name))
      refuse("--instruction-set: not one that this machine runs", name, did_you_mean(name, known));
  return chosen;
}

bool contains(const std::string& text, const std::string& part) {
  const auto same = [](char a, char b) { return std::tolower(a) == std::tolower(b); };
  return std::search(text.begin(), text.end(), part.begin(), part.end(), same) != text.end();
}

/// The rows whose name contains one of the words of --only, and whose instruction set is among the peaks.
std::vector<Contestant> chosen_contestants(const Arguments& a, const std::vector<FmaPeak>& peaks) {
  std::vector<Contestant> chosen;
  std::vector<std::string> known;
  for (const Contestant& c : contestants()) {
    known.push_back(c.name);
    const bool runs = c.instruction_set.empty() ||
                      std::any_of(peaks.begin(), peaks.end(),
                                  [&](const FmaPeak& p) { return p.instruction_set == c.instruction_set; });
    const bool named = a.only.empty() || std::any_of(a.only.begin(), a.only.end(), [&](const auto& word) {
                         return contains(c.name, word);
                       });
    if (runs && named) chosen.push_back(c);
  }
  for (const std::string& word : a.only)
    if (std::none_of(known.begin(), known.end(), [&](const auto& name) { return contains(name, word); }))
      refuse("--only: no contestant of this build has this in its name", word, did_you_mean(word, known));
  if (chosen.empty())
    refuse("--only and --instruction-set: together they leave nobody", a.only.front(), "drop one");
  return chosen;
}

Results compared(const std::vector<Problem>& problems, const std::vector<Contestant>& rows,
                 std::uint64_t count) {
  const Contestant reference = contestants().front();
  Results results;
  for (const Problem& p : problems) {
    results.problems.push_back({p.name, p.points.rows(), {}, {}});
    for (const Contestant& c : rows)
      results.problems.back().contestants.push_back(
          {c.name, c.built, c.instruction_set, c.own(), deviation(c, reference, p, count), {}, {}, {}});
  }
  return results;
}

/// Whether on every robot the first `right` contestants agree with the reference, and no other does.
bool only_these_agree(const Results& results, std::size_t right) {
  for (const ProblemResult& p : results.problems)
    for (std::size_t i = 0; i < p.contestants.size(); ++i)
      if (p.contestants[i].deviation.agrees() != (i < right)) return false;
  return true;
}

int run(const Arguments& a) {
  const std::vector<FmaPeak> peaks = chosen_peaks(a.instruction_sets);
  std::vector<Contestant> rows = chosen_contestants(a, peaks);
  const std::size_t right = rows.size();
  if (a.self_test)
    for (Contestant& wrong : spoiled(contestants().front())) rows.push_back(std::move(wrong));
  if (a.list) {
    for (const Contestant& c : rows) std::printf("%s: %s\n", c.name.c_str(), c.built.c_str());
    return 0;
  }
  std::optional<OutputFile> file;
  if (!a.json.empty()) file.emplace(a.json);

  std::vector<Problem> problems;
  for (const std::string& robot : a.robots) {
    problems.push_back(read_problem(robot, a.base, a.tip, a.configurations));
    problems.push_back(calibrated(problems.back()));
  }
  const std::uint64_t count = std::min<std::uint64_t>(a.configurations, 20'000);
  Results results = compared(problems, rows, count);
  std::printf("%s", agreement(results, a.markdown).c_str());
  std::fflush(stdout);
  if (!only_these_agree(results, right)) {
    std::fprintf(stderr, "compare_peers: %s\n",
                 a.self_test
                     ? "the table above should say WRONG to all that are called so, and to nobody else"
                     : "a contestant is wrong (see the table above); nothing was timed");
    return 1;
  }
  if (a.self_test) return 0;
  for (const FmaPeak& peak : peaks) results.peaks.push_back({peak, {}});
  race(problems, rows, a.race, results);
  const Setting made_with = setting(a.race, a.configurations, count);
  std::printf("%s", text(results, made_with, a.markdown).c_str());
  if (file) {
    file->write(json(results, made_with));
    file->close();
  }
  return 0;
}

void declare(CLI::App& app, Arguments& a) {
  app.add_option("robots", a.robots,
                 "Specs, or plain URDFs; default: configs/kuka_lwr. Each also calibrated.");
  app.add_option("--base", a.base, "Base link of the URDFs; default: their root");
  app.add_option("--tip", a.tip, "Tip link of the URDFs; default: their only leaf");
  app.add_option("--rounds", a.race.rounds, "Interleaved rounds")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  app.add_option("--slice", a.race.slice, "CPU time of each figure in a round [s]")
      ->check(CLI::Range(0.001, 60.0))
      ->capture_default_str();
  app.add_option("--configurations", a.configurations, "Configurations in memory, taken again and again")
      ->check(CLI::Range(64, 100'000'000))
      ->capture_default_str();
  app.add_option("--instruction-set", a.instruction_sets, "Only these: portable, avx2, avx512")
      ->delimiter(',');
  app.add_option("--only", a.only, "Only contestants with one of these words in their name")->delimiter(',');
  app.add_option("--json", a.json, "Write all figures to this file");
  app.add_flag("--markdown", a.markdown, "Tables in Markdown");
  app.add_flag("--list", a.list, "Print the contestants and how they were built, and end");
  app.add_flag("--self-test", a.self_test,
               "Check that contestants that are slightly wrong are found, and end");
}

}  // namespace

int main(int argc, char** argv) {
  Arguments arguments;
  CLI::App app{"Times the tip Jacobian, the bounds and their statistics beside other libraries."};
  declare(app, arguments);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    return app.exit(e) == 0 ? 0 : static_cast<int>(Trouble::usage);
  }
  try {
    return run(arguments);
  } catch (const Error& e) {
    std::fprintf(stderr, "%s\n", e.what());
    return static_cast<int>(e.trouble());
  }
}
