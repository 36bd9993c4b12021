#include <algorithm>
#include <cmath>

#include "control/control.hpp"
#include "core/lists.hpp"
#include "core/suggest.hpp"
#include "core/text.hpp"
#include "input/design_request.hpp"
#include "input/joint_entries.hpp"
#include "input/spec_format.hpp"
#include "qerr/filter/family.hpp"

namespace qerr {

namespace {

void read_goal(const Object& o, const Spec& spec, DesignRequest& request) {
  const std::string goal = o.text("minimize").value_or("price");
  if (goal == "resolution") {
    request.minimize = DesignRequest::Minimize::resolution;
  } else if (goal != "price") {
    if (goal.find('.') == std::string::npos)
      o.at("minimize")
          .refuse("is nothing that can be minimized",
                  "write price, resolution, or a quantity such as position.x.sigma");
    if (spec.model.control)
      for (const ControlFigure& f : control_figures(*spec.model.control, spec.model.chain))
        if (f.name == goal && f.kind != ControlFigure::Kind::limit_cycle)
          o.at("minimize")
              .refuse("is the better the larger it is", "require at_least of it, and minimize the price");
    request.minimize = DesignRequest::Minimize::figure;
    request.figure =
        figure_entry(o.at("minimize"), o.has("statistic") ? o.at("statistic").node : nullptr, spec);
  }
  if (o.has("statistic") && request.minimize != DesignRequest::Minimize::figure)
    o.at("statistic").refuse("belongs to a quantity that is minimized", "remove it");
  if (!o.has("budget")) return;
  if (request.minimize != DesignRequest::Minimize::figure)
    o.at("budget").refuse("limits the price at which a quantity is minimized",
                          "write 'minimize: position.x.sigma', or remove the budget");
  Field f = o.at("budget");
  if (f.node->type == Node::Type::mapping) {
    const Object limit(f, {key::number("at_most", "highest price").from(0).needed()});
    request.budget = limit.number("at_most");
  } else {
    request.budget = price_at(f);
  }
}

}  // namespace

Node figure_entry(const Field& quantity, const Node* given_statistic, const Spec& spec) {
  const std::string text = read_text_value(quantity);
  const Place place = quantity.node->place;
  const std::size_t point = text.rfind('.');
  const bool alone = text.starts_with("encoder.") || text.starts_with("loop.") || text.starts_with("wall.") ||
                     text.starts_with("control.") ||
                     (point != std::string::npos && find_filter_figure(text.substr(point + 1)) &&
                      find_named(spec.filters, text.substr(0, point)));  // without a statistic
  Node entry = mapping_node({{"quantity", *quantity.node}});
  entry.place = place;
  if (given_statistic) {
    entry.entries.push_back({{"statistic", given_statistic->place}, *given_statistic});
  } else if (!alone) {
    Node statistic = scalar_node("max");
    for (const Requirement& r : spec.requirements)
      if (r.quantity == text) {
        statistic.text = r.statistic;
        break;
      }
    statistic.place = place;
    entry.entries.push_back({{"statistic", place}, statistic});
  }
  Node limit = scalar_node("1e300");  // none
  limit.place = place;
  entry.entries.push_back({{"at_most", place}, limit});
  const Node list{Node::Type::sequence, place, {}, false, {entry}, {}};
  Spec copy = spec;
  Faults faults;
  read_requirements({&list, quantity.path}, copy, faults);
  faults.raise();
  if (copy.requirements.back().counter >= 0)
    quantity.refuse("is a limit of encoders, not a figure to choose by",
                    "require it, and name an error, such as position.x.sigma");
  return entry;
}

void read_design(const Field& f, const std::string& folder, const RobotModel& robot, Spec& spec,
                 Faults& faults) {
  const Object o(f, spec_format::design);
  const auto request = std::make_shared<DesignRequest>();
  request->place = f.node->place;
  faults.guard([&] { read_goal(o, spec, *request); });
  const bool priced = request->minimize == DesignRequest::Minimize::price || request->budget;
  if (o.has("encoders"))
    faults.guard(
        [&] { read_design_encoders(o.at("encoders"), folder, robot, priced, spec, *request, faults); });
  if (o.has("filters")) faults.guard([&] { read_design_filters(o.at("filters"), spec, *request, faults); });
  if (o.has("gains")) faults.guard([&] { read_design_gains(o.at("gains"), robot, spec, *request, faults); });
  if (!faults.any() && request->encoders.empty() && request->filters.empty() && request->gains.empty())
    f.refuse("has nothing to choose", "add encoders: {'*': {bits: 12..23}}, filters or gains");
  spec.design = request;
}

namespace {

/// The whole numbers of a range FROM..TO; empty for other text.
std::vector<Node> range_of(const Field& f) {
  const std::string& text = f.node->text;
  const std::size_t dots = text.find("..");
  if (dots == std::string::npos) return {};
  const auto from = parse_number(text.substr(0, dots)), to = parse_number(text.substr(dots + 2));
  const auto whole = [](const std::optional<double>& v) { return v && *v == std::floor(*v); };
  if (!whole(from) || !whole(to))
    f.refuse("must be a range of whole numbers", "write it as 12..23, or list the values");
  if (*to < *from) f.refuse("the range is empty", "write the smaller end first");
  if (*to - *from >= static_cast<double>(most_options))
    f.refuse("has more than 10000 values", "list the values that can be bought");
  std::vector<Node> values;
  for (double v = *from; v <= *to; ++v) {
    values.push_back(scalar_node(shortest(v)));
    values.back().place = f.node->place;
  }
  return values;
}

}  // namespace

std::vector<Node> values_of(const Field& f) {
  std::vector<Field> items{f};
  if (f.node->type == Node::Type::sequence) items = read_list(f);
  if (items.empty()) f.refuse("the list is empty", "give at least one value");
  std::vector<Node> values;
  for (const Field& item : items) {
    if (item.node->type != Node::Type::scalar)
      item.refuse("must be a value or a range of whole numbers", "such as 12..23");
    const std::vector<Node> range = range_of(item);
    if (range.empty())
      values.push_back(*item.node);
    else
      values.insert(values.end(), range.begin(), range.end());
  }
  for (std::size_t i = 0; i < values.size(); ++i)
    for (std::size_t k = 0; k < i; ++k)
      if (values[i].text == values[k].text)
        throw Error(values[i].place, f.path, "duplicate value", qerr::quoted(values[i].text),
                    "keep one of the two");
  return values;
}

double price_at(const Field& f) { return read_number(f, {.name = "price", .least = 0}); }

namespace {

/// The values of one gain, which all joints of the entry take together.
void read_gain_options(const Object& o, const char* key, const GainOptions& of, const Spec& spec,
                       DesignRequest& request) {
  if (!o.has(key)) return;
  GainOptions options = of;
  options.key = key;
  const Field f = o.at(key);
  for (const std::size_t j : of.joints) {
    const JointController& stated = spec.model.control->joints[j];
    if (!((options.key == "kp" ? stated.kp : stated.kd) > 0))
      f.refuse("the controller of joint " + quoted(spec.model.chain.independent[j].name) + " has none",
               "state one in control.joints, which is then replaced");
  }
  const bool prismatic = spec.model.chain.independent[of.joints.front()].prismatic();
  Dimension d = prismatic ? Dimension{-1, 0, 0, 1} : Dimension{1, -1, 0, 1};
  if (options.key == "kd") d.second = 1;
  for (const Node& value : values_of(f))
    options.values.push_back(
        read_number({&value, f.path}, {.name = key, .dimension = d, .least = 0, .open_below = true}));
  // The largest gain first: of designs that are equal otherwise, the stiffest.
  std::sort(options.values.rbegin(), options.values.rend());
  request.gains.push_back(std::move(options));
}

}  // namespace

void read_design_gains(const Field& f, const RobotModel& robot, const Spec& spec, DesignRequest& request,
                       Faults& faults) {
  if (!spec.model.control)
    f.refuse("gains are those of `control:`", "add control: {joints: {'*': {kp: ..., kd: ...}}}");
  for (const auto& entry : read_map(f))
    faults.guard([&] {
      const auto& [key, field] = entry;
      const Object o(field, spec_format::design_gains);
      if (!o.has("kp") && !o.has("kd")) field.refuse("has nothing to choose", "give lists of kp or kd");
      GainOptions of;
      of.place = key.place;
      of.joints = find_joints(robot, spec.model.chain, key.name, key.place, field.path);
      for (const GainOptions& other : request.gains)
        for (const std::size_t j : of.joints)
          if (contains(other.joints, j))
            throw Error(key.place, field.path, "the gains of a joint are in two entries",
                        quoted(spec.model.chain.independent[j].name), "keep one");
      for (const char* const gain : {"kp", "kd"}) read_gain_options(o, gain, of, spec, request);
    });
}

namespace {

/// Families with an order, a cut-off and nothing else that must be stated.
std::vector<std::string> searched_families() {
  std::vector<std::string> names;
  for (const FilterFamily& family : filter_families()) {
    const auto has = [&](std::string_view key) { return has_row(family.parameters, key); };
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
    if (!contains(known, value.text))
      throw Error(value.place, o.at("families").path, "no filter family that order and cutoff determine",
                  qerr::quoted(value.text), did_you_mean(value.text, known));
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
  if (ends.size() != 2) f.refuse("must have two ends", "write [5 Hz, 200 Hz]");
  options.range.least_cutoff = read_number(ends[0], row);
  options.range.most_cutoff = read_number(ends[1], row);
  if (!(options.range.least_cutoff <= options.range.most_cutoff))
    f.refuse("the range is empty", "write the lower frequency first");
}

FilterOptions read_filter_options(const Node::Key& key, const Field& f, const Spec& spec) {
  const NamedFilter* const found = find_named(spec.filters, key.name);
  if (!found)
    throw Error(key.place, f.path, "the spec has no filter of this name", qerr::quoted(key.name),
                spec.filters.empty() ? "add it to `filters:` with derivative and sample_rate"
                                     : did_you_mean(key.name, names_of(spec.filters)));
  const Object o(f, spec_format::design_filter);
  FilterOptions options;
  options.filter = static_cast<std::size_t>(found - spec.filters.data());
  options.place = key.place;
  const double sample_rate = found->filter.sample_rate;
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
    const Object t(o.at("tracking"), spec_format::design_tracking);
    options.range.tracking = {*t.number("band"), *t.number("at_most")};
    if (!(options.range.tracking->band < 0.5 * sample_rate))
      t.at("band").refuse("must be below half the sample rate", "give the highest frequency of the motion");
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
