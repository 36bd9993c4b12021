#include <algorithm>
#include <array>
#include <cmath>

#include "core/lists.hpp"
#include "core/text.hpp"
#include "input/bag_file.hpp"
#include "input/log_table.hpp"
#include "input/read_sections.hpp"

namespace qerr {

namespace {

struct SignalName {
  std::string_view name;
  LogSignal signal;
};

constexpr std::array joint_signals{
    SignalName{"counts", LogSignal::counts},          SignalName{"measured", LogSignal::measured},
    SignalName{"reference", LogSignal::reference},    SignalName{"effort", LogSignal::effort},
    SignalName{"velocity", LogSignal::velocity},      SignalName{"command", LogSignal::command},
    SignalName{"temperature", LogSignal::temperature}};

/// A column that a log of this robot can have.
struct KnownColumn {
  std::string name;
  LogSignal signal;
  std::size_t index;
};

std::vector<KnownColumn> known_columns(const Chain& chain) {
  std::vector<KnownColumn> known{{"time", LogSignal::time, 0},
                                 {"tip.x", LogSignal::tip, 0},
                                 {"tip.y", LogSignal::tip, 1},
                                 {"tip.z", LogSignal::tip, 2}};
  for (std::size_t j = 0; j < chain.independent.size(); ++j)
    for (const SignalName& s : joint_signals)
      known.push_back({chain.independent[j].name + '.' + std::string(s.name), s.signal, j});
  return known;
}

Dimension dimension_of(LogSignal signal, std::size_t index, const Chain& chain) {
  const bool prismatic =
      signal != LogSignal::time && signal != LogSignal::tip && chain.independent[index].prismatic();
  switch (signal) {
    case LogSignal::time:
      return dimension::time;
    case LogSignal::counts:
      return dimension::none;
    case LogSignal::effort:
      return prismatic ? Dimension{.newton = 1} : dimension::torque;
    case LogSignal::velocity:
      return prismatic ? dimension::speed : dimension::angular_speed;
    case LogSignal::temperature:
      return dimension::temperature;
    case LogSignal::tip:
      return dimension::length;
    default:
      return prismatic ? dimension::length : dimension::angle;
  }
}

/// An effort may be a current or any quantity proportional to the load: estimated parameters then have its
/// unit.
std::optional<std::pair<std::string, Unit>> arbitrary_effort(const std::string& unit) {
  if (unit.empty() || unit == "1" || unit == "%") return {{"1", Unit{1, unit == "%" ? 100.0 : 1.0, {}}}};
  if (unit == "A") return {{"A", Unit{}}};
  if (unit == "mA") return {{"A", Unit{1, 1000, {}}}};
  return std::nullopt;
}

/// What else a unit may mean that is not known, or is a million of what a log has.
std::string meant_unit(const std::string& unit) {
  if (unit == "grad") return "write [gon], 400 of a turn, or [deg]";
  const std::string lower = lower_case(unit);
  std::string why;
  return lower != unit && parse_unit(lower, why) ? "did you mean [" + lower + "]?" : "";
}

/// Reads the unit of a column from its header; without one the column is in SI units.
void read_unit(LogColumn& column, const Dimension& dimension, const std::string& unit, const Place& place) {
  const bool counts = column.signal == LogSignal::counts;
  column.unit = counts ? "count" : unit_name(dimension);
  column.scale.dimension = dimension;
  if (column.signal == LogSignal::effort)
    if (const auto arbitrary = arbitrary_effort(unit)) {
      std::tie(column.unit, column.scale) = *arbitrary;
      return;
    }
  if (unit.empty()) return;
  std::string why;
  const auto read = parse_unit(unit, why);
  const std::string expected = counts ? "count" : unit_name(dimension);
  const std::string others = column.signal == LogSignal::effort ? ", A, or 1 for an arbitrary unit" : "";
  const std::string meant = meant_unit(unit);
  if (!read)
    throw Error(place, column.header, why, "", meant.empty() ? "such as [" + expected + "]" + others : meant);
  if (unit.starts_with('M') && !meant.empty())
    throw Error(place, column.header, "a million of them", "'" + unit + "'", meant);
  if (read->dimension != dimension || (counts && read->in_si(1) != 1))
    throw Error(place, column.header, "the column has the wrong unit", "'" + unit + "'",
                "use " + expected + (others.empty() ? " or a unit of that kind" : others));
  column.scale = *read;
}

/// " (did you mean 'X'?)" for the nearest known column; "" if none is near.
std::string hint(const std::string& name, const std::vector<std::string>& known) {
  const std::string near = nearest(name, known);
  return near.empty() ? "" : " (did you mean '" + near + "'?)";
}

bool is_position_signal(LogSignal signal) {
  return signal == LogSignal::counts || signal == LogSignal::measured || signal == LogSignal::reference ||
         signal == LogSignal::tip;
}

/// Whether a name is a spelling of a near one: `a7` is not one of `a1`, but the joint of another robot, and
/// `tip.rz` not one of `tip.z`.
bool means(const std::string& name, const std::string& near) {
  const auto digits = [](std::string text) {
    std::erase_if(text, [](char c) { return c < '0' || c > '9'; });
    return text;
  };
  const bool same_length = name.size() == near.size();
  const bool same_end = name.back() == near.back() || name.back() + 32 == near.back();
  return digits(name) == digits(near) && (!near.starts_with("tip.") || (same_length && same_end));
}

/// Finds the columns in one pass over the header, then checks that they are complete.
class ColumnFinder {
 public:
  ColumnFinder(const LogTable& table, const Spec& spec) : table_(table), spec_(spec) {
    known_ = known_columns(spec.model.chain);
    names_ = log_signal_names(spec.model.chain);
    for (std::size_t i = 0; i < table.header().size(); ++i) add(i);
    log_.columns = found_.columns;
    find_misspelt();
  }

