#include <algorithm>
#include <cmath>

#include "filter/norms/transient.hpp"
#include "qerr/core/quantity.hpp"
#include "qerr/filter/norms.hpp"
#include "qerr/report/filter_report.hpp"
#include "report/csv_text.hpp"

namespace qerr {

namespace {

/// Every n-th sample of a filter's memory.
struct Thinning {
  std::size_t count, every;
};

/// Until the slowest pole has decayed to exp(-30); at most 1e5 samples of the first 2e7.
Thinning thinning(const Filter& filter) {
  constexpr double most_written = 1e5, most_computed = 2e7;
  const double modulus = poles_max_modulus(filter);
  const double decay = modulus < 1 ? -30 / std::log(std::max(modulus, 1e-3)) : INFINITY;
  const double wanted = std::min(16 + static_cast<double>(filter.taps.size()) + decay, most_computed);
  const double every = std::ceil(wanted / most_written);
  return {static_cast<std::size_t>(wanted / every), static_cast<std::size_t>(every)};
}

}  // namespace

std::string response_csv(const FilterReport& report) {
  constexpr int points = 500;
  std::string out = "filter,frequency [Hz],magnitude,phase [rad]\r\n";
  for (const FilterFigures& f : report.filters) {
    const double last = 0.5 * f.filter.sample_rate;
    const double first = std::min(1e-5 * f.filter.sample_rate, 1e-3 * f.bandwidth.value_or(last));
    for (int i = 0; i <= points; ++i) {
      const double frequency =
          i == points ? last : first * std::pow(last / first, static_cast<double>(i) / points);
      const std::complex<double> h = response(f.filter, frequency);
      out += csv_cell(f.name) + ',' + shortest(frequency) + ',' + shortest(std::abs(h)) + ',' +
             shortest(std::arg(h)) + "\r\n";
    }
  }
  return out;
}

std::string impulse_csv(const FilterReport& report) {
  std::string out = "filter,time [s],value\r\n";
  for (const FilterFigures& f : report.filters) {
    const Thinning t = thinning(f.filter);
    const std::vector<double> h = impulse_response(f.filter, t.count, t.every);
    for (std::size_t k = 0; k < h.size(); ++k)
      out += csv_cell(f.name) + ',' + shortest(static_cast<double>(k * t.every) / f.filter.sample_rate) +
             ',' + shortest(h[k]) + "\r\n";
  }
  return out;
}

std::string transient_csv(const Spec& spec) {
  std::string out = "filter,time [s],sigma_over_input,steady_state\r\n";
  for (const NamedFilter& named : spec.filters) {
    const Thinning t = thinning(named.filter);
    const std::vector<double> sigma = noise_transient(named.filter, t.count, t.every);
    for (std::size_t k = 0; k < sigma.size(); ++k) {
      out += csv_cell(named.name) + ',' +
             shortest(static_cast<double>(k * t.every) / named.filter.sample_rate) + ',' +
             shortest(sigma[k]) + ',' + shortest(named.norms.h2) + "\r\n";
      if (sigma[k] >= 0.9999 * named.norms.h2) break;
    }
  }
  return out;
}

}  // namespace qerr
