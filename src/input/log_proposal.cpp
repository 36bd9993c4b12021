#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>
#include <numbers>
#include <set>

#include "core/lists.hpp"
#include "core/text.hpp"
#include "input/log_table.hpp"
#include "input/yaml_tree.hpp"
#include "qerr/core/quantity.hpp"

namespace qerr {

namespace {

/// A whole number of a few digits.
int number_in(const std::string& digits) {
  int number = 0;
  std::from_chars(digits.data(), digits.data() + digits.size(), number);
  return number;
}

class MappingGuess {
 public:
  MappingGuess(const LogTable& table, const Spec& spec) : table_(table), spec_(spec) {
    const std::vector<std::string> known = log_signal_names(spec.model.chain);
    for (std::size_t i = 0; i < table.header().size(); ++i) {
      const ColumnMeaning& meaning = table.header()[i].meaning;
      if (contains(known, meaning.signal))
        taken_.insert(meaning.signal);
      else
        add(i);
    }
    for (const LogSource& source : spec.log.columns) mapping_.push_back(source);
  }

  const std::vector<std::string>& left_out() const { return left_out_; }

  /// The first column that may be the stamps of a log without any.
  std::string likely_time() const {
    for (const GuessedColumn& c : columns_)
      if (!named_joint(c) && is_clock(c)) return text(c) + (c.unit.empty() ? " [s]" : "");
    return "";
  }

  std::vector<LogSource> mapping() {
    const bool named = std::ranges::any_of(
        columns_, [](const GuessedColumn& c) { return c.words.empty() || c.words.front() != "column"; });
    named ? find_joints() : number_joints();
    find_time();
    const std::size_t joints = spec_.model.chain.independent.size();
    bool measured = false;
    for (std::size_t j = 0; j < joints; ++j) measured = take_joint(j) || measured;
    take_tip();
    if (!measured) return {};
    return mapping_;
  }

 private:
  /// The header of a column; its number where the header is in another encoding, and cannot be pasted.
  std::string text(const GuessedColumn& c) const {
    const std::string& header = table_.header()[c.index].text;
    for (std::size_t i = 0; i + 1 < header.size(); ++i) {
      const auto next = static_cast<unsigned char>(header[i + 1]);
      if (header[i] == '\xC2' && next >= 0x80 && next < 0xA0) return "column " + std::to_string(c.index + 1);
    }
    return header;
  }
  const IndependentJoint& joint(std::size_t j) const { return spec_.model.chain.independent[j]; }

  void add(std::size_t i) {
    const ColumnName parts = measured_name(table_.header()[i].text);
    GuessedColumn c{i,  parts.name, parts.unit, words_in(parts.name), numbers_of(table_.first_texts(i)), {},
                    {}, 0,          {}};
    if (c.values.empty() || parts.name.empty()) return;
    if (c.unit == "counts") c.unit = "count";
    find_unknown_unit(c);
    c.role = role_of(c.words);
    if (const auto j = named_joint(c); c.role == ColumnRole::none && j && c.words == words_in(joint(*j).name))
      c.role = ColumnRole::position;
    if (c.role == ColumnRole::other) {
      columns_.push_back(std::move(c));
      return;
    }
    if (has_dimension(c.unit, dimension::angular_speed)) c.role = ColumnRole::velocity;
    if (has_dimension(c.unit, dimension::torque)) c.role = ColumnRole::effort;
    if (c.role == ColumnRole::none && c.unit == "count") c.role = ColumnRole::counts;
    if (c.role == ColumnRole::tip && named_joint(c)) c.role = ColumnRole::position;
    const bool angle = has_dimension(c.unit, dimension::angle);
    if (angle && (c.role == ColumnRole::none || c.role == ColumnRole::tip)) c.role = ColumnRole::position;
    for (const std::string& word : c.words) c.side += side_of(word);
    columns_.push_back(std::move(c));
  }

