#include "qerr/input/read_log.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <numeric>
#include <set>

#include "core/statistics.hpp"
#include "core/text.hpp"
#include "input/log_table.hpp"
#include "qerr/core/parameter.hpp"
#include "qerr/encoder/encoder.hpp"
#include "simulate/unwrap.hpp"

namespace qerr {

/// The grid of counts that are not all whole: the multiples of 1/denominator, as of an interpolated encoder
/// whose reading is written in counts before interpolation.
class CountGrid {
 public:
  /// @returns false if the values so far have more fractional parts than any grid
  bool add(double value);

  /// The least denominator, up to 1024, that serves all values; 0 if there is none.
  /// @param decimals  to which the values are rounded
  int denominator(int decimals) const;

 private:
  std::set<std::int64_t> parts_;  // distinct fractional parts, in units of 2^-30
  double largest_ = 0;
};

namespace {

constexpr int finest_grid = 1024;  // an interpolation by more is given as periods and interpolation_bits
constexpr double part_unit = 0x1p-30;

}  // namespace

bool CountGrid::add(double value) {
  largest_ = std::max(largest_, std::abs(value));
  parts_.insert(std::llround(std::remainder(value, 1.0) / part_unit));
  return parts_.size() <= 4 * finest_grid;  // either sign, and neighbours by the rounding of a double
}

int CountGrid::denominator(int decimals) const {
  const double rounding = 0.5 * std::pow(10.0, -decimals) + largest_ * 0x1p-52 + part_unit;
  int common = 1;
  for (const std::int64_t part : parts_) {
    const double fraction = static_cast<double>(part) * part_unit;
    const auto is_multiple = [&](int n) {
      return std::abs(std::remainder(fraction * n, 1.0)) <= rounding * n;
    };
    if (is_multiple(common)) continue;
    int own = 2;
    while (own <= finest_grid && !is_multiple(own)) ++own;
    common = std::lcm(own, common);
    if (common > finest_grid) return 0;
  }
  return common;
}

namespace {

constexpr double most_counts = 0x1p53;  // beyond it a double cannot represent every integer

/// Interval after which a column of absolute positions starts again; 0 for a column that does not.
double wrap_interval(const LogColumn& column, const Spec& spec) {
  switch (column.signal) {
    case LogSignal::counts: {
      const EncoderFigures& encoder = spec.encoder_figures[column.index];
      const AbsoluteRange range = encoder_kind(encoder.kind).absolute_within;
      const bool one_period =
          range == AbsoluteRange::signal_period &&
          spec.model.transmission.encoders[column.index].counts_per_period == encoder.counts_per_rev;
      return range == AbsoluteRange::revolution || one_period ? encoder.counts_per_rev : 0;
    }
    case LogSignal::measured:
    case LogSignal::reference:
    case LogSignal::command:
      return spec.model.chain.independent[column.index].prismatic() ? 0 : 2 * std::numbers::pi;
    default:
      return 0;
  }
}

Joining joining_of(LogSignal signal) {
  switch (signal) {
    case LogSignal::reference:
    case LogSignal::tip:
      return Joining::interpolated;
    case LogSignal::effort:
    case LogSignal::temperature:
    case LogSignal::command:
      return Joining::extended;
    default:
      return Joining::held;
  }
}

/// Whether an encoder alone measures the joint of its index, and no other joint.
bool is_uncoupled(const Transmission& t, std::size_t encoder) {
  return t.coupling(encoder, encoder) != 0 && (t.coupling.row(encoder).array() != 0).count() == 1 &&
         (t.coupling.col(encoder).array() != 0).count() == 1;
}

void note(Wraps& wraps, std::uint64_t row, double time) {
  if (wraps.count++ > 0) return;
  wraps.first_row = row;
  wraps.first_time = time;
}

}  // namespace

/// The rows of a log and the state from one row to the next.
class LogReader::Rows {
 public:
  Rows(const LogFiles& files, const Spec& spec, const LogOptions& options)
      : table_(files, spec.log, {options.block_bytes, options.longest_row}),
        transmission_(spec.model.transmission),
        most_(std::max<Eigen::Index>(options.block_rows, 1)),
        progress_(options.progress) {
    log.file = table_.file();
    LogColumns found = find_log_columns(table_, spec, log.warnings);
    log.columns = std::move(found.columns);
    log.misspelt = std::move(found.misspelt);
    std::vector<Joining> joining;
    for (const LogColumn& c : log.columns) joining.push_back(joining_of(c.signal));
    table_.choose(found.places, joining);
    time_ = log.find(LogSignal::time);
    for (std::size_t i = 0; i < log.columns.size(); ++i) {
      const LogColumn& column = log.columns[i];
      const auto index = static_cast<Eigen::Index>(i);
      if (column.signal == LogSignal::counts)
        counts_.push_back({index, direction(transmission_.encoders[column.index]), {}, {}});
      const bool scaled = column.scale.factor != 1 || column.scale.divisor != 1;
      if (scaled && column.signal != LogSignal::time) scaled_.push_back(index);
      if (column.signal != LogSignal::counts && column.signal != LogSignal::time)
        bounds_.push_back(bound_of(column, index));
      const double turn = wrap_interval(column, spec);
      if (turn > 0 && time_)
        unwraps_.push_back(
            {index, column.signal == LogSignal::counts ? Unwrap::of_counter(turn) : Unwrap::of_angle(turn)});
      add_alignment(column, index, turn);
    }
  }

