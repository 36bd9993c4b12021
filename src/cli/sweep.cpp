#include "report/sweep/sweep.hpp"

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>

#include "cli/shared.hpp"
#include "core/text.hpp"
#include "input/csv.hpp"
#include "qerr/core/quantity.hpp"
#include "report/analysis/figures.hpp"

namespace qerr::cli {

namespace {

std::vector<std::string> statistic_names() { return names_of(statistic_kinds()); }

/// In the order of the reports, whatever that of the option.
std::vector<const StatisticKind*> chosen_statistics(const Values& v) {
  if (!v.given("statistics")) return all_statistics();
  std::vector<const StatisticKind*> chosen;
  for (const StatisticKind* kind : all_statistics()) {
    const auto& names = v.texts("statistics");
    if (contains(names, kind->name)) chosen.push_back(kind);
  }
  return chosen;
}

std::vector<Option> sweep_row_options() {
  return {valued("--statistics", "NAME,...",
                 "write these statistics only, e.g. max,p99 (qerr list statistics)", OptionKind::list)
              .one_of(statistic_names, "statistic"),
          flag("--wide", "CSV with one row a variant: figures, filters, requirements")};
}

/// The rows that the options ask for; sets what the job needs for them.
SweepRows chosen_rows(SweepJob& job, const Values& v) {
  const SweepRows rows = v.given("wide") ? wide_rows(job.grid, job.variants, job.statistics)
                                         : tidy_rows(job.grid, job.statistics);
  job.text = rows.lines;
  job.judged = job.judged || v.given("wide");
  return rows;
}

RunRecord record_of(const SweepJob& job, const Values& v) {
  std::vector<std::pair<std::string, std::string>> options;
  for (const char* name : {"set", "seed", "statistics", "wide"}) {
    std::string value;
    for (const std::string& text : v.texts(name)) value += text + '\n';
    if (v.given(name)) options.emplace_back("--" + std::string(name), value);
  }
  return {job.variants, job.grid, options};
}

/// A line to standard error, with --quiet, too.
void say(const std::string& line) {
  clear_progress();
  std::fputs(("qerr: " + line + '\n').c_str(), stderr);
}

/// `3 of 175 variants`.
std::string of_variants(std::uint64_t number, const SweepCounts& counts) {
  return std::to_string(number) + " of " + counted(counts.variants, "variant");
}

/// How many variants were not computed, if there are any.
void say_failed(const SweepCounts& counts) {
  if (counts.failed > 0)
    say(of_variants(counts.failed, counts) + " cannot be computed or judged: the rows say why");
}

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
    throw Error({"temporary file"}, "", std::string("cannot be written: ") + std::strerror(errno), "",
                "name the output: -o FILE.csv", Trouble::file_system);
  }

  std::FILE* file_;
};

int run_merge(const Values& v) {
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
  options.front() =
      valued("--spec", "SPEC", "refuse shards of another spec, other files that it names, other options");
  for (Option& option : options)
    if (option.name == "--set" || option.name == "--statistics" || option.name == "--wide")
      option.needs = "--spec";
  return options;
}

/// `2/5`.
Shard chosen_shard(const Values& v) {
  if (!v.given("shard")) return {};
  const std::string& text = v.text("shard");
  const std::size_t slash = text.find('/');
  const auto number = slash == std::string::npos ? std::nullopt : parse_number(text.substr(0, slash));
  const auto total = slash == std::string::npos ? std::nullopt : parse_number(text.substr(slash + 1));
  const auto whole = [](double x) {
    return x >= 1 && x <= 0x1p53 && x == static_cast<double>(static_cast<std::uint64_t>(x));
  };
  if (!number || !total || !whole(*total) || !whole(*number) || *number > *total)
    throw usage("--shard", "must be K/N with whole numbers 1 <= K <= N", quoted(text), "e.g. --shard 2/5");
  return {static_cast<std::uint64_t>(*number) - 1, static_cast<std::uint64_t>(*total)};
}

