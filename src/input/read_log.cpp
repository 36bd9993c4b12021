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
      const bool has_turns = column.signal == LogSignal::reference || column.signal == LogSignal::command;
      if (turn > 0 && has_turns && is_measured(log, transmission_, column.index))
        alignments_.push_back({index, turn});
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
  /// A reference or command that may differ from the measured position by whole turns.
  struct TurnAlignment {
    Eigen::Index column;
    double turn;
    std::int64_t turns = 0;  // added to the column
    double last = 0;         // last difference from the measured position
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

  void remove_turns(Eigen::ArrayXXd& rows) {
    if (log.rows == 0)
      for (const auto& [column, unwrap] : unwraps_)
        poses_ = poses_ || has_poses(rows.col(column), unwrap.turn());
    for (auto& [column, unwrap] : unwraps_) {
      if (poses_) break;
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

  /// Removes whole turns between a reference and the measured position: the initial ones, and in a table of
  /// poses those of every row.
  void align(TurnAlignment& f, Eigen::ArrayXXd& rows) {
    LogColumn& column = log.columns[f.column];
    const bool first = log.rows == 0, in_time = time_ && !poses_;
    if (!first && in_time) {
      rows.col(f.column) += static_cast<double>(f.turns) * f.turn;
      return;
    }
    const Eigen::ArrayXd measured = *measured_joint(log, rows, transmission_, column.index);
    if (first) {
      // The median of some rows: the first one may be far off.
      const Eigen::ArrayXd apart =
          (measured - rows.col(f.column)).head(std::min<Eigen::Index>(7, rows.rows()));
      const double turns_apart = (in_time ? median({apart.begin(), apart.end()}) : apart[0]) / f.turn;
      if (std::abs(turns_apart - std::round(turns_apart)) < 0.25 && std::abs(turns_apart) < 1e9)
        column.wraps.start = f.turns = std::llround(turns_apart);
      f.last = -(turns_apart - static_cast<double>(f.turns)) * f.turn;
    }
    for (Eigen::Index i = 0; i < rows.rows(); ++i) {
      double& reference = rows(i, f.column);
      reference += static_cast<double>(f.turns) * f.turn;
      if (in_time) continue;
      const int turns = turns_after(reference - measured[i] - f.last, f.turn);
      reference += turns * f.turn;
      f.turns += turns;
      f.last = reference - measured[i];
      if (turns != 0) note(column.wraps, row_in_file(i), 0);
    }
  }

  LogTable table_;
  Eigen::ArrayXXd block_;  ///< rows as they are read
  std::vector<Bound> bounds_;
  Transmission transmission_;
  Eigen::Index most_;
  std::function<void(std::uint64_t, std::uint64_t)> progress_;
  std::optional<Eigen::Index> time_;
  bool poses_ = false;  ///< the rows are no samples of a motion
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