  LogColumns checked(std::vector<std::string>& warnings) const {
    check_mapping();
    check_time();
    check_measured();
    if (!unitless_.empty())
      warnings.push_back(table_.file() + ": columns without a unit are read in SI units: " + unitless_);
    if (!units_.empty()) warnings.push_back(table_.file() + ": units as they are understood: " + units_);
    if (const std::string clock = log_.has_time() ? "" : likely_time(table_, spec_); !clock.empty())
      warnings.push_back(table_.file() +
                         ": no column is called time, and the log is taken for static poses; if " +
                         quoted(clock) + " is the time: --column " + shell_word("time=" + clock));
    if (!ignored_.empty())
      warnings.push_back(table_.file() + ": columns that the log does not use are ignored: " + ignored_);
    return found_;
  }

 private:
  void add(std::size_t i) {
    const LogHeader& header = table_.header()[i];
    const ColumnMeaning& meaning = header.meaning;
    if (header.text.empty() && meaning.signal != "time") return;  // behind a separator at the end of the rows
    const auto found = std::ranges::find(names_, meaning.signal);
    if (found == names_.end()) {
      refuse_unknown_unit(header);
      ignored_ += (ignored_.empty() ? "'" : ", '") + header.text + "'" + hint(meaning.signal, names_);
      ignored_names_.push_back(meaning.signal);
      ignored_places_.push_back(i);
      return;
    }
    const KnownColumn& known = known_[found - names_.begin()];
    for (std::size_t k = 0; k < found_.columns.size(); ++k)
      if (found_.columns[k].signal == known.signal && found_.columns[k].index == known.index)
        throw duplicate(table_.header()[found_.places[k]], header);
    const bool position = known.signal == LogSignal::measured || known.signal == LogSignal::reference;
    if (meaning.unit.empty() && position) refuse_counts(header, i, known);
    const LogColumn column = column_of(header, known.signal, known.index, spec_.model.chain);
    if (meaning.unit.empty() && known.signal != LogSignal::counts && known.signal != LogSignal::effort)
      unitless_ += (unitless_.empty() ? "'" : ", '") + header.text + "'";
    else if (known.signal != LogSignal::time && !meaning.mapped && !meaning.unit.empty() &&
             column_name(header.text).unit != meaning.unit)
      units_ += (units_.empty() ? "'" : ", '") + header.text + "' in " + meaning.unit;
    found_.columns.push_back(column);
    found_.places.push_back(i);
  }

