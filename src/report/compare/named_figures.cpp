#include <algorithm>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/lists.hpp"
#include "core/text.hpp"
#include "qerr/bound/figure.hpp"
#include "qerr/core/error.hpp"
#include "qerr/report/comparison.hpp"
#include "qerr/report/filter_report.hpp"
#include "report/compare/parts.hpp"
#include "report/formats.hpp"

namespace qerr {

namespace {

constexpr const char* written_anew = "write the report anew with --format json";

/// A value in a JSON report, with its path for messages. Borrows the report and the name of its file.
class ReportMember {
 public:
  ReportMember(const Json& value, const std::string& file, std::string path = "")
      : value_(&value), file_(&file), path_(std::move(path)) {}
  ReportMember(Json&&, const std::string&) = delete;

  /// Empty if the member is missing.
  std::optional<ReportMember> find(std::string_view name) const {
    const auto member = value_->find(std::string(name));
    if (member == value_->end()) return {};
    return ReportMember(*member, *file_, path_ + (path_.empty() ? "" : ".") + std::string(name));
  }
  /// @throws Error (input) if the member is missing, or this is no object
  ReportMember at(std::string_view name) const {
    if (const auto member = find(name)) return *member;
    throw fault("missing member '" + std::string(name) + "'", "", written_anew);
  }
  /// @throws Error (input) if this is no array
  std::vector<ReportMember> items() const {
    if (!value_->is_array()) throw unlike("a list");
    std::vector<ReportMember> all;
    for (const Json& item : *value_)
      all.emplace_back(item, *file_, path_ + '[' + std::to_string(all.size()) + ']');
    return all;
  }
  /// Name and value of each member. @throws Error (input) if this is no object
  std::vector<std::pair<std::string, ReportMember>> members() const {
    if (!value_->is_object()) throw unlike("an object");
    std::vector<std::pair<std::string, ReportMember>> all;
    for (const auto& [name, value] : value_->items()) all.emplace_back(name, *find(name));
    return all;
  }

  bool is_null() const { return value_->is_null(); }
  const std::string& text() const {
    if (!value_->is_string()) throw unlike("a text");
    return value_->get_ref<const std::string&>();
  }
  bool boolean() const {
    if (!value_->is_boolean()) throw unlike("true or false");
    return value_->get<bool>();
  }
  double number() const {
    if (!value_->is_number()) throw unlike("a number");
    return value_->get<double>() + 0.0;  // -0 is 0
  }
  /// @param of_null  the value that null stands for
  double number_or(double of_null) const { return is_null() ? of_null : number(); }

  Error fault(const std::string& rule, const std::string& found, const std::string& remedy) const {
    return Error({*file_}, path_, rule, found, remedy);
  }

 private:
  Error unlike(const std::string& wanted) const {
    const std::string found = line(*value_);
    return fault("must be " + wanted, found.size() > 40 ? found.substr(0, 40) + "..." : found, written_anew);
  }