  bool next(Eigen::ArrayXXd& rows) {
    // A line of the cache more than a block: columns a power of two apart would displace each other.
    constexpr Eigen::Index line = 8;
    block_.resize(most_ + line, std::ssize(log.columns));
    Eigen::Index count = 0;
    file_rows.clear();
    while (count < most_ && table_.next(block_.data() + count, block_.rows())) {
      file_rows.push_back(table_.row());
      check(block_, count++);
    }
    // Ascending: if the last row has its own number, all have.
    if (count > 0 && file_rows.back() == log.rows + static_cast<std::uint64_t>(count) - 1) file_rows.clear();
    if (count == 0 && log.rows == 0)
      throw Error(table_.last_line(), "", "the log has no rows", "only a header", "");
    if (count == 0) {
      find_grids();
      for (std::size_t i = 0; i < log.columns.size(); ++i)
        if (const auto& between = table_.between(i)) {
          for (double& x : between->value) x = log.columns[i].scale.in_si(x);
          log.columns[i].samples = between;
        }
      for (std::string& warning : table_.warnings()) log.warnings.push_back(std::move(warning));
      return false;
    }
    rows = block_.topRows(count);
    remove_turns(rows);
    log.rows += static_cast<std::uint64_t>(count);
    if (time_) log.last_time = log.time_origin + rows(count - 1, *time_);
    for (std::size_t i = 0; i < log.columns.size(); ++i) {
      log.columns[i].text = table_.written(i);
      log.columns[i].held = table_.held(i);
    }
    if (progress_ && table_.size() > 0) progress_(table_.position(), table_.size());
    return true;
  }

  Log log;
  std::vector<std::uint64_t> file_rows;  // of the last block

 private:
  /// A column whose position may differ by whole turns from another one of its joint.
  struct TurnAlignment {
    Eigen::Index column;
    double turn;         // in the column's unit
    double joint_turn;   // the same of the joint [rad]
    bool of_measured;    // from the reference; else it is a reference or command, and the other is measured
    bool stays = false;  // only the other is moved
    std::int64_t turns = 0;                   // added to the column
    double lowest = 1e300, highest = -1e300;  // of the column as it is read
    std::optional<double> cut = {};           // below which a table's positions belong to the next turn
  };
  /// Largest magnitude of a column's values [SI units].
  struct Bound {
    Eigen::Index column;
    double most;
    bool of_counts;  ///< by the encoder's resolution, else by physics
  };
  struct ColumnUnwrap {
    Eigen::Index column;
    Unwrap unwrap;
  };