  /// `elbow.reference (arc seconds)`: a signal, but for its unit.
  void refuse_unknown_unit(const LogHeader& header) const {
    for (std::size_t k = 0; k < names_.size(); ++k) {
      if (!header.text.starts_with(names_[k]) || header.text.size() == names_[k].size()) continue;
      const std::string behind(trimmed(std::string_view(header.text).substr(names_[k].size())));
      if (!behind.starts_with('(') && !behind.starts_with('[')) continue;
      const std::string unit = unit_name(dimension_of(known_[k].signal, known_[k].index, spec_.model.chain));
      throw Error(header.place, header.text, "unknown unit", quoted(behind),
                  "such as [" + unit + "], or what one step is: [0.001 " + unit + ']');
    }
  }

  /// A position without a unit that is whole and far beyond any turn is of counts, not of rad or m.
  void refuse_counts(const LogHeader& header, std::size_t i, const KnownColumn& known) const {
    constexpr double farthest = 1000;  // [rad, m]
    std::size_t far = 0;
    for (const std::string& text : table_.first_texts(i)) {
      const auto value = parse_number(text);
      if (!value || *value != std::floor(*value)) return;
      far += std::abs(*value) > farthest;
    }
    if (far == 0) return;
    const Dimension d = dimension_of(known.signal, known.index, spec_.model.chain);
    throw Error(header.place, header.text,
                "whole numbers beyond 1000 " + unit_name(d) + " without a unit: are they counts?", "",
                "write what one of them is behind the name: '" + header.text +
                    (d == dimension::length ? " [0.001 mm]'" : " [360/4096 deg]'"));
  }

  /// Positions that the log lacks, and that an ignored column is nearly called.
  void find_misspelt() {
    for (const std::string& name : ignored_names_) {
      const std::string near = nearest(name, names_);
      if (near.empty() || !means(name, near)) continue;
      const auto at = std::ranges::find(names_, near) - names_.begin();
      const KnownColumn& known = known_[at];
      if (is_position_signal(known.signal) && !log_.find(known.signal, known.index))
        found_.misspelt.push_back(known.signal == LogSignal::tip ? near : near.substr(0, near.rfind('.')));
    }
  }

  static Error duplicate(const LogHeader& first, const LogHeader& second) {
    const bool one_file = first.place.file == second.place.file;
    const bool parts = !one_file && is_bag(first.place.file) && is_bag(second.place.file);
    return Error(second.place, second.text, "duplicate column",
                 one_file ? "" : "'" + first.text + "' in " + first.place.file,
                 parts ? "of one recording in several files name the folder" : "keep one of them");
  }

  /// Every column of the mapping must be in a file.
  void check_mapping() const {
    for (const LogSource& source : spec_.log.columns) {
      const bool found = std::ranges::any_of(table_.header(), [&](const LogHeader& h) {
        return h.meaning.mapped && h.meaning.signal == source.signal;
      });
      if (found) continue;
      std::vector<std::string> all;
      for (const LogHeader& h : table_.header()) {
        if (h.meaning.mapped && h.text == source.column)
          throw Error(h.place, "log.columns." + source.signal, "a column is one quantity of the log",
                      quoted(source.column) + ", which is mapped to " + quoted(h.meaning.signal) + ", too",
                      "take out one of the two mappings");
        if (!h.text.empty()) all.push_back(h.text);
      }
      throw Error(table_.header()[0].place, "log.columns." + source.signal, "the log has no such column",
                  quoted(source.column), did_you_mean(source.column, all));
    }
  }

  /// A table without time is diagnosed as a static one; several columns that may be the time must not cause
  /// that silently.
  void check_time() const {
    if (log_.has_time()) return;
    for (std::size_t i = 0; i < ignored_places_.size(); ++i)
      if (is_time_name(ignored_names_[i]))
        raise({table_.header()[ignored_places_[i]].place, table_.header()[ignored_places_[i]].text,
               "no column is called time, and several may be it", "",
               "say which with --column time=" + shell_word(table_.header()[ignored_places_[i]].text)});
  }