/// A terminal shows a table; what is read by programs is CSV.
std::string format_of_sweep(const Values& v) {
  const bool csv = v.given("shard") || v.given("wide") || v.given("resume");
  const std::string format = v.given("format")               ? v.text("format")
                             : v.text("output") != "-"       ? chosen_format(v)
                             : csv || !isatty(STDOUT_FILENO) ? "csv"
                                                             : "table";
  for (const char* option : {"shard", "wide", "resume"})
    if (v.given(option) && format != "csv")
      throw usage(std::string("--") + option, "needs CSV", quoted(format),
                  "write CSV: -o FILE.csv, or --format csv");
  if (v.given("resume") && v.text("output") == "-")
    throw usage("--resume", "needs a file to go on with", "standard output", "name it: -o FILE.csv");
  return format;
}

/// Whether the steps of an axis are read before the sweep: they change the number of configurations, or name
/// files, which had better be missed now than after an hour.
bool is_read_before(const SweepAxis& axis) {
  return std::ranges::any_of(axis.keys, [](const std::string& key) {
    return key.starts_with("configurations") || key.starts_with("motion") || key == "robot" ||
           key == "robot.urdf";
  });
}

/// The configurations of all variants of the shard, as far as they are known without reading each of them.
double work(const SweepJob& job) {
  const auto usual = static_cast<double>(size(job.variants.base().configurations));
  double work = static_cast<double>(job.size()) * usual;
  std::vector<std::size_t> steps(job.grid.axes().size());
  for (std::size_t a = 0; a < steps.size(); ++a) {
    const SweepAxis& axis = job.grid.axes()[a];
    if (!is_read_before(axis)) continue;
    double sum = 0;
    for (steps[a] = 0; steps[a] < axis.steps.size(); ++steps[a])
      if (const auto spec = job.grid.readable(job.variants, steps))  // a variant that fails takes no time
        sum += static_cast<double>(size(spec->configurations));
    steps[a] = 0;
    work *= sum / (usual * static_cast<double>(axis.steps.size()));
  }
  return work;
}

/// About what two cores of 2023 read, evaluate and write of a small arm with one filter, however few the
/// configurations: 2000 variants took 1.35 s of CPU.
constexpr double variants_per_second = 3000;

/// What the spec itself is warned of, but that its sweep is not used.
void warn_of(const Spec& spec, const Values& v) {
  std::vector<std::string> warnings = spec.warnings;
  std::erase_if(warnings, [](const std::string& warning) { return warning.starts_with("sweep: "); });
  warn(warnings, v);
}

/// Overrides and keys of the sweep that change no figure.
void warn_of_idle_keys(const SpecVariants& variants, const Values& v) {
  const Spec& base = variants.base();
  const auto figures = [&](const Spec& s) { return figures_of_some(s, threads(v), "csv"); };
  std::vector<std::string> warnings = idle_overrides(base, overrides(v), {"threshold", "design"}, figures);
  std::erase_if(warnings, [](const std::string& w) { return w.starts_with("--set sweep"); });
  const auto text = [&](const SweepStep& step) {
    std::vector<Node> effects;
    for (const std::string& effect : step.effects) effects.push_back(parse_yaml(effect, base.file));
    Spec spec = variants.variant(spec_changes(step.changes), effects);
    spec.overrides.clear();
    return figures(spec);
  };
  for (const SweepAxis& axis : base.sweep) try {
      if (axis.steps.size() > 1 && text(axis.steps.front()) == text(axis.steps.back()))
        warnings.push_back("sweep: " + axis.keys.front() +
                           " changes no figure between its first and its last value");
    } catch (const Error&) {  // of a variant that cannot be computed, which its rows say
    }
  warn(warnings, v);
}

/// What a sweep says at its end, and its exit code.
int finish_sweep(const SweepOutcome& outcome, const Values& v) {
  const SweepCounts& counts = outcome.counts;
  warn(outcome.faults, v);
  say_failed(counts);
  // A shard may have a single variant, and the others go on.
  const bool nothing_computed = counts.failed == counts.variants && !v.given("shard");
  if (!v.given("check")) return nothing_computed ? static_cast<int>(Trouble::input) : 0;
  if (counts.unmet > 0) say(of_variants(counts.unmet, counts) + " do not meet their requirements");
  return counts.failed > 0 ? static_cast<int>(Trouble::input) : counts.unmet > 0 ? 1 : 0;
}

