#include <algorithm>

#include "control/figures.hpp"
#include "input/design_sections.hpp"
#include "input/spec_format.hpp"

namespace qerr {

namespace {

void read_goal(const Object& o, const Spec& spec, DesignRequest& request) {
  const std::string goal = o.text("minimize").value_or("price");
  if (goal == "resolution") {
    request.minimize = DesignRequest::Minimize::resolution;
  } else if (goal != "price") {
    if (goal.find('.') == std::string::npos)
      throw Error(o.at("minimize")
                      .fault("is nothing that can be minimized",
                             "write price, resolution, or a quantity such as position.x.sigma"));
    if (spec.model.control)
      for (const ControlFigure& f : control_figures(*spec.model.control, spec.model.chain))
        if (f.name == goal && f.kind != ControlFigure::Kind::limit_cycle)
          throw Error(
              o.at("minimize")
                  .fault("is the better the larger it is", "require at_least of it, and minimize the price"));
    request.minimize = DesignRequest::Minimize::figure;
    request.figure =
        figure_entry(o.at("minimize"), o.has("statistic") ? o.at("statistic").node : nullptr, spec);
  }
  if (o.has("statistic") && request.minimize != DesignRequest::Minimize::figure)
    throw Error(o.at("statistic").fault("belongs to a quantity that is minimized", "remove it"));
  if (!o.has("budget")) return;
  if (request.minimize != DesignRequest::Minimize::figure)
    throw Error(o.at("budget").fault("limits the price at which a quantity is minimized",
                                     "write 'minimize: position.x.sigma', or remove the budget"));
  Field f = o.at("budget");
  if (f.node->type == Node::Type::mapping) {
    const Object limit(f, {{.name = "at_most", .meaning = "highest price", .required = true, .least = 0}});
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
                      std::any_of(spec.filters.begin(), spec.filters.end(), [&](const NamedFilter& f) {
                        return f.name == text.substr(0, point);
                      }));  // without a statistic
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
    throw Error(quantity.fault("is a limit of encoders, not a figure to choose by",
                               "require it, and name an error, such as position.x.sigma"));
  return entry;
}

void read_design(const Field& f, const std::string& folder, const RobotModel& robot, Spec& spec,
                 Faults& faults) {
  const Object o(f, spec_format::design());
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
    throw Error(f.fault("has nothing to choose", "add encoders: {'*': {bits: 12..23}}, filters or gains"));
  spec.design = request;
}

}  // namespace qerr
