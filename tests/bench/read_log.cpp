// Compares reading a measured log with straightforward implementations: bytes per second, and the ratio.
//
//   cmake -S . -B build -G Ninja -DQERR_BENCH=ON && ninja -C build bench_read_log &&
//   build/tests/bench/bench_read_log
//
// The log has 15 columns (time; counts and reference of six joints; two of the tip), with 8 decimals as a
// recorder writes them, or with all digits of a double as `qerr simulate` does. Both baselines read the same
// file into memory of the same shape: std::getline and operator>>, and std::getline and strtod. Where
// Debian's python3-pandas is installed, its read_csv reads the same files in the same run.

#include "qerr/input/read_log.hpp"

#include <benchmark/benchmark.h>
#include <unistd.h>

#include <array>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>

namespace {

using namespace qerr;

constexpr std::size_t rows = 200'000;
constexpr std::size_t columns = 15;

/// A folder with a spec of six joints and a log of each kind.
struct Files {
  std::filesystem::path folder =
      std::filesystem::temp_directory_path() / ("qerr_bench_log_" + std::to_string(getpid()));
  std::array<std::string, 2> logs{(folder / "decimals.csv").string(), (folder / "doubles.csv").string()};
  Spec spec;

  Files() {
    std::filesystem::create_directories(folder);
    std::ofstream(folder / "spec.yaml")
        << "qerr: 1\nrobot: {urdf: '" QERR_SOURCE_DIR
           "/configs/puma560/puma560.urdf'}\nencoders: {'*': {counts_per_rev: 8192}}\n";
    spec = read_spec((folder / "spec.yaml").string());
    for (const int kind : {0, 1}) write(kind);
  }
  ~Files() { std::filesystem::remove_all(folder); }

  void write(int kind) const {
    std::ofstream out(logs[static_cast<std::size_t>(kind)]);
    out << "time [s]";
    for (const IndependentJoint& j : spec.model.chain.independent)
      out << ',' << j.name << ".counts," << j.name << ".reference [rad]";
    out << ",tip.x [m],tip.y [m]\n";
    char text[64];
    const auto put = [&](double value) {
      if (kind == 0)
        std::snprintf(text, sizeof text, ",%.8f", value);
      else
        *std::to_chars(text + 1, text + 60, value).ptr = '\0', text[0] = ',';
      out << text;
    };
    for (std::size_t i = 0; i < rows; ++i) {
      const double t = 1e-3 * static_cast<double>(i);
      std::snprintf(text, sizeof text, "%.3f", t);
      out << text;
      for (int j = 0; j < 6; ++j) {
        const double q = 0.6 * std::sin(1.3 * t + 0.4 * j) + 0.1 * std::sin(6.1 * t) - 1 + 0.4 * j;
        out << ',' << std::lround(q * 8192 / 6.283185307179586);
        put(q);
      }
      for (const double p : {0.5 + 0.1 * std::sin(t), 0.2 * std::cos(t)}) put(p);
      out << '\n';
    }
  }

  double bytes(int kind) const {
    return static_cast<double>(std::filesystem::file_size(logs[static_cast<std::size_t>(kind)]));
  }
};

Files& files() {
  static Files all;
  return all;
}

void report(benchmark::State& state) {
  state.SetLabel(state.range(0) == 0 ? "8 decimals" : "whole doubles");
  state.counters["bytes"] = benchmark::Counter(files().bytes(static_cast<int>(state.range(0))),
                                               benchmark::Counter::kIsIterationInvariantRate);
}

const std::string& log_of(const benchmark::State& state) {
  return files().logs[static_cast<std::size_t>(state.range(0))];
}

void log_reader(benchmark::State& state) {
  for (auto _ : state) {
    LogReader reader(log_of(state), files().spec);
    double sum = 0;
    for (Eigen::ArrayXXd block; reader.next(block);) sum += block(0, 1);
    benchmark::DoNotOptimize(sum);
  }
  report(state);
}

template <typename Number>
void by_lines(benchmark::State& state, Number number) {
  for (auto _ : state) {
    std::ifstream in(log_of(state));
    std::string line;
    std::getline(in, line);
    std::vector<double> values;
    values.reserve(rows * columns);
    while (std::getline(in, line)) number(line, values);
    benchmark::DoNotOptimize(values.data());
  }
  report(state);
}

void by_streams(benchmark::State& state) {
  by_lines(state, [](const std::string& line, std::vector<double>& values) {
    std::istringstream cells(line);
    double value;
    char comma;
    while (cells >> value) {
      values.push_back(value);
      cells >> comma;
    }
  });
}

void by_strtod(benchmark::State& state) {
  by_lines(state, [](const std::string& line, std::vector<double>& values) {
    char* end = nullptr;
    for (const char* p = line.c_str();; p = end + 1) {
      values.push_back(std::strtod(p, &end));
      if (*end != ',') break;
    }
  });
}

/// The default reader of pandas (not exactly rounded), by its CPU time.
void by_pandas(benchmark::State& state) {
  const std::string command =
      "/usr/bin/python3 -c \"import pandas, time; t = time.process_time(); pandas.read_csv('" +
      log_of(state) + "'); print(time.process_time() - t)\" 2>/dev/null";
  for (auto _ : state) {
    FILE* const answer = ::popen(command.c_str(), "r");
    double seconds = 0;
    const bool read = answer && std::fscanf(answer, "%lf", &seconds) == 1;
    if (answer) ::pclose(answer);
    if (!read) {
      state.SkipWithError("python3-pandas is not installed");
      break;
    }
    state.SetIterationTime(seconds);
  }
  report(state);
}

/// The console output, followed by the speed of the reader relative to each baseline.
class Ratios : public benchmark::ConsoleReporter {
 public:
  Ratios() : ConsoleReporter(OO_Tabular) {}

  void ReportRuns(const std::vector<Run>& runs) override {
    ConsoleReporter::ReportRuns(runs);
    for (const Run& run : runs) {
      const std::string name = run.benchmark_name();
      const bool manual = name.ends_with("manual_time");
      if (!run.error_occurred)
        times_.push_back({name, manual ? run.GetAdjustedRealTime() : run.GetAdjustedCPUTime()});
    }
  }
  void Finalize() override {
    for (const auto& [name, time] : times_)
      for (const auto& [own, own_time] : times_)
        if (own.starts_with("log_reader") && name != own && name[name.find('/') + 1] == own.back())
          GetOutputStream() << name << " takes " << time / own_time << " times as long as " << own << '\n';
  }

 private:
  std::vector<std::pair<std::string, double>> times_;
};

BENCHMARK(log_reader)->DenseRange(0, 1)->Unit(benchmark::kMillisecond);
BENCHMARK(by_strtod)->DenseRange(0, 1)->Unit(benchmark::kMillisecond);
BENCHMARK(by_streams)->DenseRange(0, 1)->Unit(benchmark::kMillisecond);
BENCHMARK(by_pandas)->DenseRange(0, 1)->Unit(benchmark::kMillisecond)->UseManualTime();

}  // namespace

int main(int argc, char** argv) {
  benchmark::Initialize(&argc, argv);
  files();  // written before the measurement
  Ratios ratios;
  benchmark::RunSpecifiedBenchmarks(&ratios);
  benchmark::Shutdown();
}
