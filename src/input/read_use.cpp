#include <algorithm>
#include <filesystem>

#include "core/suggest.hpp"
#include "input/read_sections.hpp"
#include "input/spec_format.hpp"
#include "qerr/kinematics/coordinates.hpp"

/// Reads the sections `coordinates`, `requirements` and `threshold` of a spec.
namespace qerr {

namespace {

std::vector<std::string> coordinate_names(const std::vector<Coordinate>& list) {
  std::vector<std::string> names;
  for (const Coordinate c : list) names.emplace_back(info(c).name);
  return names;
}

template <class Enum>
Enum pick(const Field& f, const std::string& word, const std::string& what,
          const std::vector<std::pair<std::string, Enum>>& known) {
  std::vector<std::string> names;
  for (const auto& [name, value] : known) {
    if (name == word) return value;
    names.push_back(name);
  }
  throw Error(f.fault("no such " + what + " '" + word + "'", did_you_mean(word, names)));
}

bool contains(const std::vector<Coordinate>& list, Coordinate c) {
  return std::find(list.begin(), list.end(), c) != list.end();
}

/// Adds a length, and those of its components that are missing.
void add_length(Coordinate length, OperationalModel& model) {
  if (contains(model.lengths, length)) return;
  for (int k = 0; k < 3; ++k) {
    const auto component = static_cast<Coordinate>(static_cast<int>(first_component(length)) + k);
    if (!contains(model.coordinates, component)) model.coordinates.push_back(component);
  }
  model.lengths.push_back(length);
}

/// Splits SIGNAL.COORDINATE.BOUND at its last two dots, as a filter's name may contain dots.
void read_quantity(const Field& f, const Spec& spec, Requirement& r) {
  const std::size_t second = r.quantity.rfind('.');
  const std::size_t first =
      second == std::string::npos || second == 0 ? std::string::npos : r.quantity.rfind('.', second - 1);
  if (first == std::string::npos)
    throw Error(f.fault("a quantity must have three parts", "write position.x.worst_case or FILTER.x.sigma"));
  const std::string signal = r.quantity.substr(0, first);
  std::vector<std::pair<std::string, std::ptrdiff_t>> signals{{"position", -1}};
  for (std::size_t i = 0; i < spec.filters.size(); ++i)
    signals.emplace_back(spec.filters[i].name, static_cast<std::ptrdiff_t>(i));
  std::vector<std::pair<std::string, std::size_t>> coordinates;
  for (const std::string& name : coordinate_names(coordinates_and_lengths(spec.model)))
    coordinates.emplace_back(name, coordinates.size());
  using Bound = Requirement::Bound;
  std::vector<std::pair<std::string, Bound>> bounds{{"worst_case", Bound::worst_case},
                                                    {"sigma", Bound::sigma}};
  if (signal == "position")
    bounds.emplace_back("worst_case_rigorous", Bound::worst_case_rigorous);
  else
    bounds.emplace_back("sigma_in_motion", Bound::sigma_in_motion);
  r.filter = pick(f, signal, "filter", signals);
  r.coordinate = pick(f, r.quantity.substr(first + 1, second - first - 1), "coordinate", coordinates);
  r.bound = pick(f, r.quantity.substr(second + 1), "bound", bounds);
  if (r.bound == Bound::sigma_in_motion && !spec.motion)
    throw Error(f.fault("sigma_in_motion needs a motion", "add 'motion:' to the spec, or use sigma"));
}

Dimension dimension_of(const Requirement& r, const Spec& spec) {
  const bool length = info(coordinates_and_lengths(spec.model)[r.coordinate]).unit == "m";
  Dimension d = length ? dimension::length : dimension::angle;
  if (r.filter >= 0) d.second = -spec.filters[static_cast<std::size_t>(r.filter)].filter.derivative;
  return d;
}

}  // namespace

void read_coordinates(const Field& f, Spec& spec) {
  std::vector<std::string> all;
  for (const CoordinateInfo& row : coordinate_list()) all.emplace_back(row.name);
  std::vector<Coordinate> named;
  for (const Field& item : read_list(f, "[x, y, z]")) {
    const std::string name = read_text_value(item);
    const auto coordinate = find_coordinate(name);
    if (!coordinate) throw Error(item.fault("no such coordinate", did_you_mean(name, all)));
    if (contains(named, *coordinate)) throw Error(item.fault("duplicate coordinate", "keep one of them"));
    named.push_back(*coordinate);
  }
  if (named.empty())
    throw Error(f.fault("the list of coordinates is empty", "write [x, y, z], or leave the key out"));
  spec.model.coordinates.clear();
  for (const Coordinate c : named)
    if (!is_length(c)) spec.model.coordinates.push_back(c);
  for (const Coordinate c : named)
    if (is_length(c)) add_length(c, spec.model);
}

void read_requirements(const Field& f, Spec& spec, Faults& faults) {
  for (const Field& item : read_list(f, "a list: - {quantity: ..., statistic: ..., at_most: ...}"))
    faults.guard([&] {
      const Object o(item, spec_format::requirement());
      Requirement r;
      r.place = item.node->place;
      r.quantity = *o.text("quantity");
      read_quantity(o.at("quantity"), spec, r);
      r.statistic = o.choice("statistic");
      r.value = find_statistic(r.statistic)->value;
      const Dimension d = dimension_of(r, spec);
      r.unit = unit_name(d);
      // A metre or a radian is no requirement of a tip, 10 mm or 0.1 rad hardly one.
      const Parameter limit{.name = "at_most", .dimension = d, .least = 0, .usual = d.metre ? 0.01 : 0.1};
      r.at_most = read_number(o.at("at_most"), limit);
      if (r.filter < 0) warn_of_bare_numbers(item, {limit}, {}, spec.warnings);
      spec.requirements.push_back(r);
    });
}

void read_threshold(const Field& f, Spec& spec) {
  spec.threshold_length = Object(f, spec_format::threshold()).number("length");
  warn_of_bare_numbers(f, spec_format::threshold(), {}, spec.warnings);
}

}  // namespace qerr