  const Json* value_;
  const std::string* file_;
  std::string path_;
};

/// Reads reports as lists of named figures.

/// What null stands for where a figure always exists.
constexpr double unbounded = std::numeric_limits<double>::infinity();

void add_figure(NamedFigure figure, NamedFigures& to) {
  if (!find_figure(to, figure)) to.figures.push_back(std::move(figure));
}

/// The bounds of each coordinate; nothing of one that is null, which is not known.
void add_bounds(const std::string& of_rows, const ReportMember& rows, NamedFigures& to) {
  for (const ReportMember& row : rows.items()) {
    const auto own = row.find("signal");
    const std::string signal = own ? own->text() : of_rows;
    for (const std::string bound :
         {"worst_case", "worst_case_rigorous", "sigma", "sigma_quantization", "sigma_in_motion"}) {
      const auto statistic = row.find(bound);
      if (!statistic || statistic->is_null()) continue;
      for (const StatisticKind& kind : statistic_kinds())
        add_figure({signal + '.' + row.at("coordinate").text() + '.' + bound, std::string(kind.name),
                    row.at("unit").text(), statistic->at(kind.name).number_or(unbounded)},
                   to);
      if (const auto proven = statistic->find("proven"))
        add_figure({signal + '.' + row.at("coordinate").text() + '.' + bound, std::string(proven_statistic),
                    row.at("unit").text(), proven->at("upper").number_or(unbounded)},
                   to);
    }
  }
}

/// A figure of a filter: its path in a report, and its name, which is that of requirements where they know
/// it.
struct FilterMember {
  std::string_view member, part, name;
  Dimension (*dimension)(int derivative);  ///< where it is no figure of requirements
};

constexpr FilterMember filter_members[] = {
    {"h2_norm", "", "h2_norm", nullptr},
    {"l1_norm", "upper", "l1_norm", nullptr},
    {"group_delay_s", "", "delay", nullptr},
    {"bandwidth_hz", "", "bandwidth", nullptr},
    {"settling_time_s", "", "settling", nullptr},
    {"noise_bandwidth_hz", "", "noise_bandwidth", [](int) { return dimension::frequency; }},
    {"motion_band", "largest", "motion_band.largest", [](int) { return dimension::none; }},
    {"motion_band", "rms", "motion_band.rms", [](int) { return dimension::none; }},
};

std::string member_unit(const FilterMember& row, int derivative) {
  if (row.dimension) return unit_name(row.dimension(derivative));
  Filter filter;
  filter.derivative = derivative;
  return figure_unit(*find_filter_figure(row.name), filter);
}

/// Norms exist always, and null is infinite; null is not known elsewhere.
void add_filter(const std::string& name, const ReportMember& filter, NamedFigures& to) {
  const double stated = filter.at("derivative").number();  // of a file that anybody may have written
  const auto derivative = static_cast<int>(std::clamp(stated, 0.0, double{max_derivative}));
  for (const FilterMember& row : filter_members) {
    auto value = filter.find(row.member);
    if (value && !row.part.empty()) value = value->at(row.part);
    const bool norm = row.member.ends_with("norm");
    if (!value || (value->is_null() && !norm)) continue;
    add_figure(
        {name + '.' + std::string(row.name), "", member_unit(row, derivative), value->number_or(unbounded)},
        to);
  }
}

/// `x.worst_case` is an older name of `position.x.worst_case`, and median of p50.
NamedFigure required_figure(const ReportMember& r) {
  NamedFigure f;
  f.quantity = r.at("quantity").text();
  if (const auto statistic = r.find("statistic")) f.statistic = statistic->text();
  if (f.statistic == "median") f.statistic = "p50";
  if (!f.statistic.empty() && std::ranges::count(f.quantity, '.') == 1) f.quantity = "position." + f.quantity;
  f.unit = r.at("unit").text();
  f.value = r.at("value").number_or(unbounded);
  return f;
}

void add_requirements(const ReportMember& list, NamedFigures& to) {
  for (const ReportMember& r : list.items()) {
    const auto lowest = r.find("at_least");
    to.requirements.push_back({required_figure(r), lowest.has_value(),
                               (lowest ? *lowest : r.at("at_most")).number(), r.at("met").boolean()});
    // `at_least` is judged by what is reached, which is not the proven bound of the same name.
    if (!lowest || to.requirements.back().figure.statistic != proven_statistic)
      add_figure(to.requirements.back().figure, to);
  }
}

/// Loops and walls. Null is unbounded, but of an unstable loop, which has its cycle alone.
void add_control(const ReportMember& report, NamedFigures& to) {
  const auto control = report.find("control");
  if (!control) return;
  const auto unit_of = [&](const std::string& joint) {
    for (const ReportMember& row : report.at("joints").items())
      if (row.at("name").text() == joint) return row.at("unit").text();
    throw report.at("joints").fault("the joint of a loop is missing", quoted(joint), written_anew);
  };
  for (const ReportMember& loop : control->at("loops").items()) {
    const std::string joint = loop.at("joint").text(), name = "loop." + joint + '.';
    const auto cycle = loop.find("limit_cycle");
    add_figure({name + "limit_cycle", "", unit_of(joint),
                cycle && !cycle->is_null() ? cycle->at("bound").number_or(unbounded) : unbounded},
               to);
    if (!loop.at("stable").boolean()) continue;
    add_figure({name + "gain_margin", "", "", loop.at("gain_margin").number_or(unbounded), true}, to);
    add_figure({name + "phase_margin", "", "rad", loop.at("phase_margin").number_or(unbounded), true}, to);
    add_figure({name + "bandwidth", "", "Hz", loop.at("bandwidth").number_or(unbounded), true}, to);
  }
  for (const ReportMember& wall : control->at("walls").items())
    add_figure({"wall." + wall.at("wall").text() + ".stiffness", "", "N/m",
                wall.at("stiffness").number_or(unbounded), true},
               to);
}

void read_analyze(const ReportMember& report, NamedFigures& to) {
  add_bounds("position", report.at("position"), to);
  for (const ReportMember& filter : report.at("derivatives").items()) {
    const std::string& name = filter.at("filter").text();
    add_filter(name, filter, to);
    const auto signal = filter.find("signal");
    add_bounds(signal ? signal->text() : name, filter.at("coordinates"), to);
  }
  for (const auto& [encoder, share] : report.at("budget").members())
    to.shares.push_back({encoder, share.number()});
  add_control(report, to);
}

void read_check(const ReportMember& report, NamedFigures& to) {
  if (report.find("reports"))
    throw report.fault("a report of several specs cannot be compared", "",
                       "check each spec into a file of its own");
  add_requirements(report.at("requirements"), to);
}

void read_filter(const ReportMember& report, NamedFigures& to) {
  for (const ReportMember& filter : report.at("filters").items())
    add_filter(filter.at("name").text(), filter, to);
}

/// A command whose reports can be compared.
struct ComparableCommand {
  std::string_view name;
  void (*read)(const ReportMember&, NamedFigures&);
  Json (*report)(const SpecCheck&);
};

Json analyzed(const SpecCheck& s) { return json_of(s.analysis); }
Json checked(const SpecCheck& s) { return json_of(s); }
Json filtered(const SpecCheck& s) { return json_of(filter_report(s.analysis.spec, {})); }

constexpr ComparableCommand comparable_commands[] = {
    {"analyze", read_analyze, analyzed},
    {"check", read_check, checked},
    {"filter", read_filter, filtered},
};

/// What the figures belong to, in reports of a robot.
void read_origin(const ReportMember& report, NamedFigures& to) {
  if (const auto set = report.at("spec").find("set"); set && to.changes.empty())
    for (const ReportMember& change : set->items())
      to.changes.push_back(change.at("key").text() + '=' + change.at("value").text());
  if (const auto file = report.at("spec").find("file")) to.spec = file->text();
  if (const auto hash = report.at("spec").find("sha256")) to.sha256 = hash->text();
  if (const auto robot = report.find("robot"))
    to.robot = robot->at("name").text() + ", " + robot->at("base").text() + " -> " + robot->at("tip").text();
  if (const auto sample = report.find("configurations"))
    to.sample = sample->at("method").text() + ", " + significant(sample->at("count").number(), 12) +
                " configurations, seed " + significant(report.at("seed").number(), 12);
}

void read_report(const Json& json, const std::string& command, NamedFigures& to) {
  const ReportMember report(json, to.file);
  const auto* const row = find_named(comparable_commands, command);
  if (!row)
    throw report.at("command").fault("only reports of analyze, check and filter can be compared",
                                     quoted(command), "write one with: qerr analyze SPEC -o FILE.json");
  read_origin(report, to);
  row->read(report, to);
}

NamedFigures figures_of(const Json& json, const std::string& file) {
  const auto is_text = [&](const char* name) { return json.contains(name) && json.at(name).is_string(); };
  if (!is_text("qerr") || !is_text("command"))
    throw Error({file, 1, 1}, "", "this is no report of qerr, which begins with its version and command", "",
                "write one with: qerr analyze SPEC -o FILE.json");
  NamedFigures figures;
  figures.file = file;
  figures.command = json.at("command");
  read_report(json, figures.command, figures);
  return figures;
}

}  // namespace

NamedFigures read_named_figures(const std::string& text, const std::string& file) {
  return figures_of(parse_json(text, file), file);
}

std::vector<NamedFigures> read_all_named_figures(const std::string& text, const std::string& file) {
  const Json json = parse_json(text, file);
  const auto reports = json.find("reports");
  if (reports == json.end() || !reports->is_array()) return {figures_of(json, file)};
  std::vector<NamedFigures> all;
  for (const Json& report : *reports) all.push_back(figures_of(report, file));
  return all;
}

NamedFigures named_figures(const SpecCheck& check, const std::string& command) {
  NamedFigures figures;
  figures.file = check.analysis.spec.file;
  figures.command = command;
  for (const ComparableCommand& row : comparable_commands)
    if (command == "spec" || command == row.name)
      read_report(row.report(check), std::string(row.name), figures);
  return figures;
}

}  // namespace qerr
