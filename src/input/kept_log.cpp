#include <cmath>

#include "qerr/input/read_log.hpp"

namespace qerr {

namespace {

/// Stretches of consecutive rows, all of one length; when they exceed the memory limit, every second one is
/// dropped.
class Stretches {
 public:
  explicit Stretches(std::uint64_t most_values) : most_values_(most_values) {}

  void add(Eigen::ArrayXXd rows, std::vector<std::uint64_t> file_rows) {
    if (number_++ % every_ != 0) return;
    kept_.push_back({(number_ - 1) * stretch_rows, std::move(rows), std::move(file_rows)});
    const auto columns = static_cast<std::uint64_t>(kept_.front().rows.cols());
    if (kept_.size() < 4 || kept_.size() * columns * stretch_rows <= most_values_) return;
    every_ *= 2;
    std::size_t count = 0;
    for (std::size_t i = 0; i < kept_.size(); i += 2) {
      if (i != count) std::swap(kept_[count], kept_[i]);
      ++count;
    }
    kept_.resize(count);
  }

  void move_to(Log& log) {
    Eigen::Index rows = 0, next = 0;
    for (const Stretch& s : kept_) rows += s.rows.rows();
    log.values.resize(rows, static_cast<Eigen::Index>(log.columns.size()));
    const bool gaps = !kept_.empty() && !kept_.back().file_rows.empty();
    for (Stretch& s : kept_) {
      for (Eigen::Index k = 0; gaps && k < s.rows.rows(); ++k)
        log.file_rows.push_back(s.file_rows.empty() ? s.first + static_cast<std::uint64_t>(k)
                                                    : s.file_rows[static_cast<std::size_t>(k)]);
      log.values.middleRows(next, s.rows.rows()) = s.rows;
      next += s.rows.rows();
      s.rows.resize(0, 0);
      if (every_ > 1) log.stretches.push_back(s.first);
    }
    if (every_ == 1) return;
    log.stretch_rows = static_cast<Eigen::Index>(stretch_rows);
    log.warnings.push_back(std::to_string(log.rows) + " rows: " + std::to_string(rows) +
                           " of them are used, in " + std::to_string(kept_.size()) +
                           " stretches spread evenly over the log");
  }

  static constexpr std::uint64_t stretch_rows = 16384;

 private:
  struct Stretch {
    std::uint64_t first = 0;
    Eigen::ArrayXXd rows;
    std::vector<std::uint64_t> file_rows;  // empty: from `first` on
  };
  std::uint64_t most_values_, number_ = 0, every_ = 1;
  std::vector<Stretch> kept_;
};

/// Makes columns of counts that are not whole positions of their joints.
void convert_fractions(Log& log, const Spec& spec) {
  const Transmission& t = spec.model.transmission;
  for (std::size_t c = 0; c < log.columns.size(); ++c) {
    LogColumn& column = log.columns[c];
    if (column.denominator == 1) continue;
    const auto i = static_cast<Eigen::Index>(column.index);
    const bool prismatic = spec.model.chain.independent[column.index].prismatic();
    const double count = t.coupling(i, i) * t.encoders[column.index].resolution;
    log.values.col(static_cast<Eigen::Index>(c)) *= count;
    const std::string n = std::to_string(column.denominator);
    log.warnings.push_back(log.file + ": " + column.header + ": not whole, but multiples of 1/" + n +
                           " count; read as '.measured'. If the encoder is interpolated, its resolution is " +
                           n + " times as fine, and so are its counts");
    column.signal = LogSignal::measured;
    column.unit = prismatic ? "m" : "rad";
    column.scale = {std::abs(count), 1, prismatic ? dimension::length : dimension::angle};
  }
}

}  // namespace

Log read_log(const LogFiles& files, const Spec& spec, std::uint64_t most_values,
             std::function<void(std::uint64_t, std::uint64_t)> progress) {
  LogReader reader(
      files, spec,
      {.block_rows = static_cast<Eigen::Index>(Stretches::stretch_rows), .progress = std::move(progress)});
  Stretches stretches(most_values);
  for (Eigen::ArrayXXd rows; reader.next(rows);) stretches.add(std::move(rows), reader.file_rows());
  Log log = reader.log();
  stretches.move_to(log);
  convert_fractions(log, spec);
  return log;
}

}  // namespace qerr
