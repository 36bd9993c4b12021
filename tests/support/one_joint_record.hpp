#pragma once

#include <array>
#include <cmath>
#include <numbers>
#include <random>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "qerr/bound/operational_error.hpp"
#include "qerr/filter/family.hpp"
#include "qerr/simulate/log.hpp"

/// The record of one joint from physics: a path, edges, a counter, a file. No code is shared with the
/// library's inference.
namespace qerr {

using Column = Eigen::ArrayXd;

struct Machine {
  std::mt19937 dice;
  int rows = 0;
  double rate = 0, resolution = 0, noise = 0;
  Column time, path;
  std::vector<std::pair<double, std::array<double, 2>>> sines;  // amplitude, {angular frequency, phase}
  double centre = 0;

  explicit Machine(unsigned seed) : dice(seed) {
    rows = 1500 + static_cast<int>(dice() % 4000);
    rate = std::array<double, 4>{250, 500, 1000, 2000}[dice() % 4];
    resolution = between(2e-5, 3e-4);
    noise = between(0.01, 0.1) * resolution;
    centre = between(-0.3, 0.3);
    const double base = between(1, 2.5) * rate / rows;
    sines = {{between(0.3, 0.9), {2 * std::numbers::pi * base, between(0, 6.28)}},
             {between(0.03, 0.1), {2 * std::numbers::pi * 3.7 * base, between(0, 6.28)}}};
    time = Column::LinSpaced(rows, 0, rows - 1) / rate;
    path = along(time);
  }

  double between(double low, double high) { return std::uniform_real_distribution<double>(low, high)(dice); }
  double normal() { return std::normal_distribution<double>()(dice); }

  Column along(const Column& t) const {
    Column q = Column::Constant(t.size(), centre);
    for (const auto& [a, wave] : sines) q += a * (wave[0] * t + wave[1]).sin();
    return q;
  }

  /// The counter of an ideal encoder: the number of edges at (k + 1/2) resolution between zero and x.
  Column counted(const Column& x) const {
    return x.unaryExpr([this](double v) { return std::ceil(v / resolution - 0.5); });
  }

  Column reference() {
    Column read = path;
    for (double& x : read) x += noise * normal();
    return read;
  }
};

inline OperationalModel model_of(const Machine& m) {
  OperationalModel model;
  IndependentJoint joint;
  joint.name = "arm";
  model.chain.independent = {joint};
  model.transmission.encoders = {{m.resolution}};
  model.transmission.coupling = Eigen::MatrixXd::Identity(1, 1);
  return model;
}

struct Written {
  LogSignal signal;
  Column values;
  int decimals = 9;
};

inline Log log_of(const std::vector<Written>& columns) {
  Log log;
  log.rows = static_cast<std::uint64_t>(columns[0].values.size());
  log.values.resize(columns[0].values.size(), static_cast<Eigen::Index>(columns.size()));
  for (std::size_t i = 0; i < columns.size(); ++i) {
    LogColumn c;
    c.signal = columns[i].signal;
    c.header = "column " + std::to_string(i);
    c.unit = "rad";
    c.text = {columns[i].decimals, columns[i].decimals, 9};
    const double grid = std::pow(10.0, -columns[i].decimals);
    log.values.col(static_cast<Eigen::Index>(i)) = (columns[i].values / grid).round() * grid;
    log.columns.push_back(c);
  }
  return log;
}

inline Log log_of(Machine& m, const Column& counts) {
  return log_of(
      {{LogSignal::time, m.time}, {LogSignal::counts, counts, 0}, {LogSignal::reference, m.reference()}});
}

inline Filter first_order(double rate, int order, double cutoff) {
  for (const FilterFamily& f : filter_families())
    if (f.name == "first_order")
      return f.design({1, rate, {{"order", order}, {"cutoff", cutoff}}, {{"discretization", "matched"}}, {}});
  throw std::logic_error("no such family");
}

/// A back difference and one-pole low-passes, started in the steady state of the first motion.
inline Column controller_velocity(const Machine& m, const Column& position, int order, double cutoff) {
  const double pole = std::exp(-2 * std::numbers::pi * cutoff / m.rate);
  Column v(position.size());
  v[0] = (position[1] - position[0]) * m.rate;
  for (Eigen::Index k = 1; k < v.size(); ++k) v[k] = (position[k] - position[k - 1]) * m.rate;
  for (int i = 0; i < order; ++i) {
    double last = v.head(20).mean();
    for (double& x : v) x = last = pole * last + (1 - pole) * x;
  }
  return v;
}

}  // namespace qerr