  /// What stands in brackets behind the name like a unit, and is none, nor a word of the name.
  void find_unknown_unit(GuessedColumn& c) const {
    std::string why;
    const bool current = c.unit == "A" || c.unit == "mA";
    if (!c.unit.empty() && !parse_unit(c.unit, why) && !current) c.unknown_unit = c.unit;
    if (!c.unknown_unit.empty()) c.unit.clear();
    const std::size_t open = c.name.rfind('(');
    if (!c.unit.empty() || !c.name.ends_with(')') || open == std::string::npos || open == 0) return;
    const std::string inside = c.name.substr(open + 1, c.name.size() - open - 2);
    const std::vector<std::string> words = words_in(inside);
    constexpr std::size_t longest_unit = 6;
    const bool of_name = std::ranges::any_of(
        words, [&](const std::string& w) { return is_known_word(w) || (w[0] >= '0' && w[0] <= '9'); });
    GuessedColumn alone{0, inside, {}, words, {}, {}, {}, 0, {}};
    if (of_name || inside.size() > longest_unit || named_joint(alone)) return;
    c.unknown_unit = inside;
    c.name.resize(open);
    c.words = words_in(c.name);
  }

  void add_source(const std::string& signal, const GuessedColumn& c, const std::string& unit) {
    if (taken_.contains(signal)) return;
    used_.insert(c.index);
    if (const std::string why = obstacle(signal, c, unit); !why.empty()) {
      left_out_.push_back(quoted(text(c)) + ", perhaps " + signal + ": " + why);
      return;
    }
    taken_.insert(signal);
    // A unit that the header has, as it is understood, is not repeated.
    mapping_.push_back({signal, text(c), unit == measured_name(text(c)).unit ? "" : unit});
  }

  /// Why a column cannot be mapped to a signal without a user's word; "" if it can.
  std::string obstacle(const std::string& signal, const GuessedColumn& c, const std::string& unit) const {
    if (!c.unknown_unit.empty())
      return "the unit " + quoted(c.unknown_unit) +
             " is not known: write what one of it is behind the name, such as [" +
             (signal == "time" ? "0.1 s" : "0.1 deg") + ']';
    const bool position = signal.ends_with(".measured") || signal.ends_with(".reference");
    if (!position || unit.empty()) return "";
    const auto j = signal_joint(signal);
    const bool prismatic = j && joint(*j).prismatic();
    if (has_dimension(unit, prismatic ? dimension::length : dimension::angle)) return "";
    const std::string what =
        unit == "count" ? "in counts"
                        : "the unit " + quoted(unit) + " is none of " + (prismatic ? "a length" : "an angle");
    return what + ": write what one of it is behind the name, such as [" +
           (prismatic ? "0.001 mm" : "360/4096 deg") + ']';
  }

  std::optional<std::size_t> signal_joint(const std::string& signal) const {
    for (std::size_t j = 0; j < spec_.model.chain.independent.size(); ++j)
      if (signal.starts_with(joint(j).name + '.')) return j;
    return std::nullopt;
  }

  /// The joint whose name a header has; the longest one, as `elbow` is also in `elbow_2`.
  std::optional<std::size_t> named_joint(const GuessedColumn& c) const {
    std::optional<std::size_t> found;
    std::size_t longest = 0;
    for (std::size_t j = 0; j < spec_.model.chain.independent.size(); ++j) {
      const std::vector<std::string> name = words_in(joint(j).name);
      const auto at = std::search(c.words.begin(), c.words.end(), name.begin(), name.end());
      if (name.empty() || name.size() <= longest || at == c.words.end()) continue;
      longest = name.size(), found = j;
    }
    return found;
  }

  /// Columns whose names differ by one number only, such as `actual_q_0` to `actual_q_5`, are those of the
  /// joints in the order of the chain.
  void find_joints() {
    std::map<std::string, std::map<int, GuessedColumn*>> families;
    for (GuessedColumn& c : columns_) {
      if (c.role == ColumnRole::tip) continue;
      const auto number = std::find_if(c.words.rbegin(), c.words.rend(), [](const std::string& w) {
        return w[0] >= '0' && w[0] <= '9' && w.size() < 4;
      });
      std::string family;
      for (auto word = c.words.rbegin(); word != c.words.rend(); ++word)
        family += word == number ? "#" : *word + ' ';
      families[family][number == c.words.rend() ? 0 : number_in(*number)] = &c;
    }
    // `tau_J[2]` is the third of its kind, and no torque of a joint called j2.
    for (auto& [family, members] : families)
      if (members.size() < 2 || members.begin()->first != 0)
        for (auto& [number, column] : members) column->joint = named_joint(*column);
    const std::size_t joints = spec_.model.chain.independent.size();
    const bool from_zero = std::ranges::any_of(families, [](const auto& f) {
      return f.second.begin()->first == 0 && f.first.find('#') != std::string::npos;
    });
    for (auto& [family, members] : families)
      for (auto& [number, column] : members) {
        const bool numbered = family.find('#') != std::string::npos;
        const int index = numbered ? number - !from_zero : 0;
        if (!column->joint && (numbered || joints == 1) && static_cast<std::size_t>(index) < joints)
          column->joint = static_cast<std::size_t>(index);
      }
    name_joints_in_order();
    if (joints == 1) find_pair();
  }

