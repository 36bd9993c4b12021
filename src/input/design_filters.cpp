#include <algorithm>

#include "core/suggest.hpp"
#include "core/text.hpp"
#include "input/design_sections.hpp"
#include "input/spec_format.hpp"
#include "qerr/filter/family.hpp"

namespace qerr {

namespace {

/// Families with an order, a cut-off and nothing else that must be stated.
std::vector<std::string> searched_families() {
  std::vector<std::string> names;
  for (const FilterFamily& family : filter_families()) {
    const auto has = [&](std::string_view key) {
      return std::any_of(family.parameters.begin(), family.parameters.end(),
                         [&](const Parameter& p) { return p.name == key; });
    };
    const bool more = std::any_of(family.parameters.begin(), family.parameters.end(), [](const Parameter& p) {
      return p.required && p.name != "order" && p.name != "cutoff";
    });
    if (has("order") && has("cutoff") && !more) names.emplace_back(family.name);
  }
  return names;
}

void read_families(const Object& o, FilterOptions& options) {
  const std::vector<std::string> known = searched_families();
  if (!o.has("families")) {
    options.range.families = known;
    return;
  }
  for (const Node& value : values_of(o.at("families"))) {
    if (std::find(known.begin(), known.end(), value.text) == known.end())
      throw Error({value.place, o.at("families").path, "no filter family that order and cutoff determine",
                   qerr::quoted(value.text), did_you_mean(value.text, known)});
    options.range.families.push_back(value.text);
  }
}

void read_cutoff(const Object& o, double sample_rate, FilterOptions& options) {
  // A thousandth of the sample rate to 0.4 of it: what controllers use, short of the families' end at half.
  options.range.least_cutoff = 1e-3 * sample_rate;
  options.range.most_cutoff = 0.4 * sample_rate;
  if (!o.has("cutoff")) return;
  const Field f = o.at("cutoff");
  const Parameter row{.name = "cutoff",
                      .dimension = dimension::frequency,
                      .least = 0,
                      .most = 0.5 * sample_rate,
                      .open_below = true,
                      .open_above = true};
  if (f.node->type != Node::Type::sequence) {
    options.range.least_cutoff = options.range.most_cutoff = read_number(f, row);
    return;
  }
  const std::vector<Field> ends = read_list(f, "[5 Hz, 200 Hz]");
  if (ends.size() != 2) throw Error(f.fault("must have two ends", "write [5 Hz, 200 Hz]"));
  options.range.least_cutoff = read_number(ends[0], row);
  options.range.most_cutoff = read_number(ends[1], row);
  if (!(options.range.least_cutoff <= options.range.most_cutoff))
    throw Error(f.fault("the range is empty", "write the lower frequency first"));
}

FilterOptions read_filter_options(const Node::Key& key, const Field& f, const Spec& spec) {
  std::vector<std::string> names;
  for (const NamedFilter& filter : spec.filters) names.push_back(filter.name);
  const auto found = std::find(names.begin(), names.end(), key.name);
  if (found == names.end())
    throw Error({key.place, f.path, "the spec has no filter of this name", qerr::quoted(key.name),
                 names.empty() ? "add it to `filters:` with derivative and sample_rate"
                               : did_you_mean(key.name, names)});
  const Object o(f, spec_format::design_filter());
  FilterOptions options;
  options.filter = static_cast<std::size_t>(found - names.begin());
  options.place = key.place;
  const double sample_rate = spec.filters[options.filter].filter.sample_rate;
  read_families(o, options);
  options.range.orders = {1, 2, 3, 4};
  if (o.has("orders")) {
    options.range.orders.clear();
    for (const Node& value : values_of(o.at("orders"))) {
      const Field field{&value, o.at("orders").path};
      options.range.orders.push_back(static_cast<int>(
          read_number(field, {.name = "orders", .kind = Kind::integer, .least = 1, .most = 20})));
    }
  }
  read_cutoff(o, sample_rate, options);
  options.range.delay = o.number("delay");
  if (o.has("tracking")) {
    const Object t(o.at("tracking"), spec_format::design_tracking());
    options.range.tracking = {*t.number("band"), *t.number("at_most")};
    if (!(options.range.tracking->band < 0.5 * sample_rate))
      throw Error(t.at("band").fault("must be below half the sample rate",
                                     "give the highest frequency of the motion"));
  }
  return options;
}

}  // namespace

void read_design_filters(const Field& f, const Spec& spec, DesignRequest& request, Faults& faults) {
  for (const auto& entry : read_map(f)) {
    const Node::Key& key = entry.first;
    const Field& field = entry.second;
    faults.guard([&] { request.filters.push_back(read_filter_options(key, field, spec)); });
  }
}

}  // namespace qerr
