#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "core/solve.hpp"
#include "core/text.hpp"
#include "diagnose/record/sanity/sanity_steps.hpp"
#include "simulate/sensing.hpp"

/// A tracker whose columns are no positions of the tip in any frame.
namespace qerr::sanity {

namespace {

constexpr Eigen::Index most_poses = 4000;

/// Part of an axis' variance that the model's tip explains in any frame, below which the axis does not follow
/// it (convention; half a correlation, as of a joint's reference).
constexpr double unrelated = 0.25;
/// Standard deviation of an axis that may rest, as a part of the tip's (convention).
constexpr double at_rest = 0.02;
/// The tip moves by more or less than the model by a wrong gear or decoding, but not by this factor.
constexpr double farther = 10;
/// Part of the variance that proportional columns share.
constexpr double in_proportion = 0.96;
constexpr double own = 0.95, crossed = 0.999;  ///< correlations of exchanged columns

/// Positions of the tip as the model has them and as recorded, in rows without single readings far off.
struct TrackedTip {
  std::vector<std::size_t> axes;
  std::vector<Eigen::Index> columns;  ///< of the log
  Eigen::MatrixXd model;              ///< rows x 3 [m]
  Eigen::MatrixXd recorded;           ///< rows x axes [m]
  bool moves = false;                 ///< some joint does

