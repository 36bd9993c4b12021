#include <algorithm>

#include "qerr/design/requirement.hpp"
#include "qerr/filter/quality.hpp"

namespace qerr {

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