  /// Gives the positions of a single joint to the only two columns that follow each other, `ch1` and `ch2`,
  /// where no name says more.
  void find_pair() {
    const auto is_position = [](const GuessedColumn& c) {
      return c.role == ColumnRole::position || c.role == ColumnRole::counts;
    };
    if (std::ranges::any_of(columns_, is_position)) return;
    std::pair<GuessedColumn*, GuessedColumn*> pair{};
    for (GuessedColumn& a : columns_)
      for (GuessedColumn& b : columns_) {
        if (&a >= &b || a.role != ColumnRole::none || b.role != ColumnRole::none) continue;
        if (std::abs(correlation_of(a.values, b.values)) < follows) continue;
        if (pair.first) return;
        pair = {&a, &b};
      }
    if (pair.first) pair.first->role = pair.second->role = ColumnRole::position;
  }

  /// Where no header has the name of a joint, but the headers have as many names as there are joints, in
  /// another language say, they are the joints in the order of the chain.
  void name_joints_in_order() {
    std::vector<std::string> names;
    std::vector<std::pair<GuessedColumn*, std::size_t>> named;
    for (GuessedColumn& c : columns_) {
      if (c.joint) return;
      if (c.role != ColumnRole::position && c.role != ColumnRole::counts) continue;
      std::string name;
      for (const std::string& word : c.words)
        if (!is_known_word(word)) name += (name.empty() ? "" : " ") + word;
      if (name.empty()) return;
      const auto at = std::ranges::find(names, name);
      named.emplace_back(&c, at - names.begin());
      if (at == names.end()) names.push_back(name);
    }
    if (names.size() != spec_.model.chain.independent.size()) return;
    for (const auto& [column, joint] : named) column->joint = joint;
  }

  /// Names the columns of a table without header: the first column that rises is the time, the others are the
  /// joints in order; where cells of a row say the joints' names, as `ros2 topic echo --csv` of a JointState
  /// writes them, their positions are behind the names.
  void number_joints() {
    const std::size_t joints = spec_.model.chain.independent.size();
    std::vector<std::string> header;
    std::vector<std::optional<std::size_t>> names;
    std::size_t behind_names = 0;
    for (std::size_t i = 0; i < table_.header().size(); ++i) {
      header.push_back(table_.header()[i].text);
      const std::vector<std::string> texts = table_.first_texts(i);
      const auto j = texts.empty() ? std::nullopt : joint_called(texts[0]);
      if (!j && (names.empty() || behind_names != i)) continue;
      if (!j && (texts.empty() || parse_number(texts[0]))) continue;
      names.push_back(j);
      behind_names = i + 1;
    }
    std::size_t next = 0;
    std::optional<std::size_t> nanoseconds;
    for (GuessedColumn& c : columns_) {
      const bool rises = std::ranges::is_sorted(c.values) && c.values.front() < c.values.back();
      if (next == 0 && rises && !taken_.contains("time")) {
        nanoseconds =
            nanoseconds_behind(header, c.index, [&](std::size_t i) { return table_.first_texts(i); });
        add_source("time", c, nanoseconds ? "s" : time_unit_of(c));
        continue;
      }
      if (c.index == nanoseconds) continue;
      if (names.empty()) {
        c.role = ColumnRole::position;
        c.joint = next++ % joints;
      } else if (c.index >= behind_names) {
        constexpr ColumnRole roles[] = {ColumnRole::position, ColumnRole::velocity, ColumnRole::effort};
        const std::size_t block = (c.index - behind_names) / names.size();
        if (block > 2) continue;
        c.joint = names[(c.index - behind_names) % names.size()];
        c.role = roles[block];
        c.unit = block == 0 ? "rad" : block == 1 ? "rad/s" : "N m";  // REP 103
        ++next;
      }
    }
  }

  std::optional<std::size_t> joint_called(const std::string& name) const {
    for (std::size_t j = 0; j < spec_.model.chain.independent.size(); ++j)
      if (joint(j).name == name) return j;
    return std::nullopt;
  }

