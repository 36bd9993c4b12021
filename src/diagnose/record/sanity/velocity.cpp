#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "core/text.hpp"
#include "diagnose/record/sanity/sanity_steps.hpp"
#include "filter/run/filter_bank.hpp"
#include "qerr/filter/family.hpp"

/// JOINT.velocity against what filters make of the positions.
namespace qerr::sanity {

namespace {

/// A velocity, and the positions that it was made of.
struct Record {
  Eigen::ArrayXd position, velocity;
  double interval = 0;  ///< mean [s]
  double written = 0;   ///< rms that the velocity's own rounding in the file makes [rad/s]
};

/// H position over the record's later nine tenths, H run up on the first motion.
Eigen::ArrayXd made(const Record& r, const Filter& filter, Eigen::Index delay) {
  const Eigen::Index n = r.position.size(), lead = std::min<Eigen::Index>(n, 2000);
  FilterBank bank(filter, 1);
  Eigen::ArrayXd out(1);
  const Eigen::Index first = n / 10 + delay;
  Eigen::ArrayXd velocity(n - first);
  for (Eigen::Index k = -lead; k < n - delay; ++k) {
    const double before = static_cast<double>(k) * r.interval * r.velocity[0];
    out[0] = k < 0 ? before : r.position[k] - r.position[0];
    bank.step(out);
    if (k + delay >= first) velocity[k + delay - first] = out[0];
  }
  return velocity;
}

/// rms of velocity - H position.
double misfit(const Record& r, const Filter& filter, Eigen::Index delay) {
  const Eigen::ArrayXd velocity = made(r, filter, delay);
  return rms(r.velocity.tail(velocity.size()) - velocity);
}

struct Candidate {
  const char* family = "";
  int order = 0;
  double cutoff = 0;  ///< [Hz]
  Eigen::Index delay = 0;
  double misfit = 1e300;
};

Filter design(const Candidate& c, double rate) {
  for (const FilterFamily& f : filter_families())
    if (f.name == c.family) {
      FilterDesign d{1, rate, {{"order", c.order}, {"cutoff", c.cutoff}}, {}, {}};
      for (const Parameter& p : f.parameters)
        if (p.kind == Kind::choice && !p.choices.empty()) d.choices[std::string(p.name)] = choices_of(p)[0];
      return f.design(d);
    }
  return difference_filter(rate, 1);
}

/// Logarithm of the highest cut-off that is tried.
double highest(const Record& r) { return std::log(0.45 / r.interval); }

Candidate tried(const Record& r, Candidate c, double log_cutoff) {
  c.cutoff = std::exp(log_cutoff);
  c.misfit = misfit(r, design(c, 1 / r.interval), c.delay);
  return c;
}

/// The best cut-off about one, by halves from a relative step to another.
Candidate refined(const Record& r, Candidate best, double from, double to) {
  for (double about = from; about > to; about /= 2)
    for (const double by : {-about, about})
      if (const double x = std::log(best.cutoff) + by; x <= highest(r))
        if (const Candidate next = tried(r, best, x); next.misfit < best.misfit) best = next;
  return best;
}

/// The best cut-off of one family, order and delay: on a coarse grid, then about its best.
Candidate best_cutoff(const Record& r, const Candidate& c) {
  const double low = std::log(1 / (2000 * r.interval)), step = (highest(r) - low) / 14;
  Candidate best;
  for (double x = low; x <= highest(r) + 1e-9; x += step)
    if (const Candidate next = tried(r, c, x); next.misfit < best.misfit) best = next;
  return refined(r, best, step / 2, 1e-3);
}

/// 95 % interval of the cut-off: what is left, over what a change of the cut-off changes. Both are correlated
/// over the filter's memory.
FoundParameter cutoff_of(const Record& r, const Candidate& c) {
  Candidate other = c;
  other.cutoff *= 1 - 1e-4;
  const double rate = 1 / r.interval;
  const Eigen::ArrayXd here = made(r, design(c, rate), c.delay);
  const double change = rms(here - made(r, design(other, rate), c.delay)) / (c.cutoff - other.cutoff);
  const double memory = std::max(1.0, rate / (2 * std::numbers::pi * c.cutoff));
  const double left = std::max(c.misfit, r.written);
  const double wide = 1.96 * left / change * std::sqrt(memory / static_cast<double>(here.size()));
  return {"cutoff", c.cutoff, c.cutoff - wide, c.cutoff + wide};
}

Candidate best_filter(const Record& r) {
  Candidate best;
  for (const char* family : {"first_order", "butterworth"})
    for (const int order : {1, 2, 3, 4}) {
      if (order == 1 && family == std::string_view("butterworth")) continue;
      for (const Eigen::Index delay : {0, 1, 2})
        if (const Candidate c = best_cutoff(r, {family, order, 0, delay, 1e300}); c.misfit < best.misfit)
          best = c;
    }
  return best.misfit < 1e300 ? refined(r, best, 1e-3, 1e-8) : best;
}

/// Whether the differences of the positions follow the stamps and not a constant interval, and the cause.
bool name_jitter(Sanity& s, const Record& r, const Eigen::ArrayXd& time, std::size_t joint) {
  const Eigen::Index n = time.size();
  const Eigen::ArrayXd steps = time.tail(n - 1) - time.head(n - 1);
  const Eigen::ArrayXd speed = 0.5 * (r.velocity.tail(n - 1) + r.velocity.head(n - 1));
  const Eigen::ArrayXd moved = r.position.tail(n - 1) - r.position.head(n - 1);
  const Eigen::ArrayXd constant = moved - speed * r.interval;  // what a constant interval leaves [rad]
  const Eigen::ArrayXd stamped = moved - speed * steps;
  const Line line = fit_line(speed * (steps - r.interval), constant);
  const double before = rms(constant), after = rms(stamped);
  if (standard_deviation(steps) < 0.02 * r.interval || after > 0.5 * before || std::abs(line.slope - 1) > 0.2)
    return false;
  if (known(s, joint, "timing_jitter")) return true;
  const double sigma = standard_deviation(steps), samples = static_cast<double>(n);
  const double wide = 1.96 * sigma / std::sqrt(2 * samples);
  Cause c = cause(s, joint, "timing_jitter", {{"sigma", sigma}},
                  std::exp(-samples * std::log(before / after)), before, after);
  c.parameters = {{"sigma", sigma, sigma - wide, sigma + wide}};
  s.causes.push_back(std::move(c));
  s.warnings.push_back(
      s.model.chain.independent[joint].name +
      ": differences of the positions follow the stamps, not a constant interval: velocities "
      "must be taken over the stamps");
  return true;
}

}  // namespace

void check_velocity(Sanity& s, const std::vector<Filter>& filters, std::size_t joint) {
  const auto column = s.log.find(LogSignal::velocity, joint), stamps = s.log.find(LogSignal::time);
  const auto measured = measured_joint(s.log, s.log.values, s.model.transmission, joint);
  if (!column || !stamps || !measured || s.log.values.rows() < 200) return;
  const Eigen::ArrayXd time = s.log.values.col(*stamps);
  const Eigen::Index n = time.size();
  Record r{*measured, s.log.values.col(*column), (time[n - 1] - time[0]) / static_cast<double>(n - 1), 0};
  const LogColumn& head = s.log.columns[static_cast<std::size_t>(*column)];
  r.written = head.step() / std::sqrt(12.0);
  if (rms(r.velocity) < 10 * r.written || peak_to_peak(r.position) < 200 * ideal_sigma(s, joint)) return;
  double stated = 1e300, rate = 0;
  for (const Filter& f : filters)
    if (f.derivative == 1) {
      rate = f.sample_rate;
      if (std::abs(f.sample_rate * r.interval - 1) < 0.01) stated = std::min(stated, misfit(r, f, 0));
    }
  // The spec's filter makes it, as far as the file can tell.
  if (stated < std::max(3 * r.written, 1e-3 * rms(r.velocity))) return;
  if (!s.cannot_judge.empty() && name_jitter(s, r, time, joint)) return;
  if (stated == 1e300) {
    if (rate > 0)
      s.warnings.push_back(head.header + ": the spec's filter runs at " + significant(rate, 6) +
                           " Hz, the log at " + significant(1 / r.interval, 6) + " Hz: not compared");
    return;
  }
  const Candidate best = best_filter(r);
  if (best.misfit > 0.3 * stated || best.misfit > 0.3 * rms(r.velocity)) return;
  std::map<std::string, double> numbers{{"order", best.order}, {"cutoff", best.cutoff}};
  if (best.delay > 0) numbers["delay"] = static_cast<double>(best.delay) * r.interval;
  Cause c = cause(s, joint, "filter_mismatch", std::move(numbers),
                  std::exp(-0.1 * static_cast<double>(n) * std::log(stated / best.misfit)),
                  stated * r.interval, best.misfit * r.interval);
  c.effect.choices["family"] = best.family;
  c.parameters = {{"order", static_cast<double>(best.order), static_cast<double>(best.order),
                   static_cast<double>(best.order)},
                  cutoff_of(r, best)};
  s.causes.push_back(std::move(c));
}

}  // namespace qerr::sanity