  auto of_model(std::size_t axis) const { return model.col(static_cast<Eigen::Index>(axis)).array(); }
  auto of_record(std::size_t i) const { return recorded.col(static_cast<Eigen::Index>(i)).array(); }
};

/// The joints of a row: references, else what the encoders say. Empty if a joint has neither.
std::optional<Eigen::MatrixXd> joints_of(const Sanity& s) {
  Eigen::MatrixXd joints(s.log.values.rows(), static_cast<Eigen::Index>(s.model.chain.independent.size()));
  for (Eigen::Index j = 0; j < joints.cols(); ++j) {
    const auto joint = static_cast<std::size_t>(j);
    if (const auto reference = s.log.find(LogSignal::reference, joint))
      joints.col(j) = s.log.values.col(*reference);
    else if (const auto measured = measured_joint(s.log, s.log.values, s.model.transmission, joint))
      joints.col(j) = *measured;
    else
      return std::nullopt;
  }
  return joints;
}

/// Rows in which no axis lies ten times the distance of the quartiles off the median.
std::vector<Eigen::Index> usual_rows(const Eigen::MatrixXd& recorded) {
  std::vector<char> left_out(static_cast<std::size_t>(recorded.rows()));
  for (Eigen::Index i = 0; i < recorded.cols(); ++i) {
    std::vector<double> sorted(recorded.col(i).begin(), recorded.col(i).end());
    std::sort(sorted.begin(), sorted.end());
    const double middle = sorted[sorted.size() / 2],
                 width = sorted[sorted.size() * 3 / 4] - sorted[sorted.size() / 4];
    for (Eigen::Index k = 0; width > 0 && k < recorded.rows(); ++k)
      if (std::abs(recorded(k, i) - middle) > 10 * width) left_out[static_cast<std::size_t>(k)] = 1;
  }
  std::vector<Eigen::Index> rows;
  for (std::size_t k = 0; k < left_out.size(); ++k)
    if (!left_out[k]) rows.push_back(static_cast<Eigen::Index>(k));
  return rows;
}

std::optional<TrackedTip> tracked_tip(const Sanity& s) {
  TrackedTip t;
  for (std::size_t axis = 0; axis < 3; ++axis)
    if (const auto column = s.log.find(LogSignal::tip, axis))
      t.axes.push_back(axis), t.columns.push_back(*column);
  const std::optional<Eigen::MatrixXd> joints = joints_of(s);
  if (t.columns.empty() || !joints) return std::nullopt;
  for (std::size_t i = 0; i < s.model.transmission.encoders.size(); ++i)
    if (const auto read = recorded_counts(s, i))
      t.moves = t.moves || peak_to_peak(read->counts) >= missed_motion;
  std::vector<Eigen::Index> rows;
  const Eigen::Index n = std::min(joints->rows(), most_poses);
  for (Eigen::Index k = 0; k < n; ++k) rows.push_back(k * joints->rows() / n);
  t.recorded = s.log.values.matrix()(rows, t.columns);
  std::vector<Eigen::Index> kept;
  for (const Eigen::Index k : usual_rows(t.recorded)) kept.push_back(rows[static_cast<std::size_t>(k)]);
  t.recorded = s.log.values.matrix()(kept, t.columns);
  t.model.resize(static_cast<Eigen::Index>(kept.size()), 3);
  const Chain chain = as_built(s.model.chain, s.present);
  for (std::size_t k = 0; k < kept.size(); ++k)
    t.model.row(static_cast<Eigen::Index>(k)) =
        qerr::tracked_tip(chain, joints->row(kept[k]).transpose()).translation();
  return t;
}

/// Part of the variance that an affine function of the model's tip explains, whatever the tracker's frame is;
/// without what three slopes explain of noise.
double explained(const TrackedTip& t, std::size_t i) {
  const Eigen::MatrixXd centred = t.model.rowwise() - t.model.colwise().mean();
  const Eigen::VectorXd y = t.of_record(i) - t.of_record(i).mean();
  const double scale = centred.norm();
  if (!(scale > 0) || !(y.squaredNorm() > 0)) return 0;
  const Eigen::VectorXd left = y - centred * (least_norm_solution(centred / scale, y, 1e-6) / scale);
  const auto rows = static_cast<double>(y.size());
  return 1 - left.squaredNorm() / y.squaredNorm() * (rows - 1) / (rows - 4);
}

/// Largest standard deviation of the model's tip along any direction.
double largest_deviation(const TrackedTip& t) {
  const Eigen::MatrixXd centred = t.model.rowwise() - t.model.colwise().mean();
  const Eigen::MatrixXd covariance = centred.transpose() * centred / static_cast<double>(t.model.rows());
  return std::sqrt(std::max(0.0, symmetric_eigenvalues(covariance).maxCoeff()));
}

const std::string& header_of(const Sanity& s, const TrackedTip& t, std::size_t i) {
  return s.log.columns[static_cast<std::size_t>(t.columns[i])].header;
}

/// Two axes of which each follows the other one of the model.
bool exchange(Sanity& s, TrackedTip& t) {
  for (std::size_t i = 0; i < t.axes.size(); ++i)
    for (std::size_t j = i + 1; j < t.axes.size(); ++j) {
      const auto related = [&](std::size_t axis, std::size_t column) {
        return correlation(t.of_model(t.axes[axis]), t.of_record(column));
      };
      if (related(i, i) > own || related(j, j) > own || related(i, j) < crossed || related(j, i) < crossed)
        continue;
      s.data.push_back({header_of(s, t, i) + " and " + header_of(s, t, j) +
                            " look exchanged: each follows the other one of the model",
                        "tip",
                        1,
                        {},
                        "exchange their headers",
                        DataKind::contradictory});
      s.spoilt = s.data.back().what + ": " + s.data.back().remedy;
      s.log.values.col(t.columns[i]).swap(s.log.values.col(t.columns[j]));
      t.recorded.col(static_cast<Eigen::Index>(i)).swap(t.recorded.col(static_cast<Eigen::Index>(j)));
      return true;
    }
  return false;
}

/// Axes that run against the model's, one of three or all: no rotation of a frame turns a right-handed one
/// into these.
bool turn_sign(Sanity& s, TrackedTip& t) {
  std::vector<std::size_t> mirrored;
  for (std::size_t i = 0; i < t.axes.size(); ++i) {
    const double related = correlation(t.of_model(t.axes[i]), t.of_record(i));
    if (std::abs(related) < crossed) return false;
    if (related < 0) mirrored.push_back(i);
  }
  if (t.axes.size() < 3 || mirrored.size() % 2 == 0) return false;
  std::string headers;
  for (const std::size_t i : mirrored) headers += (headers.empty() ? "" : ", ") + header_of(s, t, i);
  s.data.push_back({headers + (mirrored.size() > 1 ? " look" : " looks") +
                        " mirrored: against the model's motion, which no frame's rotation is",
                    "tip",
                    1,
                    {},
                    "turn the sign of the column, or use a right-handed frame of the tracker",
                    DataKind::contradictory});
  s.spoilt = s.data.back().what + ": " + s.data.back().remedy;
  for (const std::size_t i : mirrored) {
    s.log.values.col(t.columns[i]) *= -1;
    t.recorded.col(static_cast<Eigen::Index>(i)) *= -1;
  }
  return true;
}

/// Columns in another unit than their headers say.
void convert_unit(Sanity& s, TrackedTip& t) {
  double recorded = 0, model = 0;
  for (std::size_t i = 0; i < t.axes.size(); ++i) {
    recorded += std::pow(standard_deviation(t.of_record(i)), 2);
    model += std::pow(standard_deviation(t.of_model(t.axes[i])), 2);
    if (standard_deviation(t.of_record(i)) > 0 && explained(t, i) < in_proportion) return;
  }
  if (!(model > 0) || !(recorded > 0)) return;
  const LogColumn& column = s.log.columns[static_cast<std::size_t>(t.columns[0])];
  const std::optional<OtherUnit> unit = other_unit(column, std::sqrt(recorded / model), true);
  if (!unit) return;
  const std::string what = t.axes.size() > 1 ? "the columns of the tip look" : column.header + " looks";
  s.data.push_back({what + " like " + std::string(unit->name) + ": their values are " +
                        significant(unit->factor, 4) + " times what the header says",
                    "tip",
                    1,
                    {},
                    "write [" + std::string(unit->name) + "] in the header, or convert the column",
                    DataKind::contradictory});
  s.spoilt = s.data.back().what + ": " + s.data.back().remedy;
  for (const Eigen::Index c : t.columns) s.log.values.col(c) /= unit->factor;
  t.recorded /= unit->factor;
}

/// What is wrong with the columns as positions of the tip; "" if nothing.
std::string contradiction(const Sanity& s, const TrackedTip& t) {
  const double largest = largest_deviation(t);
  for (std::size_t i = 0; i < t.axes.size(); ++i) {
    const double deviation = standard_deviation(t.of_record(i));
    const std::string varies = header_of(s, t, i) + " varies by " + readable(deviation, "m") +
                               " (standard deviation), the model's tip by " + readable(largest, "m") +
                               " in any direction at most";
    if (deviation > farther * largest) return varies;
    if (deviation > at_rest * largest && explained(t, i) < unrelated)
      return varies + ", and they are not correlated";
  }
  return "";
}

}  // namespace

void check_tracker(Sanity& s) {
  constexpr double rounding = 1e-9;  // [m]: joints that do not move the tip say nothing of the tracker
  std::optional<TrackedTip> t = tracked_tip(s);
  if (!t || !t->moves || t->model.rows() < fewest_rows_of_slope || largest_deviation(*t) < rounding) return;
  if (!exchange(s, *t) && !turn_sign(s, *t)) convert_unit(s, *t);
  const std::string what = contradiction(s, *t);
  if (what.empty()) return;
  double squares = 0;
  for (std::size_t i = 0; i < t->axes.size(); ++i)
    squares += std::pow(rms(t->of_record(i) - t->of_model(t->axes[i])), 2);
  s.unexplained.push_back({"tip", "the tracked tip does not follow the joints", {}, {}, std::sqrt(squares)});
  s.data.push_back(
      {what,
       "tip",
       1,
       {},
       "no verdict on the tip: look whether the columns are a tracker's, their units, and whether "
       "the joints are those of the same motion",
       DataKind::contradictory});
  std::sort(t->columns.rbegin(), t->columns.rend());
  for (const Eigen::Index column : t->columns) drop_column(s.log, column);
}

namespace {

constexpr Eigen::Index side = 5;  ///< rows

/// Distance of every row from the median of the rows around it [m].
Eigen::ArrayXd off_neighbours(const Eigen::MatrixXd& x) {
  Eigen::ArrayXd squares = Eigen::ArrayXd::Zero(x.rows());
  for (Eigen::Index i = 0; i < x.cols(); ++i)
    for (Eigen::Index k = 0; k < x.rows(); ++k) {
      const Eigen::Index first = std::max<Eigen::Index>(0, k - side), end = std::min(x.rows(), k + side + 1);
      const auto around = x.col(i).segment(first, end - first);
      squares[k] += std::pow(x(k, i) - median({around.begin(), around.end()}), 2);
    }
  return squares.sqrt();
}

}  // namespace

void check_tip_outliers(Sanity& s) {
  constexpr Eigen::Index most_rows = 1 << 16, longest = 3;  // beyond which they are no single positions
  constexpr double factor = 12, rounding = 2,
                   part = 1.0 / 30;  // of the median distance, of the log's step, of the rows
  const auto stamps = s.log.find(LogSignal::time);
  const Eigen::Index n = s.log.values.rows();
  std::vector<Eigen::Index> axes;
  double step = 0;
  for (std::size_t i = 0; i < 3; ++i)
    if (const auto axis = s.log.find(LogSignal::tip, i)) {
      const LogColumn& column = s.log.columns[static_cast<std::size_t>(*axis)];
      if (column.samples) return;
      axes.push_back(*axis);
      step = std::max(step, resolution_of(s.log, *axis));
    }
  if (!stamps || axes.empty() || n < fewest_rows_of_slope || n > most_rows) return;
  const std::optional<Eigen::MatrixXd> joints = joints_of(s);
  if (!joints) return;
  const Chain chain = as_built(s.model.chain, s.present);
  Eigen::MatrixXd apart = s.log.values.matrix()(Eigen::all, axes);
  for (Eigen::Index k = 0; k < n; ++k) {
    const Eigen::Vector3d tip = qerr::tracked_tip(chain, joints->row(k).transpose()).translation();
    for (std::size_t i = 0; i < axes.size(); ++i)
      apart(k, static_cast<Eigen::Index>(i)) -=
          tip[static_cast<Eigen::Index>(s.log.columns[static_cast<std::size_t>(axes[i])].index)];
  }
  const Eigen::ArrayXd distance = off_neighbours(apart);
  const double limit = std::max(factor * median({distance.begin(), distance.end()}), rounding * step);
  std::vector<Eigen::Index> far;
  Eigen::Index run = 0;
  for (Eigen::Index k = side; k < n - side; ++k) {  // at the ends all neighbours are on one side
    run = distance[k] > limit ? run + 1 : 0;
    if (run > longest) return;
    if (run > 0) far.push_back(k);
  }
  if (far.empty() || static_cast<double>(far.size()) > std::max(part * static_cast<double>(n), 2.0)) return;
  std::vector<std::uint64_t> numbers;
  for (const Eigen::Index k : far) numbers.push_back(s.log.row_number(k) + 1);
  s.data.push_back(far_positions(numbers, distance(far).maxCoeff(), s.log.values(far[0], *stamps)));
  leave_out(s.log, axes, far);
}

DataFinding far_positions(const std::vector<std::uint64_t>& rows, double largest,
                          std::optional<double> time) {
  std::string where;
  for (std::size_t i = 1; i < std::min<std::size_t>(rows.size(), 5); ++i)
    where += (i > 1 ? ", " : "; also row ") + std::to_string(rows[i]);
  if (rows.size() > 5) where += ", ...";
  return {counted(rows.size(), "position") + " of the tip " + (rows.size() == 1 ? "is" : "are") +
              " far off, by up to " + readable(largest, "m") + where,
          "tip",
          rows.front(),
          time,
          "these rows are left out here; look for a hidden target, or for reflections",
          DataKind::corrupt};
}

}  // namespace qerr::sanity