  std::string time_unit_of(const GuessedColumn& c) const {
    if (has_dimension(c.unit, dimension::time)) return c.unit;
    if (const std::string epoch = epoch_unit(c.values.front()); !epoch.empty()) return epoch;
    std::vector<std::string> header;
    for (const LogHeader& h : table_.header()) header.push_back(h.text);
    const std::string program = program_time_unit(header);
    return program.empty() ? unit_of_steps(c.values) : program;
  }

  /// The stamps: a column that does not decrease, called like the time, if the log has none yet.
  void find_time() {
    if (taken_.contains("time")) return;
    const GuessedColumn* best = nullptr;
    for (const GuessedColumn& c : columns_) {
      const bool named = is_time_name(c.name);
      const bool partly = std::ranges::any_of(c.words, [](const std::string& w) {
        return has_word(
            " time timestamp stamp zeit temps sec seconds secs millis micros t duration elapsed datum date "
            "uhrzeit ts "
            "uptime ",
            w);
      });
      if ((!named && !partly) || c.joint || !std::ranges::is_sorted(c.values)) continue;
      if (c.values.size() > 1 && c.values.front() == c.values.back()) continue;
      if (!best || (named && !is_time_name(best->name))) best = &c;
    }
    if (!best && !columns_.empty() && is_clock(columns_.front())) best = &columns_.front();
    if (best) add_source("time", *best, time_unit_of(*best));
  }

  /// Whether a column without a word for it rises in equal steps, which are no row numbers.
  static bool is_clock(const GuessedColumn& c) {
    if (c.values.size() < 3 || c.role != ColumnRole::none) return false;
    const double step = c.values[1] - c.values[0];
    for (std::size_t i = 1; i < c.values.size(); ++i)
      if (std::abs(c.values[i] - c.values[i - 1] - step) > 1e-3 * step) return false;
    return step > 0 && step != 1;
  }

  /// Signals of a joint. @returns whether it is measured then
  bool take_joint(std::size_t j) {
    std::vector<const GuessedColumn*> positions;
    for (const GuessedColumn& c : columns_) {
      if (c.joint != j || used_.contains(c.index)) continue;
      if (c.role == ColumnRole::position || c.role == ColumnRole::counts) positions.push_back(&c);
    }
    if (const auto like = lone_follower(positions)) positions.push_back(*like);
    // From the motor to the load; of two alike the coarser one is that of the encoder.
    std::ranges::stable_sort(positions, [](const auto* a, const auto* b) {
      const int x = a->side - (a->role == ColumnRole::counts), y = b->side - (b->role == ColumnRole::counts);
      if (x != y) return x < y;
      // Counts of one motion: fewer of the coarser one.
      if (a->whole() && b->whole() && a->largest() > 0) return a->largest() < b->largest();
      return a->smallest_step() > b->smallest_step();
    });
    const std::string& name = joint(j).name;
    const bool known = taken_.contains(name + ".counts") || taken_.contains(name + ".measured");
    std::size_t next = 0;
    // The only column of a sensor beside the robot is no reading of its encoder.
    const bool of_sensor = positions.size() == 1 && positions[0]->side > 1;
    if (!known && !positions.empty() && !of_sensor) take_measured(name, j, *positions[next++]);
    if (next < positions.size() && !taken_.contains(name + ".reference"))
      add_source(name + ".reference", *positions.back(), position_unit(*positions.back(), j));
    if (known || !positions.empty()) take_others(name, j);
    return taken_.contains(name + ".counts") || taken_.contains(name + ".measured");
  }

  /// The only other column whose values follow the position of a joint that has one, whatever it is called.
  std::optional<const GuessedColumn*> lone_follower(
      const std::vector<const GuessedColumn*>& positions) const {
    if (positions.size() != 1 || positions[0]->smallest_step() == 0) return std::nullopt;
    std::optional<const GuessedColumn*> found;
    for (const GuessedColumn& c : columns_) {
      if (&c == positions[0] || used_.contains(c.index)) continue;
      if (c.role != ColumnRole::none && c.role != ColumnRole::position) continue;
      if (std::abs(correlation_of(positions[0]->values, c.values)) < follows) continue;
      if (found) return std::nullopt;
      found = &c;
    }
    return found;
  }

