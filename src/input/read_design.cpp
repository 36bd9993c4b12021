#include <algorithm>
#include <cmath>
#include <map>

#include "control/control.hpp"
#include "core/lists.hpp"
#include "core/text.hpp"
#include "input/design_request.hpp"
#include "input/joint_entries.hpp"
#include "input/read_sections.hpp"
#include "qerr/encoder/encoder.hpp"
#include "qerr/filter/family.hpp"

namespace qerr {

namespace {

double price_at(const Field& f) { return read_number(f, {.name = "price", .least = 0}); }

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

/// `design.gains`: the values that kp and kd of controllers may take. @pre control is read
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

/// Families with an order, a cut-off and nothing else that must be stated.
std::vector<std::string> searched_families() {
  std::vector<std::string> names;
  for (const FilterFamily& family : filter_families()) {
    const auto has = [&](std::string_view key) { return has_row(family.parameters, key); };
    const bool more = std::ranges::any_of(family.parameters, [](const Parameter& p) {
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

/// `design.filters`: what each filter of the spec may become.
void read_design_filters(const Field& f, const Spec& spec, DesignRequest& request, Faults& faults) {
  for (const auto& entry : read_map(f)) {
    const Node::Key& key = entry.first;
    const Field& field = entry.second;
    faults.guard([&] { request.filters.push_back(read_filter_options(key, field, spec)); });
  }
}

/// Reads the options of one entry of `design.encoders`.
class OptionReader {
 public:
  OptionReader(const Field& f, const std::string& folder, bool priced)
      : field_(f), folder_(folder), priced_(priced) {}

  std::vector<EncoderOption> read(std::string& price_unit) {
    check_keys();
    const Node* const catalogue = field_.node->find("catalogue");
    std::vector<EncoderOption> options =
        catalogue ? of_catalogue({catalogue, field_.path + ".catalogue"}, price_unit)
                  : std::vector<EncoderOption>{{"", empty_entry(), {}, 0, 0}};
    for (const Node::Entry& entry : field_.node->entries)
      if (is_encoder_key(entry.key.name)) options = crossed(options, entry);
    if (!catalogue) {
      encoder_kind_of({&options.front().entry, field_.path});  // states exactly one
      set_prices(options);
    }
    return options;
  }

 private:
  Node empty_entry() const {
    Node node = mapping_node({});
    node.place = field_.node->place;
    return node;
  }

  Field at(const std::string& key) const { return {field_.node->find(key), field_.path_of(key)}; }

  void check_keys() const {
    if (field_.node->type != Node::Type::mapping)
      field_.refuse("must be a mapping", "write {catalogue: FILE.csv} or {bits: 12..23}");
    std::vector<std::string> known = encoder_keys();
    known.insert(known.end(), {"catalogue", "price", "gear_price"});
    for (const Node::Entry& entry : field_.node->entries)
      if (!contains(known, entry.key.name))
        throw Error(entry.key.place, field_.path_of(entry.key.name), "unknown key",
                    qerr::quoted(entry.key.name), did_you_mean(entry.key.name, known));
    if (field_.node->find("catalogue") && field_.node->find("price"))
      at("price").refuse("the catalogue has the prices", "remove price");
    if (field_.node->find("gear_price") && !field_.node->find("gear_ratio"))
      at("gear_price").refuse("is the price of a gear ratio, and there is none", "add gear_ratio");
  }

  std::vector<EncoderOption> of_catalogue(const Field& f, std::string& price_unit) const {
    const std::string path = read_text_value(f);
    const std::string full = folder_.empty() || path.starts_with('/') ? path : folder_ + '/' + path;
    Catalogue catalogue;
    read_named_file(f, full, [&](const std::string& file) { catalogue = read_catalogue(file); });
    if (price_unit.empty()) price_unit = catalogue.price_unit;
    if (price_unit != catalogue.price_unit && !catalogue.price_unit.empty())
      f.refuse("its prices are in " + catalogue.price_unit + ", those of another catalogue in " + price_unit,
               "convert one of them");
    std::vector<EncoderOption> options;
    std::vector<Fault> faults;
    for (const CatalogueRow& row : catalogue.rows) {
      if (priced_ && !row.price)
        faults.push_back({row.place, "price", "the price of " + qerr::quoted(row.name) + " is missing", "",
                          "add it, remove the row, or write 'minimize: resolution', which needs no prices"});
      options.push_back({row.name, row.entry, row.effects, row.price, 0});
    }
    if (!faults.empty()) throw Error(faults);
    return options;
  }

  std::vector<EncoderOption> crossed(const std::vector<EncoderOption>& options,
                                     const Node::Entry& entry) const {
    const std::string& key = entry.key.name;
    const Field f = at(key);
    const std::vector<Node> values = values_of(f);
    const std::vector<double> prices =
        key == "gear_ratio" ? gear_prices(values.size()) : std::vector<double>{};
    if (options.size() * values.size() > most_options)
      field_.refuse("gives more than 10000 options", "list the ones that can be bought");
    std::vector<EncoderOption> all;
    for (const EncoderOption& option : options) {
      if (option.entry.find(key)) {
        // Of a row that states its own, a price of the value here would be another one's.
        if (!prices.empty())
          f.refuse("the catalogue states it for " + qerr::quoted(option.name),
                   "remove gear_price here, or the column from the catalogue");
        all.push_back(option);
        continue;
      }
      for (std::size_t i = 0; i < values.size(); ++i) {
        EncoderOption& added = all.emplace_back(option);
        added.entry.entries.push_back({entry.key, values[i]});
        if (!prices.empty() && added.price) *added.price += prices[i];
        if (values.size() > 1 || (option.name.empty() && field_.node->entries.size() == 1))
          added.name += (added.name.empty() ? "" : ", ") + key + ' ' + values[i].text;
      }
    }
    return all;
  }

  std::vector<double> gear_prices(std::size_t ratios) const {
    if (!field_.node->find("gear_price")) return {};
    const Field f = at("gear_price");
    if (f.node->type == Node::Type::scalar) return std::vector<double>(ratios, price_at(f));
    std::vector<double> prices;
    for (const Field& item : read_list(f)) prices.push_back(price_at(item));
    if (prices.size() != ratios)
      f.refuse("must be as many as the gear ratios, " + std::to_string(ratios),
               "give one price for each gear ratio, in their order");
    return prices;
  }

  /// `price: {fixed: 20, per_bit: 3}`, or a list with one price for each option; else 1 a bit.
  void set_prices(std::vector<EncoderOption>& options) const {
    for (EncoderOption& option : options) {
      if (option.name.empty()) option.name = "as stated";
      option.price_per_bit = 1;
    }
    if (!field_.node->find("price")) return;
    const Field f = at("price");
    if (f.node->type == Node::Type::sequence) return set_listed_prices(f, options);
    if (f.node->type != Node::Type::mapping)
      f.refuse("is ambiguous: of each, or of a bit?",
               "write {per_bit: 2}, {fixed: 50}, both, or a list with one price for each value");
    const Object o(f, {key::number("fixed", "of each").otherwise(0.0).from(0),
                       key::number("per_bit", "of a bit").otherwise(0.0).from(0)});
    for (EncoderOption& option : options) {
      *option.price += *o.number("fixed");
      option.price_per_bit = *o.number("per_bit");
    }
  }

  void set_listed_prices(const Field& f, std::vector<EncoderOption>& options) const {
    const std::vector<Field> prices = read_list(f);
    std::size_t lists = 0;
    const Node::Entry* list = nullptr;
    for (const Node::Entry& entry : field_.node->entries)
      if (is_encoder_key(entry.key.name) && entry.key.name != "gear_ratio" &&
          values_of(at(entry.key.name)).size() > 1) {
        ++lists;
        list = &entry;
      }
    const std::size_t wanted = list ? values_of(at(list->key.name)).size() : 1;
    if (lists > 1 || prices.size() != wanted)
      f.refuse(lists > 1 ? "several keys have several values: of which are these the prices?"
                         : "must have one price for each value, " + std::to_string(wanted),
               "or write {fixed: 50, per_bit: 2}, or a catalogue");
    for (EncoderOption& option : options) {
      std::size_t index = 0;
      if (list) {
        const std::vector<Node> values = values_of(at(list->key.name));
        while (values[index].text != option.entry.find(list->key.name)->text) ++index;
      }
      *option.price += price_at(prices[index]);
      option.price_per_bit = 0;
    }
  }

  Field field_;
  std::string folder_;
  bool priced_;
};

/// `design.encoders`: what each joint may have.
/// @param priced  a price is minimized or limited, so that each option must state one
void read_design_encoders(const Field& f, const std::string& folder, const RobotModel& robot, bool priced,
                          Spec& spec, DesignRequest& request, Faults& faults) {
  if (read_map(f).empty())
    f.refuse("names no joint", "write '*': {bits: 12..23} for all, or leave the section out");
  const std::vector<JointEntry> entries = joint_entries(f, robot, spec, faults);
  std::map<std::string, std::optional<std::vector<EncoderOption>>> read;  // by the entry's path
  for (std::size_t j = 0; j < entries.size(); ++j) {
    if (!entries[j].given()) continue;
    const Field& entry = entries[j].holding();
    if (!read.contains(entry.path)) {
      auto& options = read[entry.path];
      faults.guard([&] { options = OptionReader(entry, folder, priced).read(request.price_unit); });
    }
    if (const auto& options = read[entry.path]) request.encoders.push_back({j, *options});
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

}  // namespace qerr
