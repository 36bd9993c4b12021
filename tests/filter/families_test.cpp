#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <fstream>
#include <nlohmann/json.hpp>
#include <numbers>
#include <set>

#include "qerr/core/error.hpp"
#include "qerr/filter/norms.hpp"
#include "support/design_filter.hpp"
#include "support/measured.hpp"
#include "support/sample_filters.hpp"

namespace qerr {
namespace {

/// tests/golden/filters.json, by make_filters.py: mpmath and scipy, independent of qerr.
nlohmann::json golden() {
  std::ifstream file(std::string(QERR_SOURCE_DIR) + "/tests/golden/filters.json");
  return nlohmann::json::parse(file);
}

Filter filter_of(const nlohmann::json& row) {
  if (row.contains("family")) {
    const SampleFilter sample{row["family"], row["numbers"], row["choices"]};
    return designed(sample, row["derivative"], row["sample_rate"]);
  }
  std::map<std::string, Rows> values;
  for (const auto& [key, rows] : row["values"].items()) values[key] = rows.get<Rows>();
  for (const FilterRepresentation& r : filter_representations())
    if (r.key.name == row["representation"].get<std::string>()) return r.build(values, 1000, 0);
  throw std::runtime_error("no representation " + row["representation"].get<std::string>());
}

std::string title(const nlohmann::json& row) {
  nlohmann::json short_row = row;
  short_row.erase("impulse");
  return short_row.dump().substr(0, 300);
}

TEST(EveryFamily, HasASampleDesign) {
  std::set<std::string> sampled;
  for (const SampleFilter& s : sample_filters()) sampled.insert(s.family);
  for (const FilterFamily& family : filter_families())
    EXPECT_TRUE(sampled.contains(std::string(family.name)));
  EXPECT_EQ(sampled.size(), filter_families().size());
}

TEST(EveryFamily, HasTheParametersOfItsSample) {
  for (const SampleFilter& s : sample_filters()) {
    for (const FilterFamily& family : filter_families()) {
      if (family.name != s.family) continue;
      const auto knows = [&](const std::string& name, Kind kind) {
        return std::any_of(family.parameters.begin(), family.parameters.end(), [&](const Parameter& p) {
          return p.name == name && (kind == Kind::choice) == (p.kind == Kind::choice) && !p.meaning.empty();
        });
      };
      for (const auto& [name, value] : s.numbers) EXPECT_TRUE(knows(name, Kind::number)) << s.family << name;
      for (const auto& [name, value] : s.choices) EXPECT_TRUE(knows(name, Kind::choice)) << s.family << name;
    }
  }
}

TEST(EveryFamily, TendsToItsPowerOfFrequency) {
  for (const SampleFilter& s : sample_filters()) {
    for (int d = 0; d <= s.most_derivative; ++d) {
      const Filter filter = designed(s, d);
      for (const double f : {1e-9, 1e-7}) {
        const auto ideal =
            s.low_frequency_gain * std::pow(std::complex<double>(0, 2 * std::numbers::pi * f), d);
        EXPECT_LT(std::abs(response(filter, f) / ideal - 1.0), 1e-7) << s.family << d;
      }
      EXPECT_EQ(dc_gain(filter) != 0, d == 0) << s.family << d;
    }
  }
}

TEST(EveryFamily, ReproducesARamp) {
  for (const SampleFilter& s : sample_filters()) {
    for (int d = 0; d <= std::min(s.most_derivative, 4); ++d) {  // beyond, the sums below cancel
      // The response to t^d/d! tends to 1: the d-fold running sum of h is its response to a d-fold summed
      // step, which differs from t^d/d! by lower powers only.
      const Filter filter = designed(s, d);
      std::vector<double> h = impulse_response(filter, 600);
      for (int i = 0; i <= d; ++i) {
        long double sum = 0;
        for (double& x : h) {
          sum += static_cast<long double>(x) / (i == 0 ? 1 : 1000);
          x = static_cast<double>(sum);
        }
      }
      EXPECT_NEAR(h.back(), s.low_frequency_gain, 1e-8 * std::pow(20, d)) << s.family << d;  // h is rounded
    }
  }
}

TEST(EveryFamily, IsStableAndHasNorms) {
  for (const SampleFilter& s : sample_filters()) {
    for (int d = 0; d <= s.most_derivative; ++d) {
      const Filter filter = designed(s, d);
      EXPECT_LT(poles_max_modulus(filter), 1) << s.family;
      long double squares = 0, sum = 0;
      for (const double h : impulse_response(filter, 8000)) {
        squares += static_cast<long double>(h) * h;
        sum += std::abs(h);
      }
      const Norms n = norms(filter);
      EXPECT_NEAR(n.h2 / static_cast<double>(std::sqrt(squares)), 1, 1e-12) << s.family << d;
      EXPECT_LE(n.l1.lower, static_cast<double>(sum) * (1 + 1e-13)) << s.family << d;
      EXPECT_GE(n.l1.upper, static_cast<double>(sum) * (1 - 1e-13)) << s.family << d;
      EXPECT_LT(n.l1.upper - n.l1.lower, 1e-12 * n.l1.upper) << s.family << d;
    }
  }
}

TEST(EveryFamily, HasTheGroupDelayOfItsPhase) {
  for (const SampleFilter& s : sample_filters()) {
    for (int d = 0; d <= s.most_derivative; ++d) {
      const Filter filter = designed(s, d);
      const double f = 1e-2;
      const double phase = std::arg(response(filter, f) / std::pow(std::complex<double>(0, 1), d));
      EXPECT_NEAR(-phase / (2 * std::numbers::pi * f), group_delay(filter), 1e-8) << s.family << d;
    }
  }
}

TEST(EveryFamily, RejectsDerivativesBeyondItsOrder) {
  for (const SampleFilter& s : sample_filters()) {
    const Fault fault = refusal([&] { designed(s, s.most_derivative + 1); });
    EXPECT_TRUE(fault.key == "derivative" || fault.key == "polynomial_order") << s.family << ' ' << fault.key;
  }
}

TEST(EveryFamily, RejectsACutoffAtOrAboveNyquist) {
  for (SampleFilter s : sample_filters()) {
    if (!s.numbers.contains("cutoff")) continue;
    s.numbers["cutoff"] = 499.9;
    EXPECT_NO_THROW(designed(s, 1));
    for (const double cutoff : {500.0, 600.0}) {
      s.numbers["cutoff"] = cutoff;
      const Fault fault = refusal([&] { designed(s, 1); });
      EXPECT_EQ(fault.key, "cutoff");
      EXPECT_EQ(fault.rule, "the cut-off must lie below half the sample rate");
      EXPECT_EQ(fault.found, cutoff == 500 ? "500 Hz at 1000 Hz" : "600 Hz at 1000 Hz");
    }
    s.numbers["cutoff"] = 50;
    for (const double order : {2.5, 21.0}) {
      s.numbers["order"] = order;
      EXPECT_EQ(refusal([&] { designed(s, 1); }).key, "order");
    }
  }
}

TEST(H2Norm, OfEveryGoldenFilterIsThatOfMpmathTo1e13) {
  double worst = 0;
  for (const nlohmann::json& row : golden()) {
    const double exact = std::stod(row["h2"].get<std::string>());
    const double error = std::abs(h2_norm(filter_of(row)) / exact - 1);
    EXPECT_LT(error, 1e-13) << title(row);
    worst = std::max(worst, error);
  }
  RecordProperty("worst_relative_error", std::to_string(worst * 1e15) + "e-15");
}

TEST(ImpulseResponse, OfEveryGoldenFilterIsThatOfMpmath) {
  for (const nlohmann::json& row : golden()) {
    const std::vector<double> h = impulse_response(filter_of(row), row["impulse"].size());
    double largest = 0;
    for (const auto& x : row["impulse"])
      largest = std::max(largest, std::abs(std::stod(x.get<std::string>())));
    for (std::size_t k = 0; k < h.size(); ++k)
      EXPECT_NEAR(h[k], std::stod(row["impulse"][k].get<std::string>()), 2e-14 * largest) << k << title(row);
  }
}

TEST(Chebyshev, StaysWithinItsRippleAndItsAttenuation) {
  const auto decibels = [](const Filter& filter, double f) {
    return 20 * std::log10(std::abs(response(filter, f)));
  };
  for (const double order : {2., 3., 5., 8.}) {
    const Filter one = designed({"chebyshev1", {{"order", order}, {"cutoff", 50}, {"ripple", 0.5}}, {}}, 0);
    const Filter two =
        designed({"chebyshev2", {{"order", order}, {"cutoff", 50}, {"attenuation", 40}}, {}}, 0);
    const Filter both = designed(
        {"elliptic", {{"order", order}, {"cutoff", 50}, {"ripple", 0.5}, {"attenuation", 40}}, {}}, 0);
    EXPECT_NEAR(decibels(one, 50), -0.5, 1e-11);
    EXPECT_NEAR(decibels(two, 50), -40, 1e-11);
    EXPECT_NEAR(decibels(both, 50), -0.5, 1e-11);
    for (double f = 0; f <= 50; f += 0.5) {
      EXPECT_LE(std::abs(decibels(one, f) + 0.25), 0.25 + 1e-11) << f;
      EXPECT_LE(std::abs(decibels(both, f) + 0.25), 0.25 + 1e-11) << f;
      EXPECT_LE(decibels(two, 50 + 9 * f), -40 + 1e-9) << f;
    }
  }
}

TEST(Bessel, HasTheDelayOrTheCutoffOfItsNormalization) {
  for (const double order : {1., 2., 6., 15.}) {
    const auto bessel = [&](const char* normalization) {
      return designed({"bessel", {{"order", order}, {"cutoff", 2}}, {{"normalization", normalization}}}, 0);
    };
    const double warped = std::tan(std::numbers::pi * 2 / 1000) * 2000;  // [rad/s]
    EXPECT_NEAR(group_delay(bessel("delay")) * warped, 1, 1e-14);
    EXPECT_NEAR(std::norm(response(bessel("magnitude"), 2)), 0.5, 1e-13);
  }
}

TEST(Trackers, FollowTheirModelWithoutLag) {
  for (const double index : {1e-6, 0.01, 1.0, 100.0}) {
    EXPECT_NEAR(group_delay(designed({"alpha_beta", {{"tracking_index", index}}, {}}, 0)), 0, 1e-18);
    for (const int d : {0, 1})
      EXPECT_NEAR(group_delay(designed({"alpha_beta_gamma", {{"tracking_index", index}}, {}}, d)), 0, 1e-18);
  }
}

TEST(Trackers, LagTheirLastDerivativeByTheStatedTime) {
  const double a = 0.5, b = 0.2, g = 0.05;
  EXPECT_NEAR(group_delay(designed({"alpha_beta", {{"alpha", a}, {"beta", b}}, {}}, 1)), (a / b - 0.5) / 1000,
              1e-17);
  const SampleFilter third{"alpha_beta_gamma", {{"alpha", a}, {"beta", b}, {"gamma", g}}, {}};
  EXPECT_NEAR(group_delay(designed(third, 2)), (2 * b / g - 0.5) / 1000, 1e-17);
}

TEST(TrackingLoop, IsTheLoopThatDrivesRun) {
  // ODrive's default, bandwidth 1000 rad/s at 8 kHz, against its recursion on an impulse.
  const Filter loop = designed({"tracking_loop", {{"bandwidth", 1000}}, {}}, 1, 8000);
  const double period = 1.0 / 8000, kp = 2 * 1000, ki = kp * kp / 4;
  const std::vector<double> h = impulse_response(loop, 400);
  double x = 0, v = 0, square = 0;
  for (std::size_t k = 0; k < h.size(); ++k) {
    x += period * v;
    const double r = (k == 0 ? 1 : 0) - x;
    x += period * kp * r;
    v += period * ki * r;
    EXPECT_NEAR(h[k], v, 1e-10);
    square += v * v;
  }
  EXPECT_NEAR(h2_norm(loop), std::sqrt(square), 1e-9);
  EXPECT_NEAR(h2_norm(loop), 189.4, 0.05);
  EXPECT_EQ(impulse_response(designed({"tracking_loop", {{"kp", kp}, {"ki", ki}}, {}}, 1, 8000), 9),
            impulse_response(loop, 9));
  EXPECT_NE(refusal([&] {
              designed({"tracking_loop", {{"bandwidth", 1000}}, {}}, 1, 800);
            }).rule.find("stable"),
            std::string::npos);
}

TEST(AlphaBeta, RejectsUnstableGains) {
  const auto tried = [](double alpha, double beta) {
    return refusal([&] { designed({"alpha_beta", {{"alpha", alpha}, {"beta", beta}}, {}}, 1); });
  };
  EXPECT_EQ(tried(1.5, 1.0).found, "alpha 1.5, beta 1");
  EXPECT_NE(tried(1.5, 1.0).rule.find("2 alpha + beta < 4"), std::string::npos);
  EXPECT_EQ(tried(0.0, 0.1).key, "alpha");
  EXPECT_EQ(tried(0.5, 0.0).key, "beta");
  EXPECT_NO_THROW(designed({"alpha_beta", {{"alpha", 1.5}, {"beta", 0.999}}, {}}, 1));
  const auto damped = [&](double damping) {
    designed({"alpha_beta", {{"alpha", 0.75}, {"damping", damping}}, {}}, 1);
  };
  EXPECT_EQ(refusal([&] { damped(0.5); }).key, "damping");
  EXPECT_NO_THROW(damped(0.61));
}

/// alpha (4 beta + gamma) > 2 gamma, against the poles of the recursion.
TEST(AlphaBetaGamma, IsRejectedIfItsRecursionGrows) {
  int refused = 0, accepted = 0;
  for (double alpha = 0.1; alpha < 2; alpha += 0.3) {
    for (double beta = 0.05; beta < 4; beta += 0.31) {
      for (double gamma = 0.01; gamma < 8; gamma *= 2.3) {
        double x = 1, v = 0, a = 0, late = 0, state = 1;
        for (int k = 0; k < 40000; ++k) {
          x += v + a / 2;
          v += a;
          const double r = -x;
          x += alpha * r;
          v += beta * r;
          a += gamma / 2 * r;
          state = std::max({std::abs(x), std::abs(v), std::abs(a)});
          if (k >= 20000) late = std::max(late, state);
          if (!(state < 1e6)) break;
        }
        const bool decays = state < 1e6 && late < 1e-3;
        bool taken = true;
        try {
          designed({"alpha_beta_gamma", {{"alpha", alpha}, {"beta", beta}, {"gamma", gamma}}, {}}, 1);
        } catch (const Error&) {
          taken = false;
        }
        EXPECT_EQ(taken, decays) << alpha << ' ' << beta << ' ' << gamma;
        ++(taken ? accepted : refused);
      }
    }
  }
  EXPECT_GT(refused, 50);
  EXPECT_GT(accepted, 50);
}

TEST(Parameters, ThatDefineNoFilterAreRejectedWithARemedy) {
  const auto tried = [](const char* family, std::map<std::string, double> numbers) {
    return refusal([&] { designed({family, numbers, {}}, 1); });
  };
  EXPECT_EQ(tried("exponential_moving_average", {}).remedy, "give alpha, or time_constant, or span");
  EXPECT_EQ(tried("exponential_moving_average", {{"alpha", 0.1}, {"span", 3}}).found, "alpha, span");
  EXPECT_EQ(tried("kalman", {{"process_noise", 1}}).remedy,
            "give process_noise and measurement_noise, or tracking_index");
  EXPECT_EQ(tried("alpha_beta", {{"alpha", 1}}).remedy,
            "give alpha and beta, or alpha and damping, or tracking_index");
  EXPECT_EQ(tried("alpha_beta_gamma", {{"alpha", 1}, {"beta", 1}}).remedy,
            "give alpha, beta and gamma, or tracking_index");
  EXPECT_EQ(tried("elliptic", {{"cutoff", 9}, {"ripple", 3}, {"attenuation", 3}}).key, "attenuation");
  EXPECT_EQ(tried("savitzky_golay", {{"window", 5}, {"polynomial_order", 5}}).key, "polynomial_order");
  EXPECT_EQ(tried("savitzky_golay", {{"window", 5}, {"polynomial_order", 0}}).key, "polynomial_order");
  EXPECT_EQ(tried("savitzky_golay", {}).key, "window");
}

/// What `Measured` says of its values holds here, too: these are the ranges of the rows themselves.
TEST(EveryFamily, PermitsTheSameParametersAsBefore) {
  const testing::Measured measured("filter_parameters.csv", 0);
  for (const FilterFamily& f : filter_families()) {
    for (const Parameter& p : f.parameters) {
      const std::string start = std::string(f.name) + '.' + std::string(p.name) + ' ';
      measured.expect(start + "least", p.least);
      measured.expect(start + "most", p.most);
      measured.expect(start + "open below", p.open_below);
      measured.expect(start + "open above", p.open_above);
      measured.expect(start + "nonzero", p.nonzero);
      measured.expect(start + "required", p.required);
      measured.expect(start + "default", p.fallback.value_or(std::nan("")));
      measured.expect(start + "choices", static_cast<double>(choices_of(p).size()));
    }
    measured.expect_all_met(std::string(f.name) + '.');
  }
}

}  // namespace
}  // namespace qerr
