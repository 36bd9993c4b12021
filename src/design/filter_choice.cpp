#include "design/filter_choice.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/text.hpp"
#include "qerr/core/error.hpp"
#include "qerr/design/requirement.hpp"
#include "qerr/filter/family.hpp"
#include "qerr/filter/norms.hpp"

namespace qerr {

std::optional<Filter> low_pass(const std::string& family, int order, double cutoff, int derivative,
                               double sample_rate) {
  for (const FilterFamily& row : filter_families()) {
    if (row.name != family) continue;
    FilterDesign d;
    d.derivative = derivative;
    d.sample_rate = sample_rate;
    for (const Parameter& p : row.parameters) {
      if (p.kind == Kind::choice) d.choices[std::string(p.name)] = choices_of(p).front();
      if (p.fallback) d.numbers[std::string(p.name)] = *p.fallback;
    }
    d.numbers["order"] = order;
    d.numbers["cutoff"] = cutoff;
    try {
      return row.design(d);
    } catch (const Error& e) {
      if (e.trouble() != Trouble::input) throw;
      return std::nullopt;
    }
  }
  return std::nullopt;
}

double tracking_up_to(const Filter& filter, double band) {
  return band_tracking(filter, 1e-4 * band, band).largest;
}

namespace {

/// The largest tracking error at equally spaced frequencies: a quick lower bound of that of the band.
double sampled_tracking(const Filter& filter, double band) {
  constexpr int samples = 24;
  double largest = 0;
  for (int i = samples; i > 0; --i)
    largest = std::max(largest, fidelity(filter, band * i / samples).tracking_error);
  return largest;
}

/// The scan of one family and order.
class CutoffScan {
 public:
  CutoffScan(const FilterRange& range, int derivative, double sample_rate,
             const std::function<bool(const Filter&)>& accepts, const std::string& family, int order,
             FilterScan& to)
      : range_(range),
        derivative_(derivative),
        sample_rate_(sample_rate),
        accepts_(accepts),
        family_(family),
        order_(order),
        to_(to) {}

  void run() {
    const double octaves = std::log2(range_.most_cutoff / range_.least_cutoff);
    const int steps = octaves > 0 ? std::max(24, static_cast<int>(std::ceil(12 * octaves))) : 0;
    std::optional<double> before;
    bool before_met = false;
    for (int i = 0; i <= steps; ++i) {
      const double cutoff =
          i == steps ? range_.most_cutoff : range_.least_cutoff * std::exp2(octaves * i / std::max(steps, 1));
      const std::optional<Filter> filter = at(cutoff);
      if (!filter) continue;
      ++to_.filters;
      to_.any_true_gain = to_.any_true_gain || passes_slow_motion(*filter);
      to_.least_delay = std::min(to_.least_delay, group_delay(*filter));
      if (range_.tracking)
        to_.least_tracking = std::min(to_.least_tracking, sampled_tracking(*filter, range_.tracking->band));
      const bool met = meets(*filter);
      if (before && met != before_met) add(met ? end_between(*before, cutoff) : end_between(cutoff, *before));
      if (met) add(cutoff);
      before = cutoff;
      before_met = met;
    }
  }

 private:
  std::optional<Filter> at(double cutoff) const {
    return low_pass(family_, order_, cutoff, derivative_, sample_rate_);
  }

  bool meets(const Filter& filter) const {
    if (!range_.tracking && !passes_slow_motion(filter)) return false;
    if (range_.delay && !(group_delay(filter) <= *range_.delay)) return false;
    if (range_.tracking && !(sampled_tracking(filter, range_.tracking->band) <= range_.tracking->at_most))
      return false;
    return accepts_(filter);
  }

  bool meets(double cutoff) const {
    const std::optional<Filter> filter = at(cutoff);
    return filter && meets(*filter);
  }

  /// The cut-off between one that is beyond a limit and one within, nearest to the former, to six digits.
  double end_between(double beyond, double within) const {
    for (int i = 0; i < 40 && std::abs(within - beyond) > 1e-8 * within; ++i) {
      const double middle = std::sqrt(beyond * within);
      (meets(middle) ? within : beyond) = middle;
    }
    const double unit = std::pow(10.0, std::floor(std::log10(within)) - 5);
    const double rounded = (within > beyond ? std::ceil(within / unit) : std::floor(within / unit)) * unit;
    const double neat = rounded_to(rounded, 6);
    return neat >= range_.least_cutoff && neat <= range_.most_cutoff && meets(neat) ? neat : within;
  }

  void add(double cutoff) {
    const std::optional<Filter> filter = at(cutoff);
    if (!filter) return;
    FilterCandidate c{family_, order_, cutoff, *filter, h2_norm(*filter), group_delay(*filter), {}};
    if (!std::isfinite(c.h2)) return;
    if (range_.tracking) {
      c.tracking = tracking_up_to(*filter, range_.tracking->band);
      if (!(*c.tracking <= range_.tracking->at_most)) return;  // a peak between the samples
    }
    to_.candidates.push_back(std::move(c));
  }

  const FilterRange& range_;
  int derivative_;
  double sample_rate_;
  const std::function<bool(const Filter&)>& accepts_;
  const std::string& family_;
  int order_;
  FilterScan& to_;
};

}  // namespace

FilterScan filter_candidates(const FilterRange& range, int derivative, double sample_rate,
                             const std::function<bool(const Filter&)>& accepts) {
  FilterScan scan;
  scan.least_delay = scan.least_tracking = std::numeric_limits<double>::infinity();
  for (const std::string& family : range.families)
    for (const int order : range.orders)
      CutoffScan(range, derivative, sample_rate, accepts, family, order, scan).run();
  return scan;
}

namespace {

Dimension per_sample_power(const Filter& f) {
  Dimension d;
  d.second = -f.derivative;
  return d;
}
Dimension of_time(const Filter&) { return dimension::time; }
Dimension of_frequency(const Filter&) { return dimension::frequency; }

constexpr FilterFigure figures[] = {
    {"h2_norm", "sigma of the output for white input of unit sigma", per_sample_power,
     [](const Filter&, const Norms& n) -> std::optional<double> { return n.h2; }, true},
    {"l1_norm", "peak of the output for input bounded by 1", per_sample_power,
     [](const Filter&, const Norms& n) -> std::optional<double> { return n.l1.upper; }, true},
    {"delay", "group delay at 0 Hz", of_time,
     [](const Filter& f, const Norms&) -> std::optional<double> { return group_delay(f); }},
    {"bandwidth", "frequency at which the estimate falls to 1/sqrt(2)", of_frequency,
     [](const Filter& f, const Norms&) { return bandwidth(f); }},
    {"settling", "until the step response stays within 2 %", of_time,
     [](const Filter& f, const Norms&) { return settling_time(f); }},
};

}  // namespace

std::span<const FilterFigure> filter_figures() { return figures; }

const FilterFigure* find_filter_figure(std::string_view name) {
  const auto row = std::find_if(std::begin(figures), std::end(figures),
                                [&](const FilterFigure& f) { return f.name == name; });
  return row == std::end(figures) ? nullptr : row;
}

std::string figure_unit(const FilterFigure& figure, const Filter& filter) {
  if (!figure.norm) return unit_name(figure.dimension(filter));
  return filter.derivative == 0   ? ""
         : filter.derivative == 1 ? "1/s"
                                  : "1/s^" + std::to_string(filter.derivative);  // no frequency
}

}  // namespace qerr
