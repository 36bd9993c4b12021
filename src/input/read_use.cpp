#include <algorithm>
#include <filesystem>

#include "core/suggest.hpp"
#include "input/read_sections.hpp"
#include "input/spec_format.hpp"
#include "qerr/kinematics/coordinates.hpp"

/// Reads the sections `coordinates` and `threshold` of a spec.
namespace qerr {

namespace {

bool contains(const std::vector<Coordinate>& list, Coordinate c) {
  return std::find(list.begin(), list.end(), c) != list.end();
}

}  // namespace

void add_length(Coordinate length, OperationalModel& model) {
  if (contains(model.lengths, length)) return;
  for (int k = 0; k < 3; ++k) {
    const auto component = static_cast<Coordinate>(static_cast<int>(first_component(length)) + k);
    if (!contains(model.coordinates, component)) model.coordinates.push_back(component);
  }
  model.lengths.push_back(length);
}

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

void read_log_section(const Field& f, Spec& spec) {
  const std::string missing = Object(f, spec_format::log()).choice("missing");
  spec.log.missing = missing == "drop"   ? MissingValues::drop
                     : missing == "hold" ? MissingValues::hold
                                         : MissingValues::error;
}

void read_threshold(const Field& f, Spec& spec) {
  spec.threshold_length = Object(f, spec_format::threshold()).number("length");
  warn_of_bare_numbers(f, spec_format::threshold(), {}, spec.warnings);
}

}  // namespace qerr