  /// Measured positions first: references are moved to what they are then.
  void add_alignment(const LogColumn& column, Eigen::Index index, double turn) {
    if (turn == 0) return;
    const std::size_t i = column.index;
    if (column.signal == LogSignal::reference || column.signal == LogSignal::command) {
      if (is_measured(log, transmission_, i)) alignments_.push_back({index, turn, turn, false});
      return;
    }
    const bool counts = column.signal == LogSignal::counts;
    if (!log.find(LogSignal::reference, i) || !is_uncoupled(transmission_, i) ||
        (!counts && log.find(LogSignal::counts, i)))
      return;
    const auto row = static_cast<Eigen::Index>(i);
    const double count = transmission_.coupling(row, row) * transmission_.encoders[i].resolution;
    alignments_.insert(alignments_.begin(), {index, turn, counts ? turn * count : turn, true});
  }

  Bound bound_of(const LogColumn& column, Eigen::Index index) const {
    const double physical = physical_range(column.scale.dimension).largest;
    if (column.signal != LogSignal::measured && column.signal != LogSignal::reference &&
        column.signal != LogSignal::command)
      return {index, physical, false};
    const auto joint = static_cast<Eigen::Index>(column.index);
    const double step = transmission_.coupling.row(joint).cwiseAbs().dot(resolutions(transmission_));
    return {index, std::min(physical, most_counts * step), most_counts * step < physical};
  }
  std::string unit_of(Eigen::Index column) const {
    const std::string unit = unit_name(log.columns[column].scale.dimension);
    return unit.empty() ? "" : ' ' + unit;
  }

  /// Converts units, checks ranges, counts and time of a row, and gives counts the direction of the joint.
  void check(Eigen::ArrayXXd& rows, Eigen::Index row) {
    for (const Eigen::Index c : scaled_) {
      double& value = rows(row, c);
      value = log.columns[c].scale.in_si(value);
    }
    for (const auto& [c, most, counts] : bounds_)
      if (std::abs(rows(row, c)) > most)  // false for a cell without a value
        refuse(c,
               counts ? "a position beyond 2^53 counts of its encoder cannot be compared with it"
                      : "the number is too large: no machine reaches " + significant(most, 2) + unit_of(c),
               "correct the cell, or the unit in the header");
    for (auto& [c, direction, grid, off_grid] : counts_) {
      double& value = rows(row, c);
      if (!(std::abs(value) <= most_counts))
        refuse(c, "counts beyond 2^53 are not distinguishable", "subtract a constant from the column");
      if (static_cast<double>(static_cast<std::int64_t>(value)) != value) {
        if (!off_grid)
          off_grid = fault(c, "counts must be integers",
                           "a position in rad or m belongs in the column '.measured [rad]'");
        const std::size_t encoder = log.columns[c].index;
        if (!is_uncoupled(transmission_, encoder) || !grid.add(value)) throw Error(*off_grid);
      }
      value = 0.0 + direction * value;  // no -0
    }
    if (!time_) return;
    if (row > 0 || log.rows > 0) return;
    log.time_origin = table_.time_origin();
    log.first_time = log.time_origin + rows(row, *time_);
  }

  Error fault(Eigen::Index column, const std::string& rule, const std::string& remedy) const {
    const auto i = static_cast<std::size_t>(column);
    return Error(table_.place(i), log.columns[i].header, rule, "'" + table_.text(i) + "'", remedy);
  }
  [[noreturn]] void refuse(Eigen::Index column, const std::string& rule, const std::string& remedy) const {
    throw fault(column, rule, remedy);
  }

  void find_grids() {
    for (const auto& [c, direction, grid, off_grid] : counts_) {
      if (!off_grid) continue;
      LogColumn& column = log.columns[c];
      column.denominator = grid.denominator(column.text.most_decimals);
      if (column.denominator <= 1) throw Error(*off_grid);
    }
  }

