#include "report.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>

namespace qerr::bench {

namespace {

std::string format(const char* pattern, double value) {
  char buffer[64];
  std::snprintf(buffer, sizeof buffer, pattern, value);
  return buffer;
}

/// Timings have three significant digits.
std::string digits(double value) {
  const int before = value > 0 ? static_cast<int>(std::floor(std::log10(value))) + 1 : 1;
  char buffer[64];
  std::snprintf(buffer, sizeof buffer, "%.*f", std::clamp(3 - before, 0, 4), value);
  return buffer;
}

std::string million(const std::optional<Rate>& rate) {
  return rate ? digits(1e-6 * rate->best) + " (" + digits(1e-6 * rate->median) + ")" : "-";
}
std::string percent(const std::optional<double>& fraction) {
  return fraction ? format("%.0f %%", 100 * *fraction) : "-";
}
std::string small(double value) { return std::isnan(value) ? "-" : value == 0 ? "0" : format("%.1e", value); }

/// Rows of cells, the first of them the header; the first column is text, the others are figures.
class Table {
 public:
  void row(std::vector<std::string> cells) { rows_.push_back(std::move(cells)); }

  std::string print(bool markdown) const {
    std::vector<std::size_t> width(rows_.front().size());
    for (const auto& cells : rows_)
      for (std::size_t i = 0; i < cells.size(); ++i) width[i] = std::max(width[i], cells[i].size());
    std::string out;
    for (std::size_t r = 0; r < rows_.size(); ++r) {
      out += markdown ? "| " : "  ";
      for (std::size_t i = 0; i < width.size(); ++i) {
        const std::string padding(width[i] - rows_[r][i].size(), ' ');
        out += i == 0 ? rows_[r][i] + padding : padding + rows_[r][i];
        out += i + 1 < width.size() ? (markdown ? " | " : "  ") : (markdown ? " |" : "");
      }
      out += '\n';
      if (r == 0 && markdown) {
        out += "|---|";
        for (std::size_t i = 1; i < width.size(); ++i) out += "---:|";
        out += '\n';
      }
    }
    return out + '\n';
  }

 private:
  std::vector<std::vector<std::string>> rows_;
};

std::string rates(const ProblemResult& problem, bool markdown) {
  const auto& rows = problem.contestants;
  const bool counted = std::any_of(rows.begin(), rows.end(), [](const ContestantResult& c) {
    return c.fma_pipe_operations[0] || c.fma_pipe_operations[2];
  });
  Table table;
  std::vector<std::string> head{problem.name + ", " + std::to_string(problem.joints) + " joints"};
  head.insert(head.end(), stage_names.begin(), stage_names.end());
  if (counted)
    for (const char* name : stage_names) head.push_back(name + std::string(", of bound"));
  table.row(head);
  for (const ContestantResult& c : rows) {
    std::vector<std::string> cells{c.name};
    for (const auto& rate : c.rates) cells.push_back(million(rate));
    if (counted)
      for (const auto& fraction : c.fraction_of_bound) cells.push_back(percent(fraction));
    table.row(cells);
  }
  std::string out = table.print(markdown);
  if (problem.two_threads)
    out += "Two threads do " + format("%.2f", problem.two_threads->ratio) +
           " times what one does (workspace, wall time; they had " +
           format("%.2f", problem.two_threads->cores) + " cores).\n\n";
  return out;
}

/// Speed of each contestant of qerr relative to the row's contestant, at the whole job.
std::string ratios(const ProblemResult& problem, bool markdown) {
  constexpr auto full = static_cast<std::size_t>(Stage::full);
  Table table;
  std::vector<std::string> head{problem.name + ", full: times as fast as"};
  for (const ContestantResult& c : problem.contestants)
    if (c.own) head.push_back(c.name);
  if (head.size() == 1) return {};
  table.row(head);
  for (const ContestantResult& other : problem.contestants) {
    std::vector<std::string> cells{other.name};
    for (const ContestantResult& c : problem.contestants)
      if (c.own) cells.push_back(digits(c.rates[full]->best / other.rates[full]->best));
    table.row(cells);
  }
  return table.print(markdown);
}

std::string peaks(const Results& results, bool markdown) {
  if (results.peaks.empty()) return {};
  Table table;
  table.row({"peak of one core", "instruction", "G instr/s", "GFLOP/s"});
  for (const PeakResult& p : results.peaks)
    table.row({p.peak.instruction_set, p.peak.instruction, digits(1e-9 * p.rate.best),
               digits(2e-9 * p.rate.best * p.peak.lanes)});
  return table.print(markdown);
}

}  // namespace

Setting setting(const RaceOptions& options, std::uint64_t configurations, std::uint64_t compared) {
  std::string machine = "unknown processor";
  std::ifstream cpuinfo("/proc/cpuinfo");
  for (std::string line; std::getline(cpuinfo, line);)
    if (line.starts_with("model name")) {
      machine = line.substr(line.find(':') + 2);
      break;
    }
#if defined(__clang__)
  const std::string compiler = "Clang " __clang_version__;
#else
  const std::string compiler = "GCC " __VERSION__;
#endif
  return {machine, compiler, options, configurations, compared};
}

std::string agreement(const Results& results, bool markdown) {
  std::string out;
  for (const ProblemResult& problem : results.problems) {
    Table table;
    table.row({problem.name + ": deviation", "J", "worst case", "covariance", "max, mean", "quantiles", ""});
    for (const ContestantResult& c : problem.contestants) {
      const Deviation& d = c.deviation;
      table.row({c.name, small(d.jacobian), small(d.worst_case), small(d.covariance), small(d.summary),
                 small(d.quantile), d.agrees() ? "agrees" : "WRONG"});
    }
    out += table.print(markdown);
  }
  return out;
}

std::string text(const Results& results, const Setting& s, bool markdown) {
  const std::string bullet = markdown ? "- " : "  ", newline = "\n";
  std::string out = s.machine + ", " + s.compiler + newline;
  out += "M configurations per second of CPU time, one thread: the best (and the median) of " +
         std::to_string(s.options.rounds) + " interleaved rounds.\n";
  if (!results.problems.empty())
    for (const ContestantResult& c : results.problems.front().contestants)
      out += bullet + c.name + ": " + c.built + newline;
  out += newline;
  for (const ProblemResult& problem : results.problems)
    out += rates(problem, markdown) + ratios(problem, markdown);
  return out + peaks(results, markdown);
}

}  // namespace qerr::bench