  void take_measured(const std::string& name, std::size_t j, const GuessedColumn& c) {
    const std::string unit = position_unit(c, j);
    const bool as_counts = unit == "count";
    add_source(name + (as_counts ? ".counts" : ".measured"), c, as_counts ? "" : unit);
  }

  /// The unit of a position: that of the header, else by its values: whole numbers are counts, angles beyond
  /// the joint's limits in rad are degrees, lengths beyond 10 m millimetres.
  std::string position_unit(const GuessedColumn& c, std::size_t j) const {
    if (!joint(j).prismatic() && (c.unit == "min" || c.unit == "s"))
      return "arc" + (c.unit == "s" ? "sec" : c.unit);
    if (!c.unit.empty()) return c.unit;
    if (c.role == ColumnRole::counts) return "count";
    const double most = c.largest();
    constexpr double fewest_counts = 20;
    const bool counts = c.whole() && most >= fewest_counts;
    if (counts && c.smallest_step() > 0) return "count";
    if (joint(j).prismatic()) return most > 10 ? "mm" : "m";
    if (is_moteus()) return "rev";
    const auto& limits = joint(j).limits;
    const double farthest =
        limits ? std::max(std::abs(limits->lower), std::abs(limits->upper)) : 4 * std::numbers::pi;
    constexpr double slack = 1.1;
    return most > slack * std::max(farthest, 1.0) ? "deg" : "rad";
  }

  /// moteus writes turns: its columns are `position`, `velocity`, and `q_current` or `fault` beside them.
  bool is_moteus() const {
    bool position = false, current = false;
    for (const LogHeader& h : table_.header()) {
      const std::vector<std::string> words = words_in(h.text);
      position = position || (!words.empty() && words.back() == "position");
      const std::size_t n = words.size();
      current = current || (n > 1 && words[n - 2] == "q" && words[n - 1].starts_with("curr"));
    }
    return position && current;
  }

  /// Velocity, effort, command and temperature, where one column has each.
  void take_others(const std::string& name, std::size_t j) {
    struct Other {
      ColumnRole role;
      const char* signal;
    };
    for (const Other& o : {Other{ColumnRole::velocity, ".velocity"},
                           {ColumnRole::effort, ".effort"},
                           {ColumnRole::command, ".command"},
                           {ColumnRole::temperature, ".temperature"}}) {
      const GuessedColumn* only = nullptr;
      std::size_t found = 0;
      for (const GuessedColumn& c : columns_)
        if (c.joint == j && c.role == o.role && !used_.contains(c.index) && found++ == 0) only = &c;
      if (found != 1 || !fits(*only, o.role, j)) continue;
      std::string unit = only->unit;
      if (o.role == ColumnRole::command) unit = position_unit(*only, j);
      if (o.role == ColumnRole::velocity && unit.empty() && is_moteus()) unit = "rev/s";
      if (unit == "count") continue;
      add_source(name + o.signal, *only, unit);
    }
  }

  /// Whether the unit of a column is one that its signal may have. A velocity without a unit may be in
  /// anything.
  bool fits(const GuessedColumn& c, ColumnRole role, std::size_t j) const {
    const bool prismatic = joint(j).prismatic();
    if (role == ColumnRole::velocity) {
      const Dimension wanted = prismatic ? dimension::speed : dimension::angular_speed;
      return has_dimension(c.unit, wanted) || (c.unit.empty() && (is_moteus() || in_si()));
    }
    if (role == ColumnRole::command)
      return std::ranges::none_of(c.words, [](const std::string& w) {
        return has_word(" velocity vel speed qd dq qdd ddq current torque tau effort moment acceleration ",
                        w);
      });
    if (role == ColumnRole::temperature)
      return c.unit.empty() || has_dimension(c.unit, dimension::temperature);
    return c.unit.empty() || c.unit == "A" || c.unit == "mA" || c.unit == "%" ||
           has_dimension(c.unit, prismatic ? Dimension{.newton = 1} : dimension::torque);
  }

  static bool has_dimension(const std::string& unit, const Dimension& d) {
    std::string why;
    const auto read = parse_unit(unit, why);
    return read && read->dimension == d;
  }

  /// Names of ROS, UR and libfranka: their values are in SI units (REP 103, and their manuals).
  bool in_si() const {
    return std::ranges::any_of(columns_, [](const GuessedColumn& c) {
      return c.name.starts_with("/") || c.name.starts_with("actual_q") || c.name.starts_with("tau_J");
    });
  }