  /// Of a row of the present block, from 0.
  std::uint64_t row_in_file(Eigen::Index i) const {
    return file_rows.empty() ? log.rows + static_cast<std::uint64_t>(i) : file_rows[i];
  }

  /// Whether a column has poses and no samples of a motion: what a row differs by from the line through those
  /// beside it is a part of a turn in the middle of all rows.
  static bool has_poses(const Eigen::ArrayXd& x, double turn) {
    constexpr double part = 1.0 / 12;  // no joint changes its speed by 30 degrees a row for half of a record
    const Eigen::Index n = x.size() - 2;
    if (n < 8) return false;
    const Eigen::ArrayXd bend = (x.tail(n) - 2 * x.segment(1, n) + x.head(n)).abs();
    return median({bend.begin(), bend.end()}) > part * turn;
  }

  /// Leaps of a joint from one row to the next, to which two sensors agree: the motion between is not in the
  /// log. Others may be nearly a turn, and are no wraps.
  /// @param turn, other_turn  after which the sensors may start again
  static Eigen::Index leaps(const Eigen::ArrayXd& x, double turn, const Eigen::ArrayXd& other,
                            double other_turn) {
    constexpr double part = 1.0 / 12;  // as of has_poses
    Eigen::Index count = 0;
    const auto change = [&](Eigen::Index k, Eigen::Index beside) {  // of the step to a row from another one
      return std::abs(std::remainder(x[k] - x[k - 1] - (x[beside] - x[beside - 1]), turn)) / turn;
    };
    for (Eigen::Index k = 2; k + 1 < x.size(); ++k)
      count += std::min(change(k, k - 1), change(k, k + 1)) > part &&
               std::abs(std::remainder(x[k] - x[k - 1] - (other[k] - other[k - 1]), other_turn)) <
                   0.5 * part * std::abs(other_turn);
    return count;
  }

  static bool is_within(const Eigen::ArrayXd& x, double turn) {
    return x.maxCoeff() - x.minCoeff() <= 1.01 * std::abs(turn);  // as Unwrap::of_angle
  }

  void find_poses(const Eigen::ArrayXXd& rows) {
    for (const auto& [column, unwrap] : unwraps_)
      poses_ = poses_ || has_poses(rows.col(column), unwrap.turn());
    leaping_.assign(transmission_.encoders.size(), false);
    for (const TurnAlignment& a : alignments_) {
      const LogColumn& column = log.columns[static_cast<std::size_t>(a.column)];
      if (!time_ || column.signal != LogSignal::reference) continue;
      const auto measured = std::ranges::find_if(alignments_, [&](const TurnAlignment& other) {
        return other.of_measured && log.columns[static_cast<std::size_t>(other.column)].index == column.index;
      });
      const bool both = measured != alignments_.end();
      const Eigen::Index count =
          leaps(rows.col(a.column), a.turn, *measured_joint(log, rows, transmission_, column.index),
                both ? measured->joint_turn : a.turn);
      // Where the measured position does not wrap, it shows all turns of the reference. Where it does, they
      // come from the motion, unless the joint dwells between leaps; a few of these are gaps in a record.
      constexpr Eigen::Index fewest = 3, longest_dwell = 200;
      leaping_[column.index] = both ? count >= std::max(fewest, rows.rows() / longest_dwell) : count > 0;
    }
  }

  bool is_in_time(std::size_t joint) const { return time_ && !poses_ && !leaping_[joint]; }