  void check_measured() const {
    const auto& joints = spec_.model.chain.independent;
    bool any = false;
    for (std::size_t j = 0; j < joints.size(); ++j) {
      const bool measured = is_measured(log_, spec_.model.transmission, j);
      any = any || measured;
      if (measured) continue;
      if (log_.find(LogSignal::reference, j)) missing(j, "the joint has a reference but no measurement");
      for (std::size_t i = 0; i < 3; ++i)
        if (log_.find(LogSignal::tip, i)) missing(j, "the tip was tracked, but a joint was not measured");
    }
    if (!any) missing(0, "the log has no measured joint");
  }

  [[noreturn]] void missing(std::size_t joint, const std::string& rule) const {
    const std::string& name = spec_.model.chain.independent[joint].name;
    const std::string near = nearest(name + ".counts", ignored_names_);
    const bool coupled = log_.find(LogSignal::counts, joint).has_value();
    std::string remedy =
        coupled ? "its position needs the counts of the encoders it is coupled with, or '" + name +
                      ".measured [" + unit_of(joint) + "]'"
                : "add '" + name + ".counts' or '" + name + ".measured [" + unit_of(joint) + "]'";
    if (!near.empty()) remedy += "; is it '" + near + "'?";
    raise({table_.header()[0].place, name, rule, "", remedy}, name);
  }

  /// A fault of the columns, and what may be meant by columns of other names.
  /// @param joint  that is not measured
  [[noreturn]] void raise(const Fault& fault, const std::string& joint = "") const {
    const MappingProposal proposal = proposed_mapping(table_, spec_);
    Fault answered = fault;
    if (proposal.reading.columns.size() <= spec_.log.columns.size()) {
      // What the columns are called is not repeated: the file may be none for qerr.
      if (!joint.empty())
        answered.remedy += "; or say which of its " + std::to_string(table_.header().size()) +
                           " columns that is: --column " + joint + ".counts=COLUMN (qerr help logs)";
      std::vector<Fault> faults{answered};
      for (const std::string& column : proposal.left_out) faults.push_back({{}, "", "", "", column});
      throw Error(faults);
    }
    answered.remedy += "; or map its columns, as guessed here by names and values:";
    throw Error({answered, {{}, "", "", "", mapping_text(proposal)}});
  }

  std::string unit_of(std::size_t joint) const { return spec_.model.chain.independent[joint].unit(); }

  const LogTable& table_;
  const Spec& spec_;
  std::vector<KnownColumn> known_;
  std::vector<std::string> names_, ignored_names_;
  std::vector<std::size_t> ignored_places_;
  std::string ignored_, unitless_, units_;
  LogColumns found_;
  Log log_;
};

}  // namespace

LogColumn column_of(const LogHeader& header, LogSignal signal, std::size_t index, const Chain& chain) {
  LogColumn column;
  column.signal = signal, column.index = index, column.header = header.text;
  read_unit(column, dimension_of(signal, index, chain), header.meaning.unit, header.place);
  return column;
}

Unit time_unit(const std::string& unit, const std::string& header, const Place& place) {
  LogColumn column;
  column.header = header;
  read_unit(column, dimension::time, unit, place);
  return column.scale;
}

std::vector<std::string> log_signal_names(const Chain& chain) { return names_of(known_columns(chain)); }

void require_log_signal(const std::string& name, const Place& place, const std::string& path,
                        const Chain& chain) {
  const std::vector<std::string> known = log_signal_names(chain);
  if (!contains(known, name))
    throw Error(place, path, "no signal of this robot's logs", quoted(name), did_you_mean(name, known));
}

LogColumns find_log_columns(const LogTable& table, const Spec& spec, std::vector<std::string>& warnings) {
  return ColumnFinder(table, spec).checked(warnings);
}

}  // namespace qerr
