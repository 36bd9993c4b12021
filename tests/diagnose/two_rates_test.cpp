#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

#include "qerr/diagnose/diagnosis.hpp"
#include "support/one_joint_record.hpp"

namespace qerr {
namespace {

/// A reference that is slower than the encoder and noisy: its samples, and its values at all rows.
struct SlowReference {
  Column time, samples;

  SlowReference(Machine& m, double rate, double noise) {
    const auto count = static_cast<Eigen::Index>(m.time[m.rows - 1] * rate) - 1;
    time = m.between(0.1, 0.9) / rate + Column::LinSpaced(count, 0, static_cast<double>(count - 1)) / rate;
    samples = m.along(time);
    for (double& x : samples) x += noise * m.normal();
  }

  std::shared_ptr<const ColumnSamples> all() const {
    return std::make_shared<ColumnSamples>(
        ColumnSamples{{time.begin(), time.end()}, {samples.begin(), samples.end()}});
  }

  /// Lagrange's polynomial through some samples about each instant.
  Column at(const Column& instants, Eigen::Index samples_of_it) const {
    const double step = time[1] - time[0];
    return instants.unaryExpr([&](double t) {
      const auto below = static_cast<Eigen::Index>(std::floor((t - time[0]) / step));
      const Eigen::Index first =
          std::clamp<Eigen::Index>(below - samples_of_it / 2 + 1, 0, time.size() - samples_of_it);
      double sum = 0;
      for (Eigen::Index i = first; i < first + samples_of_it; ++i) {
        double weight = 1;
        for (Eigen::Index k = first; k < first + samples_of_it; ++k)
          if (k != i) weight *= (t - time[k]) / (time[i] - time[k]);
        sum += weight * samples[i];
      }
      return sum;
    });
  }
};

/// The rows that samples enclose.
Log log_at(Machine& m, const Column& counts, const SlowReference& reference, Eigen::Index samples_of_it) {
  const auto inside = [&](double t) {
    return t >= reference.time[0] && t <= reference.time[reference.time.size() - 1];
  };
  const auto first = std::find_if(m.time.begin(), m.time.end(), inside) - m.time.begin();
  const auto rows = Eigen::seqN(first, std::count_if(m.time.begin(), m.time.end(), inside));
  const Column time = m.time(rows);
  return qerr::log_of({{LogSignal::time, time},
                       {LogSignal::counts, counts(rows), 0},
                       {LogSignal::reference, reference.at(time, samples_of_it), 12}});
}

void set_pace(Machine& m) {
  m.rate = 1000, m.rows = 20000;
  m.sines = {{0.9, {2 * std::numbers::pi * m.between(0.1, 0.3), m.between(0, 6)}},
             {0.12, {2 * std::numbers::pi * m.between(0.5, 0.9), m.between(0, 6)}}};
  m.resolution = 3e-5;
  m.time = Column::LinSpaced(m.rows, 0, m.rows - 1) / m.rate;
  m.path = m.along(m.time);
}

/// Between the samples of a slower file the reference's noise is alike from row to row: no error of the
/// encoder, and no structure.
TEST(TwoRates, ACleanMachineStaysClean) {
  for (unsigned seed = 1; seed <= 4; ++seed) {
    Machine m(300 + seed);
    set_pace(m);
    const double rate = m.between(80, 300), noise = m.between(0.1, 0.25) * m.resolution;
    const SlowReference reference(m, rate, noise);
    Log log = log_at(m, m.counted(m.path), reference, 4);
    log.columns[2].samples = reference.all();
    const Diagnosis d = diagnose(model_of(m), {}, {}, log);
    EXPECT_EQ(d.verdict, Verdict::nothing_wrong) << seed << ' ' << rate;
    EXPECT_TRUE(std::any_of(d.data.begin(), d.data.end(), [](const DataFinding& f) {
      return f.what.find("the reference is interpolated between") != std::string::npos;
    })) << seed;
  }
}

/// Of two files at nearly one rate all rows are judged: interpolation takes a part of the reference's noise,
/// and what it leaves is not white.
TEST(TwoRates, TheNoiseOfAReferenceIsThatOfItsSamples) {
  for (unsigned seed = 1; seed <= 3; ++seed) {
    Machine m(500 + seed);
    set_pace(m);
    const double rate = m.between(800, 980), noise = m.between(0.2, 0.35) * m.resolution;
    const SlowReference reference(m, rate, noise);
    Log log = log_at(m, m.counted(m.path), reference, 4);
    log.columns[2].samples = reference.all();
    const Diagnosis d = diagnose(model_of(m), {}, {}, log);
    EXPECT_EQ(d.verdict, Verdict::nothing_wrong) << seed << ' ' << rate;
  }
}

/// Whoever made the table may have interpolated: the path bends at the readings only.
TEST(TwoRates, AStraightInterpolationIsJudgedAtItsReadings) {
  for (unsigned seed = 1; seed <= 4; ++seed) {
    Machine m(400 + seed);
    set_pace(m);
    const SlowReference reference(m, m.between(80, 150), 0.1 * m.resolution);
    const double eccentricity = seed % 2 == 0 ? m.between(3, 6) * m.resolution : 0;
    const Diagnosis d =
        diagnose(model_of(m), {}, {},
                 log_at(m, m.counted(m.path + eccentricity * (m.path + 0.4).sin()), reference, 2));
    EXPECT_TRUE(std::any_of(d.data.begin(), d.data.end(), [](const DataFinding& f) {
      return f.what.find("the reference is interpolated between") != std::string::npos;
    })) << seed;
    if (eccentricity == 0) {
      EXPECT_EQ(d.verdict, Verdict::nothing_wrong) << seed;
      continue;
    }
    ASSERT_EQ(d.causes.size(), 1U) << seed;
    EXPECT_EQ(d.causes[0].effect.type, "eccentricity") << seed;
    EXPECT_NEAR(d.causes[0].effect.number("amplitude"), eccentricity, 0.1 * eccentricity) << seed;
  }
}

/// Across a corner between two samples a cubic errs by counts: those rows show nothing of the encoder.
TEST(TwoRates, CornersOfAMotionAreNoErrors) {
  for (unsigned seed = 1; seed <= 4; ++seed) {
    Machine m(600 + seed);
    set_pace(m);
    const double noise = 0.2 * m.resolution, period = m.between(1.5, 4), phase = m.between(0, 1);
    const auto triangle = [&](double t) { return std::abs(std::remainder(t / period + phase, 1.0)); };
    SlowReference reference(m, m.between(80, 300), 0);
    for (Eigen::Index i = 0; i < reference.time.size(); ++i)
      reference.samples[i] = triangle(reference.time[i]) + noise * m.normal();
    Log log = log_at(m, m.counted(m.time.unaryExpr(triangle)), reference, 4);
    log.columns[2].samples = reference.all();
    const Diagnosis d = diagnose(model_of(m), {}, {}, log);
    EXPECT_EQ(d.verdict, Verdict::nothing_wrong) << seed;
    EXPECT_TRUE(std::any_of(d.data.begin(), d.data.end(), [](const DataFinding& f) {
      return f.what.find("faster than the samples of the reference show") != std::string::npos;
    })) << seed;
  }
}

/// The rows of a table without a time may be in any order.
TEST(TwoRates, ATableWithoutATimeHasNoOrder) {
  for (unsigned seed = 1; seed <= 4; ++seed) {
    Machine m(700 + seed);
    set_pace(m);
    std::vector<Eigen::Index> rows(400);
    for (std::size_t i = 0; i < rows.size(); ++i) rows[i] = static_cast<Eigen::Index>(50 * i);
    const double amplitude = m.between(3, 6) * m.resolution;
    const Column counts = m.counted(m.path + amplitude * (m.path + 0.4).sin());
    const auto answer = [&] {
      return diagnose(
          model_of(m), {}, {},
          qerr::log_of({{LogSignal::counts, counts(rows), 0}, {LogSignal::reference, m.path(rows), 12}}));
    };
    const Diagnosis one = answer();
    std::shuffle(rows.begin(), rows.end(), m.dice);
    const Diagnosis other = answer();
    EXPECT_EQ(one.verdict, other.verdict) << seed;
    ASSERT_FALSE(one.causes.empty()) << seed;
    ASSERT_EQ(one.causes.size(), other.causes.size()) << seed;
    EXPECT_EQ(one.causes[0].effect.numbers, other.causes[0].effect.numbers) << seed;
    EXPECT_EQ(one.gain.rms_after, other.gain.rms_after) << seed;
  }
}

}  // namespace
}  // namespace qerr