  void remove_turns(Eigen::ArrayXXd& rows) {
    if (log.rows == 0) find_poses(rows);
    for (TurnAlignment& a : alignments_) {
      a.lowest = std::min(a.lowest, rows.col(a.column).minCoeff());
      a.highest = std::max(a.highest, rows.col(a.column).maxCoeff());
    }
    for (auto& [column, unwrap] : unwraps_) {
      if (!is_in_time(log.columns[column].index)) continue;
      Wraps& wraps = log.columns[column].wraps;
      for (Eigen::Index i = 0; i < rows.rows(); ++i) {
        std::int64_t before = unwrap.turns();
        rows(i, column) = unwrap(rows(i, column));
        if (const std::int64_t withdrawn = unwrap.withdrawn(); withdrawn != 0) {
          before -= withdrawn;
          --wraps.count;
          if (i > 0) rows(i - 1, column) -= static_cast<double>(withdrawn) * unwrap.turn();
        }
        if (unwrap.turns() != before) note(wraps, row_in_file(i), log.time_origin + rows(i, *time_));
      }
      wraps.contradicted = unwrap.contradicted();
    }
    for (TurnAlignment& a : alignments_) align(a, rows);
  }

  /// Whether the column's values are within one turn, and may be those of a sensor that has no more.
  static bool may_wrap(const TurnAlignment& a) {
    return a.highest - a.lowest <= 1.01 * std::abs(a.turn) &&
           (!a.of_measured || std::max(-a.lowest, a.highest) <= std::abs(a.turn));
  }

  /// Whether a measured position is not moved, but the reference: it counts the turns, or the reference does
  /// not either.
  bool keeps_turns(const TurnAlignment& a, const Eigen::ArrayXXd& rows) const {
    constexpr double revolution = 2 * std::numbers::pi;
    if (!may_wrap(a)) return true;
    if (std::abs(a.joint_turn) < 0.99 * revolution) return false;
    const LogColumn& measured = log.columns[static_cast<std::size_t>(a.column)];
    const Eigen::Index reference = *log.find(LogSignal::reference, measured.index);
    if (!is_in_time(measured.index)) return is_within(rows.col(reference), revolution);
    return measured.wraps.count == 0 || log.columns[static_cast<std::size_t>(reference)].wraps.count > 0;
  }

  /// Removes whole turns between two positions of a joint: of a motion those at the start, of poses those of
  /// every row.
  void align(TurnAlignment& a, Eigen::ArrayXXd& rows) {
    LogColumn& column = log.columns[static_cast<std::size_t>(a.column)];
    const bool first = log.rows == 0, in_time = is_in_time(column.index);
    auto values = rows.col(a.column);
    if (first) a.stays = a.of_measured && keeps_turns(a, rows);
    if (a.stays) {
      if (first && !in_time && may_wrap(a)) a.cut = largest_gap(values, a.turn);
      if (a.cut) add_turns(a, (values < *a.cut).cast<double>(), rows);
      return;
    }
    if (first || !in_time) {
      const Eigen::ArrayXd measured = *measured_joint(log, rows, transmission_, column.index);
      const Eigen::ArrayXd other =
          a.of_measured ? Eigen::ArrayXd(rows.col(*log.find(LogSignal::reference, column.index))) : measured;
      const Eigen::ArrayXd own = a.of_measured ? measured : Eigen::ArrayXd(values);
      if (first) column.wraps.start = a.turns = turns_at_start(other - own, a.joint_turn, in_time);
      if (!in_time && may_wrap(a) && add_turns_of_rows(a, own, other, rows)) return;
    }
    values += static_cast<double>(a.turns) * a.turn;
  }

  /// Turns between two positions if they differ by whole ones, within a quarter turn.
  static std::int64_t turns_at_start(const Eigen::ArrayXd& apart, double turn, bool in_time) {
    // The median of some rows: the first one may be far off.
    const Eigen::Index some = in_time ? std::min<Eigen::Index>(7, apart.size()) : apart.size();
    const double turns = median({apart.begin(), apart.begin() + some}) / turn;
    const bool whole = std::abs(turns - std::round(turns)) < 0.25 && std::abs(turns) < 1e9;
    return whole ? std::llround(turns) : 0;
  }