/// Files that the rows were computed from must be the same at the end, as those of single variants are read
/// when their turn comes.
void require_unchanged(const RunRecord& at_begin, const RunRecord& at_end, const std::string& output) {
  if (const std::string changed = at_begin.difference(at_end); !changed.empty())
    throw Error({output}, "", "an input has changed while the sweep was computed", changed,
                "compute it anew");
}

int write_csv(SweepJob job, const Values& v) {
  SweepRows rows = chosen_rows(job, v);
  const RunRecord record = record_of(job, v);
  const bool marked = v.given("shard");
  if (marked) {
    const std::string mark = shard_mark(job.shard, record);
    rows.header += ',' + mark;
    job.text = [text = job.text, mark, judged = job.judged](const SweptVariant& variant) {
      return marked_lines(text(variant), verdict_of(variant, judged), mark);
    };
  }
  ShardFile file(v.text("output"), "--output", rows.header, record, marked, v.given("resume"));
  SweepCounts kept;
  if (v.given("resume")) kept = file.resume(job.judged);
  if (file.unknown())
    warn({v.text("output") + ": the file does not say of which inputs it is: all variants are computed anew"},
         v);
  if (v.text("output") != "-")
    say_on_interrupt(v.text("output") + " has the rows so far: the same command with --resume goes on");
  const SweepOutcome outcome = run_sweep(
      job, kept, [&](const std::string& lines, const SweepCounts& counts) { file.write(lines, counts); },
      progress(v, "variants"));
  require_unchanged(record, record_of(job, v), v.text("output"));
  file.close();
  if (file.replaces())
    warn({v.text("output") + ": rows had been changed after they were written: they are computed anew"}, v);
  return finish_sweep(outcome, v);
}

int write_json(SweepJob job, const Values& v) {
  OutputFile out(v.text("output"), "--output");
  const SweepJson text = sweep_json(job.variants, job.grid);
  job.judged = true;
  // Variants are evaluated in batches: the separators stand before all but the first of the sweep.
  const SweepGrid& grid = job.grid;
  job.text = [&, statistics = job.statistics](const SweptVariant& variant) {
    return (variant.variant > 0 ? text.separator : "") + SweepJson::variant(variant, grid, statistics);
  };
  out.write(text.begin);
  const SweepOutcome outcome = run_sweep(
      job, {}, [&](const std::string& variants, const SweepCounts&) { out.write(variants); },
      progress(v, "variants"));
  finish(out, text.end);
  return finish_sweep(outcome, v);
}

/// A table or a page, of the largest figures.
template <class Report>
SweepOutcome filled(Report& report, SweepJob job, const Values& v) {
  job.judged = true;
  job.statistics = {find_statistic("max")};
  std::mutex guard;
  std::map<std::uint64_t, decltype(report.row({}))> waiting;  // rows whose turn has not come
  job.text = [&](const SweptVariant& variant) {
    auto row = report.row(variant);
    const std::lock_guard lock(guard);
    waiting.emplace(variant.variant, std::move(row));
    return "";
  };
  return run_sweep(
      job, {},
      [&](const std::string&, const SweepCounts& counts) {
        const std::lock_guard lock(guard);
        while (!waiting.empty() && waiting.begin()->first < counts.variants)
          report.add(std::move(waiting.extract(waiting.begin()).mapped()));
      },
      progress(v, "variants"));
}

int write_table(const SweepJob& job, const Values& v) {
  OutputFile out(v.text("output"), "--output");
  SweepTable table(job.variants, job.grid);
  const SweepOutcome outcome = filled(table, job, v);
  finish(out, table.text(style(v)));
  return finish_sweep(outcome, v);
}

int write_html(const SweepJob& job, const Values& v) {
  OutputFile out(v.text("output"), "--output");
  SweepPage page(job.variants, job.grid);
  const SweepOutcome outcome = filled(page, job, v);
  finish(out, page.text(outcome));
  return finish_sweep(outcome, v);
}

