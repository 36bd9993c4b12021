#include <gtest/gtest.h>
#include <sys/time.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <map>
#include <string>
#include <vector>

#include "qerr/diagnose/diagnosis.hpp"
#include "support/random_evidence.hpp"
#include "support/tracked_arm.hpp"

namespace qerr::testing {
namespace {

constexpr double most_seconds = 3;  ///< of CPU, for one log; 0.4 is usual, and twice that on a busy machine
volatile std::sig_atomic_t present_seed = 0;

void report_endless(int) {
  std::array<char, 80> text;
  const int size = std::snprintf(text.data(), text.size(), "no end after %g s: seed %d\n", 10 * most_seconds,
                                 static_cast<int>(present_seed));
  if (write(STDERR_FILENO, text.data(), static_cast<std::size_t>(size)) < 0) std::abort();
  _exit(1);
}

/// Ends the process, naming the seed, where one log takes ten times what it may.
class Watch {
 public:
  explicit Watch(int seed) {
    present_seed = seed;
    std::signal(SIGPROF, report_endless);
    set(10 * most_seconds);
  }
  ~Watch() { set(0); }

 private:
  static void set(double seconds) {
    const itimerval timer{{0, 0}, {static_cast<time_t>(seconds), 0}};
    setitimer(ITIMER_PROF, &timer, nullptr);
  }
};

/// A motion of one joint about `centre`: at rest, a sine, a ramp, a step, a triangle, a random walk.
std::vector<double> motion(Dice& dice, std::size_t rows, double size) {
  const std::size_t kind = dice.below(6);
  const double centre = dice.chance(0.5) ? 0 : dice.between(-2, 2), periods = dice.between(0.3, 12);
  std::vector<double> x(rows);
  double walk = 0;
  for (std::size_t k = 0; k < rows; ++k) {
    const double part = static_cast<double>(k) / static_cast<double>(rows);
    walk += dice.between(-1, 1) * size / std::sqrt(static_cast<double>(rows));
    x[k] = centre + std::array<double, 6>{0,
                                          size * std::sin(2 * std::numbers::pi * periods * part),
                                          size * part,
                                          part < 0.5 ? 0 : size,
                                          size * (1 - std::abs(std::fmod(4 * periods * part, 4) - 2)),
                                          walk}[kind];
  }
  return x;
}

/// What an encoder adds, of one kind of many, at a row.
double error_at(std::size_t kind, double x, std::size_t k, std::size_t rows, Dice& dice) {
  const double part = static_cast<double>(k) / static_cast<double>(rows);
  return std::array<double, 8>{
      1, std::sin(3 * x + 1),          part < 0.5 ? 0.0 : 1.0, part, gaussian(dice), 1 - std::exp(-5 * part),
      x, dice.chance(0.03) ? 1.0 : 0.0}[kind];
}

/// Faults of a column: outliers, steps, held and constant values, wraps, zeros.
void spoil(std::vector<double>& x, Dice& dice, double step) {
  const std::size_t n = x.size(), at = dice.below(n), end = std::min(n, at + 1 + dice.below(n)),
                    rows = 1 + dice.below(8);
  const double jump = step * std::round(std::pow(10, dice.between(0, 5))), turn = step * 4096;
  switch (dice.below(8)) {
    case 0:
      x[at] += jump;
      break;
    case 1:
      for (std::size_t k = at; k < n; ++k) x[k] -= jump;
      break;
    case 2:
      std::fill(x.begin() + static_cast<std::ptrdiff_t>(at), x.begin() + static_cast<std::ptrdiff_t>(end),
                x[at]);
      break;
    case 3:
      std::fill(x.begin(), x.end(), x[0]);
      break;
    case 4:
      for (double& v : x) v -= turn * std::round(v / turn);
      break;
    case 5:
      for (std::size_t k = 0; k < n; ++k) x[k] = x[k - k % rows];
      break;
    case 6:
      x[at] = 0;
      break;
    default:
      for (double& v : x) v *= 2;
  }
}

/// A log of one or two joints, perhaps with a tracked tip, without time, with efforts and temperatures.
class SpoiltLog {
 public:
  SpoiltLog(Dice& dice, const OperationalModel& model, const Arm& arm) : dice_(dice) {
    rows_ = 2 + dice.below(dice.chance(0.1) ? 199 : 45);
    if (!dice.chance(0.15)) add(LogSignal::time, 0, times());
    std::vector<std::vector<double>> paths;
    const bool tip_only = arm.size() > 1 && dice.chance(0.25);
    for (std::size_t i = 0; i < arm.size(); ++i) paths.push_back(joint(i, model, !tip_only));
    if (arm.size() > 1 && dice.chance(0.5)) tip(arm, paths);
    log_.rows = rows_;
    log_.values.resize(static_cast<Eigen::Index>(rows_), static_cast<Eigen::Index>(columns_.size()));
    for (std::size_t c = 0; c < columns_.size(); ++c)
      for (std::size_t k = 0; k < rows_; ++k)
        log_.values(static_cast<Eigen::Index>(k), static_cast<Eigen::Index>(c)) = columns_[c][k];
  }

  const Log& log() const { return log_; }