  /// The tip: x, y, z of one tracker. A pose that a controller computes from its encoders, such as UR's
  /// actual_TCP_pose or libfranka's O_T_EE, is no reference.
  void take_tip() {
    std::map<std::string, std::array<const GuessedColumn*, 3>> triples;
    for (const GuessedColumn& c : columns_) {
      if (used_.contains(c.index) || c.joint || c.words.empty()) continue;
      const bool tracked = std::ranges::any_of(c.words, is_of_sensor);
      const bool moving = std::ranges::any_of(c.words, [](const std::string& w) {
        return has_word(" orientation rotation quat velocity speed force torque twist target ", w);
      });
      const std::size_t axis = std::string_view("xyz").find(c.words.back());
      if (!tracked || moving || axis > 2) continue;
      std::string family;
      for (std::size_t i = 0; i + 1 < c.words.size(); ++i) family += c.words[i] + ' ';
      triples[family][axis] = &c;
    }
    for (const auto& [family, triple] : triples) {
      if (!triple[0] || !triple[1] || !triple[2]) continue;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const GuessedColumn& c = *triple[axis];
        const bool length = c.unit.empty() || has_dimension(c.unit, dimension::length);
        const bool far = std::max({triple[0]->largest(), triple[1]->largest(), triple[2]->largest()}) > 10;
        if (length)
          add_source(std::string("tip.") + "xyz"[axis], c, c.unit.empty() ? (far ? "mm" : "m") : c.unit);
      }
      return;
    }
  }

  static constexpr double follows = 0.9999;  // the correlation with a backlash of 1 % of the motion

  const LogTable& table_;
  const Spec& spec_;
  std::vector<GuessedColumn> columns_;
  std::set<std::string> taken_;
  std::set<std::size_t> used_;
  std::vector<LogSource> mapping_;
  std::vector<std::string> left_out_;
};

}  // namespace

std::string likely_time(const LogTable& table, const Spec& spec) {
  return MappingGuess(table, spec).likely_time();
}

MappingProposal proposed_mapping(const LogTable& table, const Spec& spec) {
  MappingGuess guess(table, spec);
  MappingProposal proposal{{spec.log.missing, guess.mapping()}, guess.left_out()};
  LogReading& reading = proposal.reading;
  if (reading.missing != MissingValues::error) return proposal;
  // Rows with a gap are left out, unless every row has one.
  std::vector<bool> gaps;
  for (std::size_t i = 0; i < table.header().size(); ++i) {
    const bool mapped = std::ranges::any_of(
        reading.columns, [&](const LogSource& s) { return s.column == table.header()[i].text; });
    if (!mapped) continue;
    const std::vector<std::string> texts = table.first_texts(i);
    gaps.resize(std::max(gaps.size(), texts.size()), false);
    for (std::size_t k = 0; k < texts.size(); ++k) gaps[k] = gaps[k] || is_missing(texts[k]);
  }
  const auto holes = std::ranges::count(gaps, true);
  if (holes > 0) reading.missing = holes < std::ssize(gaps) ? MissingValues::drop : MissingValues::hold;
  return proposal;
}

std::string mapping_text(const MappingProposal& proposal) {
  const LogReading& reading = proposal.reading;
  const auto value = [](const LogSource& s) {
    const std::string column = flow_scalar(s.column, false);
    return s.unit.empty() ? column : "{column: " + column + ", unit: " + s.unit + '}';
  };
  std::string section = "log:\n", columns, options;
  for (const LogSource& s : reading.columns) {
    if (s.signal == "time")
      section += "  time: " + value(s) + '\n';
    else
      columns += "    " + s.signal + ": " + value(s) + '\n';
    options += (options.empty() ? "  --column " : " \\\n  --column ") +
               shell_word(s.signal + '=' + s.column + (s.unit.empty() ? "" : " [" + s.unit + ']'));
  }
  if (!columns.empty()) section += "  columns:\n" + columns;
  if (reading.missing != MissingValues::error) {
    const std::string missing = reading.missing == MissingValues::drop ? "drop" : "hold";
    section += "  missing: " + missing + '\n';
    options += " \\\n  --set log.missing=" + missing;
  }
  for (const std::string& column : proposal.left_out) section += "  # not mapped: " + column + '\n';
  section.pop_back();
  return "for one run:\n" + options + "\nin the spec:\n" + section;
}

}  // namespace qerr
