#include <algorithm>

#include "control/control.hpp"
#include "core/lists.hpp"
#include "core/text.hpp"
#include "input/read_sections.hpp"
#include "qerr/core/quantity.hpp"

/// Reads the section `requirements` of a spec.
namespace qerr {

namespace {

template <class Value>
using Words = std::vector<std::pair<std::string, Value>>;

template <class Value>
const Value* find(const Words<Value>& words, const std::string& word) {
  const auto at = std::ranges::find_if(words, [&](const auto& w) { return w.first == word; });
  return at == words.end() ? nullptr : &at->second;
}

template <class Value>
Value pick(const Field& f, const std::string& word, const std::string& what, const Words<Value>& known) {
  if (const Value* value = find(known, word)) return *value;
  std::vector<std::string> names;
  for (const auto& [name, value] : known) names.push_back(name);
  f.refuse("no such " + what + " '" + word + "'", did_you_mean(word, names));
}

Words<std::ptrdiff_t> signals_of(const Spec& spec) {
  Words<std::ptrdiff_t> signals{{"position", -1}};
  for (std::size_t i = 0; i < spec.filters.size(); ++i)
    signals.emplace_back(spec.filters[i].name, static_cast<std::ptrdiff_t>(i));
  return signals;
}

/// The signals of the spec; lengths and joints that it does not list are added where they are required.
std::size_t read_signal(const Field& f, const std::string& word, Spec& spec) {
  std::vector<std::string> known;
  for (const Coordinate c : spec.model.coordinates) known.emplace_back(info(c).name);
  for (const Coordinate c : {Coordinate::xyz, Coordinate::rxyz}) known.emplace_back(info(c).name);
  for (std::string& name : signal_names(spec.model)) known.push_back(std::move(name));
  const std::optional<Coordinate> coordinate = find_coordinate(word);
  if (coordinate && spec.model.tips)
    f.refuse("which of the tips is not said", of_which_tip(spec.model, word));
  if (coordinate && !contains(known, word)) {
    const std::string listed =
        joined(spec.model.coordinates, ", ", [](Coordinate c) { return info(c).name; });
    f.refuse("'" + word + "' is not among the spec's coordinates",
             "add it to 'coordinates'" + (listed.empty() ? "" : ", which are " + listed + " here"));
  }
  if (coordinate && is_length(*coordinate)) add_length(*coordinate, spec.model);
  const std::vector<Signal> found =
      coordinate ? std::vector{signal_of(*coordinate)} : find_signals(spec.model, word);
  if (found.size() != 1) f.refuse("no such coordinate '" + word + "'", did_you_mean(word, known));
  if (!coordinate) add_signal(found.front(), spec.model);
  const std::vector<Signal> all = all_signals(spec.model);
  return std::ranges::find_if(all, [&](const Signal& s) { return s.name == found.front().name; }) -
         all.begin();
}

/// The signal and the coordinate of a quantity without its bound: of `velocity.x` velocity and x. Both may
/// contain dots.
std::pair<std::string, std::string> parts_of(const std::string& before, const Words<std::ptrdiff_t>& filters,
                                             const Spec& spec) {
  for (const std::string& name : signal_names(spec.model)) {
    if (before == name) return {"position", name};
    if (before.size() > name.size() && before.ends_with('.' + name))
      if (const std::string first = before.substr(0, before.size() - name.size() - 1); find(filters, first))
        return {first, name};
  }
  const std::size_t middle = before.rfind('.');
  if (middle == std::string::npos) return {"position", before};
  return {before.substr(0, middle), before.substr(middle + 1)};
}

/// `loop.JOINT.gain_margin`, `wall.NAME.stiffness`. @returns whether the quantity has this form
/// @throws Error (input) for any quantity of controllers where there are none
bool read_control_figure(const Field& f, const Spec& spec, Requirement& r) {
  const std::string first = r.quantity.substr(0, r.quantity.find('.'));
  if (find(signals_of(spec), first)) return false;  // a filter's name
  const bool figure = first == "loop" || first == "wall" || first == "control";
  if (!figure && first != "torque" && first != "closed_torque" && first != "closed_position") return false;
  const std::vector<std::string> names = signal_names(spec.model);  // such as those of a tip named `torque`
  if (!spec.model.control &&
      std::ranges::none_of(names, [&](const std::string& name) { return name.starts_with(first + '.'); }))
    f.refuse("the spec has no controllers", "add 'control: {joints: {...}}' (qerr help control)");
  if (!figure) return false;
  Words<Dimension> figures;
  for (const ControlFigure& figure : control_figures(*spec.model.control, spec.model.chain))
    figures.emplace_back(figure.name, figure.dimension);
  pick(f, r.quantity, "figure of a loop or a wall", figures);
  r.of_control = true;
  return true;
}

/// @pre it is one of a loop or a wall
Dimension dimension_of_control(const Requirement& r, const Spec& spec) {
  for (const ControlFigure& figure : control_figures(*spec.model.control, spec.model.chain))
    if (figure.name == r.quantity) return figure.dimension;
  return dimension::none;
}

/// `encoder.JOINT.count_rate`. @returns whether the quantity has this form
bool read_counter(const Field& f, const Spec& spec, Requirement& r) {
  constexpr std::string_view before = "encoder.", after = ".count_rate";
  if (!r.quantity.starts_with(before) || !r.quantity.ends_with(after) ||
      r.quantity.size() <= before.size() + after.size())
    return false;
  Words<std::ptrdiff_t> joints;
  for (const IndependentJoint& joint : spec.model.chain.independent)
    joints.emplace_back(joint.name, std::ssize(joints));
  r.counter = pick(f, r.quantity.substr(before.size(), r.quantity.size() - before.size() - after.size()),
                   "joint", joints);
  return true;
}

/// `torque.JOINT.BOUND`, where `torque.JOINT` is the filter of a joint's controller. @returns whether it is
bool read_torque(const Spec& spec, std::ptrdiff_t filter, const std::string& end, Requirement& r) {
  const NamedFilter& f = spec.filters[filter];
  if (!f.controller || find_filter_figure(end)) return false;
  for (const Bound b : bounds_of(true))
    if (name_of(b) == end) r.bound = b;
  if (name_of(r.bound) != end) return false;
  const std::vector<Signal> all = all_signals(spec.model);
  r.filter = filter;
  for (std::size_t s = 0; s < all.size(); ++s)
    if (is_filtered(f, all[s])) r.signal = s;
  return true;
}

/// A filter of joints has no figures of other coordinates, and a closed loop none behind a filter.
void check_passed(const Field& f, const Spec& spec, const Requirement& r) {
  const Signal signal = all_signals(spec.model)[r.signal];
  if (r.filter < 0) return;
  const NamedFilter& filter = spec.filters[r.filter];
  if (is_filtered(filter, signal)) return;
  const std::string joints =
      joined(filter.joints, ", ", [&](std::size_t j) { return spec.model.chain.independent[j].name; });
  f.refuse("filter '" + filter.name + "' does not filter '" + signal.name + "'",
           is_closed(signal) ? "ask for " + signal.name + ".sigma, the figure of the loop itself"
                             : "its joints are " + joints);
}

/// The names of CSV: `position.x.worst_case`, `velocity.x.sigma`, `velocity.delay`; `x.worst_case` is an
/// older name of the first. A filter's name may contain dots.
void read_quantity(const Field& f, Spec& spec, Requirement& r) {
  if (read_counter(f, spec, r) || read_control_figure(f, spec, r)) return;
  const std::size_t last = r.quantity.rfind('.');
  const std::string before = last == std::string::npos ? "" : r.quantity.substr(0, last);
  const std::string end = last == std::string::npos ? r.quantity : r.quantity.substr(last + 1);
  const Words<std::ptrdiff_t> signals = signals_of(spec);
  const std::ptrdiff_t* filter = find(signals, before);
  if (filter && *filter >= 0 && read_torque(spec, *filter, end, r)) return;
  if (filter && *filter >= 0) {
    Words<const FilterFigure*> figures;
    for (const FilterFigure& figure : filter_figures()) figures.emplace_back(figure.name, &figure);
    r.filter = *filter;
    r.figure = pick(f, end, "figure of a filter", figures);
    return;
  }
  if (before.empty())
    f.refuse("a quantity names a signal, a coordinate and a bound",
             "write position.x.worst_case, FILTER.x.sigma or FILTER.delay");
  const auto [signal, coordinate] = parts_of(before, signals, spec);
  if (before.starts_with("closed_") && !find(signals, signal)) {
    const std::string group = before.substr(0, before.find('.') + 1);
    Words<std::ptrdiff_t>
        known;  // not among them: those of lengths, and of coordinates that are not analysed
    for (const std::string& name : signal_names(spec.model))
      if (name.starts_with(group)) known.emplace_back(name, 0);
    pick(f, before, "error in the closed loops", known);
  }
  r.filter = pick(f, signal, "filter", signals);
  r.signal = read_signal(f, coordinate, spec);
  check_passed(f, spec, r);
  Words<Bound> bounds;
  for (const Bound b : r.filter < 0 ? std::vector{Bound::worst_case, Bound::sigma, Bound::worst_case_rigorous}
                                    : std::vector{Bound::worst_case, Bound::sigma, Bound::sigma_in_motion,
                                                  Bound::sigma_quantization})
    bounds.emplace_back(name_of(b), b);
  r.bound = pick(f, end, "bound", bounds);
  if (r.bound == Bound::sigma_in_motion && !spec.motion)
    f.refuse("sigma_in_motion needs a motion", "add 'motion:' to the spec, or use sigma");
}

Dimension dimension_of(const std::string& unit) {
  std::string why;
  return parse_unit(unit, why)->dimension;
}

Dimension dimension_of(const Requirement& r, const Spec& spec) {
  if (r.of_control) return dimension_of_control(r, spec);
  if (r.counter >= 0) return dimension::frequency;
  if (r.figure) return r.figure->dimension(spec.filters[r.filter].filter);
  const Dimension d = dimension_of(all_signals(spec.model)[r.signal].unit);
  return r.filter < 0 ? d : output_dimension(d, spec.filters[r.filter].filter);
}

void read_statistic(const Object& o, const Spec& spec, Requirement& r) {
  if (!r.limits_error()) {
    if (o.has("statistic"))
      o.at("statistic")
          .refuse("a figure of a filter, an encoder, a loop or a wall has no statistic", "leave the key out");
    return;
  }
  if (!o.has("statistic"))
    o.self().refuse("missing key 'statistic'",
                    "add 'statistic: max', or another one of `qerr list statistics`");
  r.statistic = o.choice("statistic");
  r.proven = r.statistic == proven_statistic;
  if (r.proven && r.bound == Bound::sigma_quantization)
    o.at("statistic")
        .refuse("the maximum of sigma_quantization is not proven",
                "require 'max' of it, or proven_max of sigma");
  if (r.proven && is_closed(all_signals(spec.model)[r.signal]))
    o.at("statistic")
        .refuse("the maximum of a closed loop, or of an impedance at the tip, is not proven",
                "require 'max' of it");
  if (!r.proven) r.value = find_statistic(r.statistic == "median" ? "p50" : r.statistic)->value;
}

std::string unit_of(const Requirement& r, const Spec& spec) {
  if (r.counter >= 0) return "counts/s";  // Hz would be that of a channel's signal
  if (r.figure) return figure_unit(*r.figure, spec.filters[r.filter].filter);
  // A law whose unit is not stated is shown without one.
  if (r.filter >= 0 && has_unknown_unit(spec.filters[r.filter].filter)) return "";
  return unit_name(dimension_of(r, spec));
}

void read_limit(const Object& o, Spec& spec, Requirement& r) {
  if (o.has("at_most") == o.has("at_least"))
    o.self().refuse(o.has("at_most") ? "has two limits" : "has no limit",
                    "write either 'at_most' or 'at_least'");
  r.at_least = o.has("at_least");
  const Dimension d = dimension_of(r, spec);
  r.unit = unit_of(r, spec);
  const std::string_view key = r.relation();
  // A limit may be as good as none. A metre or a radian is no requirement of a tip, 10 mm or 0.1 rad hardly
  // one.
  const Parameter limit{.name = key,
                        .dimension = d,
                        .least = 0,
                        .most = 1e300,
                        .usual = d == dimension::length  ? 0.01
                                 : d == dimension::angle ? 0.1
                                                         : std::numeric_limits<double>::infinity()};
  r.limit = read_number(o.at(key), limit);
  if (r.filter < 0 && r.limits_error()) warn_of_bare_numbers(o.self(), {limit}, {}, spec.warnings);
}

}  // namespace

std::vector<Requirement> read_limits(const std::string& option, const std::vector<std::string>& texts,
                                     Spec& spec) {
  std::vector<Requirement> limits;
  for (const std::string& text : texts) {
    const std::size_t equals = text.find('=');
    if (equals == std::string::npos || equals == 0)
      throw Error(option, "must be QUANTITY=LIMIT", quoted(text), "as in position.xyz.worst_case='50 um'",
                  Trouble::usage);
    const Node node = mapping_node({{"quantity", scalar_node(text.substr(0, equals))},
                                    {"at_most", scalar_node(text.substr(equals + 1))},
                                    {"statistic", scalar_node("max")}});
    try {
      const Object o({&node, option}, spec_format::requirement());
      Requirement r;
      r.quantity = *o.text("quantity");
      read_quantity(o.at("quantity"), spec, r);
      if (!r.limits_error())
        o.at("quantity")
            .refuse("a figure of a filter or an encoder is the same at all configurations",
                    "name a bound of a coordinate, as position.xyz.worst_case");
      read_limit(o, spec, r);
      limits.push_back(r);
    } catch (const Error& e) {
      std::vector<Fault> faults = e.faults();
      for (Fault& fault : faults)
        fault.key = option;  // without the keys of a requirement, which nobody wrote
      throw Error(faults, Trouble::usage);
    }
  }
  return limits;
}

void read_requirements(const Field& f, Spec& spec, Faults& faults) {
  for (const Field& item : read_list(f, "a list: - {quantity: ..., statistic: ..., at_most: ...}"))
    faults.guard([&] {
      const Object o(item, spec_format::requirement());
      Requirement r;
      r.place = item.node->place;
      r.quantity = *o.text("quantity");
      read_quantity(o.at("quantity"), spec, r);
      read_statistic(o, spec, r);
      read_limit(o, spec, r);
      spec.requirements.push_back(r);
    });
}

}  // namespace qerr