  /// Adds to every row of a column the turns that bring it near the other position, if the line through one
  /// against the other then has half the scatter, as it has where wraps are removed.
  bool add_turns_of_rows(TurnAlignment& a, const Eigen::ArrayXd& own, const Eigen::ArrayXd& other,
                         Eigen::ArrayXXd& rows) {
    std::vector<Eigen::Index> order = ascending_rows(other);
    if (time_) std::iota(order.begin(), order.end(), Eigen::Index{0});
    const Eigen::ArrayXd turns = turns_by_difference(own - other, order, a.joint_turn);
    // No sensor errs by an eighth of a turn, half of what positions have that are unrelated.
    const double scatter = fit_line(other, own + turns * a.joint_turn).residual_rms;
    if (!(scatter < 0.5 * fit_line(other, own).residual_rms && 8 * scatter < std::abs(a.joint_turn)))
      return false;
    add_turns(a, turns, rows);
    return true;
  }

  /// Where positions modulo a turn are not, as beyond the limits of a joint: the middle of the gap, if it is
  /// too large for positions at random, and larger than where the turn starts again.
  static std::optional<double> largest_gap(const Eigen::ArrayXd& x, double turn) {
    const std::set<double> positions(x.begin(), x.end());
    const auto n = static_cast<double>(positions.size());
    double widest = 0, middle = 0, last = *positions.begin();
    for (const double position : positions) {
      if (position - last > widest) widest = position - last, middle = 0.5 * (position + last);
      last = position;
    }
    constexpr double probability = 0.01;  // that one of n gaps is as wide
    const bool by_chance = n * std::pow(1 - std::min(1.0, widest / turn), n - 1) > probability;
    const bool is_largest = widest > 2 * (turn - (last - *positions.begin()));
    return by_chance || !is_largest ? std::nullopt : std::optional(middle);
  }

  /// Adds turns to the rows of a column, and notes where they differ from those of most rows or, in time,
  /// from those before.
  void add_turns(TurnAlignment& a, const Eigen::ArrayXd& turns, Eigen::ArrayXXd& rows) {
    Wraps& wraps = log.columns[static_cast<std::size_t>(a.column)].wraps;
    if (log.rows == 0) wraps.start = std::llround(time_ ? turns[0] : median({turns.begin(), turns.end()}));
    double before = static_cast<double>(log.rows == 0 || !time_ ? wraps.start : a.turns);
    for (Eigen::Index i = 0; i < rows.rows(); ++i) {
      if (turns[i] != before) note(wraps, row_in_file(i), time_ ? log.time_origin + rows(i, *time_) : 0);
      if (time_) before = turns[i];
    }
    a.turns = time_ ? std::llround(before) : wraps.start;
    rows.col(a.column) += turns * a.turn;
  }

  LogTable table_;
  Eigen::ArrayXXd block_;  ///< rows as they are read
  std::vector<Bound> bounds_;
  Transmission transmission_;
  Eigen::Index most_;
  std::function<void(std::uint64_t, std::uint64_t)> progress_;
  std::optional<Eigen::Index> time_;
  bool poses_ = false;         ///< the rows are no samples of a motion
  std::vector<bool> leaping_;  ///< joints that leap from one position to the next
  /// Column of counts, and the direction of the counter.
  struct Counts {
    Eigen::Index column;
    double direction;
    CountGrid grid;
    std::optional<Error> off_grid;  // place of the first value that is not whole
  };
  std::vector<Counts> counts_;
  std::vector<Eigen::Index> scaled_;
  std::vector<ColumnUnwrap> unwraps_;
  std::vector<TurnAlignment> alignments_;
};

LogReader::LogReader(const LogFiles& files, const Spec& spec, const LogOptions& options)
    : rows_(std::make_unique<Rows>(files, spec, options)) {}
LogReader::~LogReader() = default;
LogReader::LogReader(LogReader&&) noexcept = default;
LogReader& LogReader::operator=(LogReader&&) noexcept = default;

const Log& LogReader::log() const { return rows_->log; }

bool LogReader::next(Eigen::ArrayXXd& rows) { return rows_->next(rows); }

const std::vector<std::uint64_t>& LogReader::file_rows() const { return rows_->file_rows; }

}  // namespace qerr
