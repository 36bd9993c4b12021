#include <algorithm>

#include "core/lists.hpp"
#include "core/suggest.hpp"
#include "input/log_columns.hpp"
#include "input/read_sections.hpp"
#include "input/spec_format.hpp"
#include "qerr/core/quantity.hpp"
#include "qerr/kinematics/coordinates.hpp"

/// Reads the sections `coordinates`, `log` and `threshold` of a spec.
namespace qerr {

std::string of_which_tip(const OperationalModel& model, const std::string& coordinate) {
  return "write " + model.tips->front().name + '.' + coordinate +
         (model.tips->size() > 1 ? " or " + (*model.tips)[1].name + '.' + coordinate : "") +
         "; tips have x y z rx ry rz";
}

void add_length(Coordinate length, OperationalModel& model) {
  if (contains(model.lengths, length)) return;
  for (int k = 0; k < 3; ++k) {
    const auto component = static_cast<Coordinate>(static_cast<int>(first_component(length)) + k);
    add_once(model.coordinates, component);
  }
  model.lengths.push_back(length);
}

void add_signal(const Signal& signal, OperationalModel& model) {
  if (!find_named(model.signals, signal.name)) model.signals.push_back(signal);
}

void add_positions_of_tips(OperationalModel& model) {
  for (const NamedTip& tip : *model.tips)
    for (const Coordinate c : {Coordinate::x, Coordinate::y, Coordinate::z})
      if (tip.name.find('-') == std::string::npos)  // of one relative to another
        for (const Signal& s : find_signals(model, tip.name + '.' + std::string(info(c).name)))
          add_signal(s, model);
}

void read_coordinates(const Field& f, Spec& spec) {
  std::vector<std::string> all;
  if (!spec.model.tips) all = names_of(coordinate_list());
  append(all, signal_names(spec.model));
  std::vector<std::string> named;
  std::vector<Coordinate> lengths;
  OperationalModel& model = spec.model;
  model.coordinates.clear();
  for (const Field& item : read_list(f, "[x, y, z]")) {
    const std::string name = read_text_value(item);
    const auto coordinate = find_coordinate(name);
    if (coordinate && model.tips) item.refuse("which of the tips is not said", of_which_tip(model, name));
    const std::vector<Signal> signals =
        coordinate ? std::vector{signal_of(*coordinate)} : find_signals(model, name);
    if (signals.empty()) item.refuse("no such coordinate", did_you_mean(name, all));
    for (const Signal& s : signals) {
      if (contains(named, s.name)) item.refuse("duplicate coordinate", "keep one of them");
      named.push_back(s.name);
      if (!s.coordinate)
        add_signal(s, model);
      else
        (is_length(*s.coordinate) ? lengths : model.coordinates).push_back(*s.coordinate);
    }
  }
  if (named.empty()) f.refuse("the list of coordinates is empty", "write [x, y, z], or leave the key out");
  for (const Coordinate c : lengths) add_length(c, model);
}

namespace {

/// A header, or `{column: HEADER, unit: UNIT}`.
LogSource read_log_source(const std::string& signal, const Field& f) {
  if (f.node->type != Node::Type::mapping) return {signal, read_text_value(f), {}};
  const Object o(f, spec_format::log_column);
  const std::string unit = o.text("unit").value_or("");
  std::string why;
  if (!unit.empty() && !parse_unit(unit, why)) o.at("unit").refuse(why, "such as deg, mm or ms");
  return {signal, *o.text("column"), unit};
}

}  // namespace

void read_log_section(const Field& f, Spec& spec) {
  const Object o(f, spec_format::log);
  const std::string missing = o.choice("missing");
  spec.log.missing = missing == "drop"   ? MissingValues::drop
                     : missing == "hold" ? MissingValues::hold
                                         : MissingValues::error;
  if (o.has("time")) spec.log.columns.push_back(read_log_source("time", o.at("time")));
  if (!o.has("columns")) return;
  for (const auto& [key, value] : read_map(o.at("columns"))) {
    require_log_signal(key.name, key.place, value.path, spec.model.chain);
    for (const LogSource& other : spec.log.columns)
      if (other.signal == key.name) value.refuse("duplicate signal", "keep one of them");
    spec.log.columns.push_back(read_log_source(key.name, value));
  }
}

void read_threshold(const Field& f, Spec& spec) {
  spec.threshold_length = Object(f, spec_format::threshold).number("length");
  warn_of_bare_numbers(f, spec_format::threshold, {}, spec.warnings);
}

}  // namespace qerr