/// `--check` of a sweep without requirements would be a verdict about nothing.
void require_requirements(const SweepGrid& grid, const Spec& spec, const Values& v) {
  const std::vector<std::string> keys = grid.keys();
  if (!v.given("check") || !spec.requirements.empty() ||
      std::ranges::any_of(keys, [](const auto& key) { return key.starts_with("requirements"); }))
    return;
  throw Error({spec.file, 1, 1}, "requirements", "the spec has none: there is nothing to check", "",
              "add requirements (qerr help requirements), or leave out --check");
}

int run_sweep(const Values& v) {
  const std::string format = format_of_sweep(v);
  const Shard shard = chosen_shard(v);
  const std::string& path = v.text("SPEC");
  const SpecVariants variants(read_text(path), path, overrides(v));
  refuse_varied(variants.base(), overrides(v));
  // Before the steps are read, which may be 1e5 an axis: each variant has a configuration at least.
  double least_work = 1;
  for (const SweepAxis& axis : variants.base().sweep) least_work *= static_cast<double>(axis.steps.size());
  least_work /= static_cast<double>(shard.stride);
  if (least_work < 0x1p53)
    limit_work(variants.base(), least_work, "sweep", "variants", v, variants_per_second);
  const SweepGrid grid(variants.base());
  require_requirements(grid, variants.base(), v);
  const SweepJob job{.variants = variants,
                     .grid = grid,
                     .shard = shard,
                     .judged = v.given("check"),
                     .statistics = chosen_statistics(v),
                     .threads = threads(v),
                     .text = {}};
  limit_work(variants.base(), work(job), "sweep", "configurations", v);
  warn_of(variants.base(), v);
  warn_of_idle_keys(variants, v);
  constexpr double hour = 3600;
  if (least_work / variants_per_second > hour)
    warn({"sweep: " + significant(least_work, 3) + " variants take " +
          duration(least_work / variants_per_second) + " or more; --shard divides them, --resume goes on"},
         v);
  return format == "csv"    ? write_csv(job, v)
         : format == "json" ? write_json(job, v)
         : format == "html" ? write_html(job, v)
                            : write_table(job, v);
}

}  // namespace

Command merge_command() {
  return {
      "merge",
      "Join the files of the shards of a sweep: the bytes of one run",
      joined({{valued("FILE", "", "a file of each shard, in any order", OptionKind::repeat).must()},
              spec_comparison(),
              {text_output_option(".csv .txt")}}),
      run_merge,
      {{"qerr merge 1.csv 2.csv 3.csv 4.csv 5.csv --spec arm.yaml -o sweep.csv", "one file of all variants"},
       {"qerr merge shards/*.csv --spec arm.yaml -o sweep.csv",
        "the same, and none of them is of another spec"}},
      {"variants"}};
}

Command sweep_command() {
  return {
      "sweep",
      "Figures of every variant of a spec: the grid of its `sweep:` section",
      joined(
          {spec_options(),
           sweep_row_options(),
           {valued("--shard", "K/N", "compute part K of N parts; qerr merge joins their files"),
            flag("--resume", "go on after what is whole in the output's file"),
            flag("--check",
                 "end with 1 if a variant does not meet its requirements, with 3 if one cannot be computed")},
           long_work_option(),
           output_options()}),
      run_sweep,
      {{"qerr sweep arm.yaml", "every variant of the grid, one line each"},
       {"qerr sweep arm.yaml -o sweep.csv", "every figure of every variant, one a row"},
       {"qerr sweep arm.yaml -o sweep.csv --resume", "go on after an interruption"},
       {"qerr sweep arm.yaml --wide --statistics max,p99 -o wide.csv",
        "one row a variant, with its requirements"},
       {"qerr sweep arm.yaml --shard 2/5 -o 2.csv", "the second of five parts, for a cluster"},
       {"qerr merge 1.csv 2.csv 3.csv 4.csv 5.csv --spec arm.yaml -o sweep.csv",
        "and all of them in one file"}},
      {"variants", "spec", "output"}};
}

}  // namespace qerr::cli