 private:
  void add(LogSignal signal, std::size_t index, std::vector<double> values, int decimals = 9) {
    LogColumn c;
    c.signal = signal, c.index = index;
    c.header = "column " + std::to_string(columns_.size());
    c.text = {decimals, decimals, 9};
    const double grid = std::pow(10.0, -decimals);
    for (double& v : values) v = std::round(v / grid) * grid;
    columns_.push_back(std::move(values));
    log_.columns.push_back(c);
  }

  std::vector<double> times() {
    const double interval = std::pow(10, -static_cast<double>(dice_.below(4)));
    const bool uneven = dice_.chance(0.15), same = dice_.chance(0.03);
    std::vector<double> t(rows_);
    for (std::size_t k = 1; k < rows_; ++k)
      t[k] = same ? 0 : t[k - 1] + interval * (dice_.chance(0.02) ? 2 : uneven ? dice_.between(0.5, 1.5) : 1);
    return t;
  }

  std::vector<double> joint(std::size_t i, const OperationalModel& model, bool with_reference) {
    const double step = model.transmission.encoders[i].resolution;
    const std::vector<double> path =
        motion(dice_, rows_, std::min(6.0, step * std::pow(10, dice_.between(-1, 4))));
    std::vector<double> counts = path, reference = path;
    for (std::size_t more = dice_.below(3); more > 0; --more) {
      const std::size_t kind = dice_.below(8);
      const double size = step * std::pow(10, dice_.between(-1, 3));
      for (std::size_t k = 0; k < rows_; ++k) counts[k] += size * error_at(kind, path[k], k, rows_, dice_);
    }
    const double noise = step * std::array<double, 5>{0, 1e-3, 0.05, 0.3, 2}[dice_.below(5)];
    for (std::size_t k = 0; k < rows_; ++k) {
      counts[k] = std::round(counts[k] / step);
      reference[k] += noise * gaussian(dice_);
    }
    for (std::size_t more = dice_.below(3); more > 0; --more)
      dice_.chance(0.5) ? spoil(counts, dice_, 1) : spoil(reference, dice_, step);
    add(LogSignal::counts, i, counts, 0);
    if (with_reference) add(LogSignal::reference, i, reference, dice_.chance(0.2) ? 3 : 9);
    std::vector<double> load(rows_), warm(rows_);
    for (std::size_t k = 0; k < rows_; ++k)
      load[k] = 5 * std::cos(path[k]), warm[k] = 0.1 * static_cast<double>(k);
    if (dice_.chance(0.2)) add(LogSignal::effort, i, load);
    if (dice_.chance(0.15)) add(LogSignal::temperature, i, warm, 2);
    return path;
  }

  void tip(const Arm& arm, const std::vector<std::vector<double>>& paths) {
    std::array<std::vector<double>, 3> p;
    const double noise = dice_.chance(0.5) ? 0 : 1e-4;
    for (std::size_t k = 0; k < rows_; ++k) {
      Eigen::VectorXd q(static_cast<Eigen::Index>(paths.size()));
      for (std::size_t i = 0; i < paths.size(); ++i) q[static_cast<Eigen::Index>(i)] = paths[i][k];
      const Eigen::Vector3d at = arm.tip(q);
      for (std::size_t c = 0; c < 3; ++c)
        p[c].push_back(at[static_cast<Eigen::Index>(c)] + noise * gaussian(dice_));
    }
    if (dice_.chance(0.2)) p[0][dice_.below(rows_)] += 1;
    for (std::size_t c = 0; c < 3; ++c) add(LogSignal::tip, c, p[c], 7);
  }

  Dice& dice_;
  std::size_t rows_ = 0;
  Log log_;
  std::vector<std::vector<double>> columns_;
};

double cpu_seconds() {
  timespec t;
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

// QERR_SPOILT_LOGS=100000 tries more of them.
TEST(Diagnose, EndsForEverySpoiltLog) {
  const char* more = std::getenv("QERR_SPOILT_LOGS");
  const int logs = more ? std::atoi(more) : 300;
  std::map<Verdict, int> verdicts;
  double longest = 0;
  for (int seed = 1; seed <= logs; ++seed) {
    Dice dice(static_cast<std::uint64_t>(seed));
    const Arm arm = random_arm(dice, dice.chance(0.3) ? 2 : 1);
    std::vector<double> resolutions;
    for (std::size_t i = 0; i < arm.size(); ++i) resolutions.push_back(std::pow(10, dice.between(-6, -1)));
    OperationalModel model = arm.model(resolutions);
    for (Encoder& e : model.transmission.encoders) {
      e.zero_known = dice.chance(0.7), e.rounding = dice.chance(0.8) ? Rounding::nearest : Rounding::down;
      e.shaft_ratio = dice.chance(0.5) ? 1 : dice.between(2, 100);
      if (dice.chance(0.2)) e.counts_per_period = 256;
    }
    const SpoiltLog spoilt(dice, model, arm);
    DiagnoseOptions options;
    options.threads = 1;
    const Watch watch(seed);
    const double before = cpu_seconds();
    const Diagnosis d = diagnose(model, {}, {}, spoilt.log(), options);
    longest = std::max(longest, cpu_seconds() - before);
    EXPECT_LT(cpu_seconds() - before, most_seconds) << "seed " << seed;
    ++verdicts[d.verdict];
  }
  if (more) std::printf("longest: %g s\n", longest);
  // The logs are of many kinds: each verdict occurs.
  EXPECT_EQ(verdicts.size(), 6u);
}

}  // namespace
}  // namespace qerr::testing
