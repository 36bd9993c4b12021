#include <unistd.h>

#include <algorithm>

#include "cli/command.hpp"
#include "cli/sweep_parts.hpp"
#include "core/text.hpp"
#include "input/read_text.hpp"
#include "qerr/core/quantity.hpp"
#include "report/check/parts.hpp"
#include "report/sweep/csv_lines.hpp"
#include "report/sweep/shard_file.hpp"
#include "report/sweep/sweep_page.hpp"
#include "report/sweep/sweep_report.hpp"

namespace qerr::cli {

namespace {

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
  return std::any_of(axis.keys.begin(), axis.keys.end(), [](const std::string& key) {
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
    for (steps[a] = 0; steps[a] < axis.steps.size(); ++steps[a]) try {
        sum += static_cast<double>(size(job.grid.spec(job.variants, steps).configurations));
      } catch (const Error& e) {
        if (e.trouble() != Trouble::input) throw;  // a variant that fails takes no time
      }
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
  const ReportText figures = [&](const Spec& s) { return figures_of_some(s, threads(v)); };
  std::vector<std::string> warnings = idle_overrides(base, overrides(v), {"threshold", "design"}, figures);
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

void warn_of(const FailedVariants& failed, const Values& v) {
  if (failed.count == 0) return;
  std::vector<std::string> warnings = failed.first;
  if (failed.count > warnings.size())
    warnings.push_back(std::to_string(failed.count) +
                       " variants cannot be computed or judged: their rows say why");
  warn(warnings, v);
}

/// Each line of a variant with one more cell.
std::string with_cell(const std::string& lines, const std::string& cell) {
  std::string text;
  for (std::size_t at = 0; at < lines.size();) {
    const std::size_t end = lines.find(csv_line_break, at);
    text.append(lines, at, end - at).append(cell).append(csv_line_break);
    at = end + csv_line_break.size();
  }
  return text;
}

int write_csv(SweepJob job, const Values& v) {
  SweepRows rows = chosen_rows(job, v);
  if (job.shard.stride > 1 && job.shard.stride >= job.grid.count()) {
    rows.header += shard_column;
    job.text = [text = job.text, cell = ',' + std::to_string(job.shard.first + 1) + '/' +
                                        std::to_string(job.shard.stride)](const SweptVariant& variant) {
      return with_cell(text(variant), cell);
    };
  }
  const SweepGrid& grid = job.grid;
  const Shard shard = job.shard;
  const SweepRun sweep(std::move(job));
  ShardFile file(v.text("output"), "--output", rows.header, v.given("resume"));
  std::uint64_t begin = 0;
  if (v.given("resume"))
    begin = file.resume(
        sweep.job().size(), [&](std::uint64_t i) { return cells_of_variant(grid, shard.variant(i)); },
        [&](std::uint64_t i) { return sweep.text(i); });
  const FailedVariants failed = sweep.run(
      begin, [&](const std::string& lines) { file.write(lines); }, progress(v, "variants"));
  file.close();
  warn_of(failed, v);
  return 0;
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
  const FailedVariants failed =
      SweepRun(std::move(job))
          .run(
              0, [&](const std::string& variants) { out.write(variants); }, progress(v, "variants"));
  finish(out, text.end);
  warn_of(failed, v);
  return 0;
}

int write_table(SweepJob job, const Values& v) {
  OutputFile out(v.text("output"), "--output");
  SweepTable table(job.variants, job.grid);
  job.judged = true;
  job.statistics = {find_statistic("max")};
  job.text = [&](const SweptVariant& variant) { return table.row(variant); };
  const FailedVariants failed =
      SweepRun(std::move(job))
          .run(
              0, [&](const std::string& rows) { table.add(rows); }, progress(v, "variants"));
  finish(out, table.text(style(v)));
  warn_of(failed, v);
  return 0;
}

int write_html(SweepJob job, const Values& v) {
  OutputFile out(v.text("output"), "--output");
  SweepPage page(job.variants, job.grid);
  job.judged = true;
  job.statistics = {find_statistic("max")};
  job.text = [&](const SweptVariant& variant) { return page.row(variant); };
  const FailedVariants failed =
      SweepRun(std::move(job))
          .run(
              0, [&](const std::string& rows) { page.add(rows); }, progress(v, "variants"));
  finish(out, page.text(failed));
  warn_of(failed, v);
  return 0;
}

int run(const Values& v) {
  const std::string format = format_of_sweep(v);
  const Shard shard = chosen_shard(v);
  const std::string& path = v.text("SPEC");
  const SpecVariants variants(read_text(path), path, overrides(v));
  // Before the steps are read, which may be 1e5 an axis: each variant has a configuration at least.
  double least_work = 1;
  for (const SweepAxis& axis : variants.base().sweep) least_work *= static_cast<double>(axis.steps.size());
  least_work /= static_cast<double>(shard.stride);
  if (least_work < 0x1p53)
    limit_work(variants.base(), least_work, "sweep", "variants", v, variants_per_second);
  const SweepGrid grid(variants.base());
  const SweepJob job{.variants = variants,
                     .grid = grid,
                     .shard = shard,
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

Command sweep_command() {
  return {"sweep",
          "Figures of every variant of a spec: the grid of its `sweep:` section",
          joined({spec_options(),
                  sweep_row_options(),
                  {{.name = "--shard",
                    .value = "K/N",
                    .meaning = "compute part K of N parts; qerr merge joins their files"},
                   {.name = "--resume",
                    .kind = OptionKind::flag,
                    .meaning = "go on after what is whole in the output's file"}},
                  long_work_option(),
                  output_options()}),
          run,
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
