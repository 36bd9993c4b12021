#include "bound/proven/box_bound.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <queue>

namespace qerr {

namespace {

constexpr double parallel =
    4 * machine_epsilon;  // sine of the angle between directions that are equal but for rounding

/// a + slope g >= |g| over [low, high].
struct Chord {
  double slope, constant;
};

Chord chord_of_magnitude(double low, double high) {
  if (low >= 0) return {1, 0};
  if (high <= 0) return {-1, 0};
  return {(high + low) / (high - low), -2 * high * low / (high - low)};
}

Chord chord_of_square(double low, double high) { return {low + high, -low * high}; }

/// Upper bound of g.d + d.H d/2 over |d| <= half if H is negative definite, else +inf.
///
/// With A = -H, any x and r = g - A x: g.d - d.A d/2 = r.d + x.A x/2 - (x - d).A (x - d)/2. That A has no
/// negative eigenvalue is certain if Cholesky's decomposition of A less 1e-12 of its trace succeeds, as this
/// has a backward error of n (n + 1) epsilon of the trace (Higham, Accuracy and Stability, theorem 10.3).
double largest_of_concave(const Eigen::VectorXd& gradient, const Eigen::MatrixXd& hessian,
                          const Eigen::VectorXd& half) {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  Eigen::MatrixXd a = -hessian;
  const double largest = a.diagonal().maxCoeff();
  for (Eigen::Index j = 0; j < half.size(); ++j)
    if (!(half[j] > 0)) a(j, j) = largest;  // its row is zero
  const double shift = 1e-12 * a.trace();
  a.diagonal().array() -= shift;
  const Eigen::LLT<Eigen::MatrixXd> cholesky(a);
  if (cholesky.info() != Eigen::Success) return infinity;
  a.diagonal().array() += shift;
  const Eigen::VectorXd x = cholesky.solve(gradient), residual = gradient - a * x;
  return residual.cwiseAbs().dot(half) + 0.5 * x.dot(a * x);
}

double factorial(int n) { return n < 2 ? 1 : n * factorial(n - 1); }

struct OpenBox {
  double upper;
  std::size_t index;
  bool operator<(const OpenBox& other) const {  // of equal bounds the older one first
    return upper != other.upper ? upper < other.upper : index > other.index;
  }
};

class BoxSearch {
 public:
  BoxSearch(const ErrorTerms& terms, const std::vector<Limits>& ranges, double enough)
      : bound_(terms, ranges), ranges_(ranges), enough_(std::max(enough, 8 * bound_.rounding())) {}

  SearchedMaximum run(std::size_t boxes) {
    const auto n = std::ssize(ranges_);
    Eigen::VectorXd center(n), half(n);
    for (Eigen::Index j = 0; j < n; ++j) {
      const Limits& range = ranges_[j];
      center[j] = 0.5 * (range.lower + range.upper);
      // Half of the range rounded up: center and half width contain both ends.
      half[j] = bound_.matters(j) ? std::max(range.upper - center[j], center[j] - range.lower) * widened : 0;
    }
    add(center, half);
    for (std::size_t done = 1; !open_.empty() && done < boxes; done += 2) {
      const OpenBox box = open_.top();
      if (!(box.upper > enough_)) break;
      open_.pop();
      split(box.index);
    }
    result_.upper = std::max(closed_, open_.empty() ? 0 : open_.top().upper);
    return std::move(result_);
  }

 private:
  static constexpr double widened =
      1 + 0x1p-50;  // for what is lost in rounding the half width and the center
  static double least_half(double center) { return 0x1p-50 * std::abs(center); }

  void add(const Eigen::VectorXd& center, const Eigen::VectorXd& half) {
    const BoxBound::Result bound = bound_(center, half);
    if (bound.at_center > largest_) {
      largest_ = bound.at_center;
      result_.at = center;
    }
    if (!(bound.upper > enough_) || half.isZero(0)) {
      closed_ = std::max(closed_, bound.upper);
      return;
    }
    open_.push({bound.upper, centers_.size()});
    centers_.push_back(center);
    halves_.push_back(half);
    widest_.push_back(static_cast<Eigen::Index>(bound.widest));
  }

  void split(std::size_t box) {
    const Eigen::Index along = widest_[box];
    Eigen::VectorXd center = std::move(centers_[box]), half = std::move(halves_[box]);
    const double middle = center[along], quarter = 0.5 * half[along];
    half[along] = quarter * widened + least_half(middle) + least_half(quarter);
    center[along] = middle - quarter;
    add(center, half);
    center[along] = middle + quarter;
    add(center, half);
  }

  BoxBound bound_;
  const std::vector<Limits>& ranges_;
  double enough_, closed_ = 0, largest_ = -1;
  SearchedMaximum result_;
  std::priority_queue<OpenBox> open_;
  std::vector<Eigen::VectorXd> centers_, halves_;
  std::vector<Eigen::Index> widest_;
};

/// The ranges of the joints, and of the base of `along_any_direction`.
std::vector<Limits> with_base(std::vector<Limits> ranges) {
  ranges.insert(ranges.end(), 2, {-std::numbers::pi / 2, std::numbers::pi / 2});
  return ranges;
}

}  // namespace

BoxBound::BoxBound(const ErrorTerms& terms, const std::vector<Limits>& ranges)
    : terms_(terms), count_(terms.axes().size()), joints_(ranges.size()) {
  for (std::size_t k = 0; k < count_; ++k)
    if (terms.axes()[k].coordinate >= 0 && terms.axes()[k].multiplier != 0) movers_.push_back(k);
  set_parts();
  length_ = terms.longest_columns(ranges);
  set_rounding(ranges);
  set_influence(ranges);
  const auto n = static_cast<Eigen::Index>(count_);
  radius_.resize(n);
  reach_.resize(n);
  derivative_.assign(joints_, Columns::Zero(3, n));
}

/// The magnitude of the mean is that of one more term.
void BoxBound::set_parts() {
  Part mean{Eigen::VectorXd::Zero(count_), 1};
  for (const ErrorTerm& term : terms_.terms()) {
    const double size = terms_.sigma() ? term.sigma : term.half_width;
    if (size > 0) parts_.push_back({term.weights, size});
    mean.weights += term.mean * term.weights;
  }
  if (!terms_.sigma() && !mean.weights.isZero(0)) parts_.push_back(std::move(mean));
}

void BoxBound::set_rounding(const std::vector<Limits>& ranges) {
  double largest_angle = 0, size = 0;
  for (const TermAxis& axis : terms_.axes())
    if (axis.turns) largest_angle = std::max(largest_angle, terms_.largest_motion(axis, ranges));
  for (const Part& part : parts_) {
    const double full = part.size * part.weights.cwiseAbs().dot(length_);
    size = terms_.sigma() ? std::hypot(size, full) : size + full;
  }
  const double operations = static_cast<double>(count_ + parts_.size() + 2) * (64 + 2 * largest_angle);
  rounding_ = machine_epsilon * (operations * size + 4 * terms_.added());
}

/// Whether a turn about an axis leaves a length as it is: it turns the columns beyond the axis, and those
/// before must be along it, or in terms of their own that have none beyond.
bool BoxBound::turns_whole(const TermColumns& at, std::size_t axis) const {
  const auto k = static_cast<Eigen::Index>(axis);
  for (Eigen::Index before = 0; before < k; ++before) {
    if (at.columns.col(before).cross(at.turning.col(k)).norm() <= parallel) continue;
    for (const Part& part : parts_) {
      const bool alone = terms_.sigma() && part.weights.tail(part.weights.size() - k).isZero(0);
      if (part.weights[before] != 0 && !alone) return false;
    }
  }
  return true;
}

void BoxBound::set_influence(const std::vector<Limits>& ranges) {
  Eigen::VectorXd middle(joints_);
  for (std::size_t j = 0; j < joints_; ++j) middle[j] = 0.5 * (ranges[j].lower + ranges[j].upper);
  const TermColumns at = terms_.columns(middle);
  const bool of_length = terms_.length() || terms_.turned_base();
  std::vector<bool> idle(count_, false);
  for (std::size_t k = terms_.turned_base() ? 2 : 0; k < count_ && !terms_.in_tip_frame(); ++k) {
    if (!terms_.axes()[k].turns) {
      idle[k] = true;
      continue;
    }
    const Eigen::Vector3d axis = at.turning.col(k);
    idle[k] =
        of_length ? turns_whole(at, k) : Eigen::Vector3d::Unit(terms_.row()).cross(axis).norm() <= parallel;
    if (of_length || !idle[k]) break;  // axes beyond turn a part of the columns
  }
  matters_.assign(joints_, false);
  for (const std::size_t k : movers_)
    if (!idle[k]) matters_[terms_.axes()[k].coordinate] = true;
}

void BoxBound::set_reach(const Eigen::VectorXd& half) {
  double carried = 0;
  for (std::size_t k = count_; k-- > 0;) {
    const TermAxis& axis = terms_.axes()[k];
    radius_[k] = axis.coordinate < 0 ? 0 : std::abs(axis.multiplier) * half[axis.coordinate];
    reach_[k] = !axis.turns ? 1 : std::min(length_[k], at_.columns.col(k).norm() + carried);
    if (terms_.in_tip_frame()) reach_[k] = length_[k];
    carried += radius_[k] * reach_[k];
  }
}

Eigen::Vector3d BoxBound::first(std::size_t motion, std::size_t column) const {
  const auto i = static_cast<Eigen::Index>(motion), k = static_cast<Eigen::Index>(column);
  const Eigen::Vector3d zi = at_.turning.col(i), zk = at_.turning.col(k), ji = at_.columns.col(i),
                        jk = at_.columns.col(k);
  if (terms_.in_tip_frame())
    return k < i ? Eigen::Vector3d(zk.cross(ji) + jk.cross(zi)) : Eigen::Vector3d::Zero();
  return i <= k ? zi.cross(jk) : zk.cross(ji);
}

/// @pre i <= j
Eigen::Vector3d BoxBound::second(std::size_t i, std::size_t j, std::size_t column) const {
  const auto z = [&](std::size_t k) -> Eigen::Vector3d { return at_.turning.col(k); };
  const auto v = [&](std::size_t k) -> Eigen::Vector3d { return at_.columns.col(k); };
  if (terms_.in_tip_frame()) {  // [[twist_k, twist_i], twist_j]
    if (column >= i) return Eigen::Vector3d::Zero();
    const Eigen::Vector3d turning = z(column).cross(z(i)),
                          moving = z(column).cross(v(i)) + v(column).cross(z(i));
    return turning.cross(v(j)) + moving.cross(z(j));
  }
  const std::size_t a = std::min(i, column), c = std::max(j, column),
                    b = column < i ? i : std::min(column, j);
  return z(a).cross(z(b).cross(v(c)));
}

/// sum over all tuples of `order` motions of their half widths times the bound of the derivative of
/// sum_k C_k . column_k, over order!, with |C_k| = magnitudes.
double BoxBound::remainder(int order, const Eigen::VectorXd& magnitudes) const {
  return (terms_.in_tip_frame() ? remainder_in_tip(order, magnitudes)
                                : remainder_in_base(order, magnitudes)) /
         factorial(order);
}

/// A derivative is z x (... x J_m) with the outermost axis m of the tuple; axes before it that do not turn
/// make it zero.
double BoxBound::remainder_in_base(int order, const Eigen::VectorXd& magnitudes) const {
  double sum = 0, motions = 0, columns = 0;  // of the axes before m that turn
  for (std::size_t m = 0; m < count_; ++m) {
    if (terms_.axes()[m].turns) {
      const double with = motions + radius_[m], all = columns + magnitudes[m];
      sum += reach_[m] * (std::pow(with, order) * all - std::pow(motions, order) * columns);
      motions = with;
      columns = all;
    } else {
      sum += std::pow(motions, order) * magnitudes[m] +
             order * radius_[m] * std::pow(motions, order - 1) * columns;
    }
  }
  return sum;
}

/// Column k changes with the axes beyond it only: each term of z_k x sum of links, turned as a whole or in
/// its first factor, keeps its length.
double BoxBound::remainder_in_tip(int order, const Eigen::VectorXd& magnitudes) const {
  double sum = 0, turning = 0, sliding = 0;  // of the axes beyond k
  for (std::size_t m = count_; m-- > 0;) {
    const bool turns = terms_.axes()[m].turns;
    sum += magnitudes[m] * (length_[m] * std::pow(turning, order) +
                            (turns ? order * std::pow(turning, order - 1) * sliding : 0));
    (turns ? turning : sliding) += radius_[m];
  }
  return sum;
}

void BoxBound::set_first(const Eigen::VectorXd& half) {
  for (std::size_t j = 0; j < joints_; ++j)
    if (half[j] > 0) derivative_[j].setZero();
  for (const std::size_t i : movers_) {
    const TermAxis& axis = terms_.axes()[i];
    if (!(half[axis.coordinate] > 0)) continue;
    Columns& of_joint = derivative_[axis.coordinate];
    for (std::size_t k = 0; k < count_; ++k) of_joint.col(k) += axis.multiplier * first(i, k);
  }
}

/// Step 1, and the chords of step 2.
/// @param slopes  receives C_k of L = sum_k C_k . column_k
/// @param blame   receives what each joint's range adds
/// @param plain   receives the bound that takes every term at its largest
/// @returns the constant of the chords
double BoxBound::chords(const Eigen::VectorXd& half, Columns& slopes, Eigen::VectorXd& blame,
                        double& plain) const {
  const Eigen::Index from = terms_.length() ? 0 : terms_.row(), to = terms_.length() ? 3 : terms_.row() + 1;
  double constant = 0;
  plain = 0;
  for (const Part& part : parts_) {
    const Eigen::VectorXd magnitudes = part.weights.cwiseAbs();
    const double most = magnitudes.dot(reach_), curved = remainder(2, magnitudes);
    const Eigen::Vector3d value = at_.columns * part.weights;
    for (Eigen::Index row = from; row < to; ++row) {
      double width = curved;
      for (std::size_t j = 0; j < joints_; ++j) {
        const double side = half[j];
        if (side > 0) width += side * std::abs(derivative_[j].row(row).dot(part.weights));
      }
      const double low = std::max(value[row] - width, -most), high = std::min(value[row] + width, most);
      const double largest = std::max(std::abs(low), std::abs(high)) * part.size;
      const double factor = terms_.sigma() ? part.size * part.size : part.size;
      const Chord chord = terms_.sigma() ? chord_of_square(low, high) : chord_of_magnitude(low, high);
      plain += terms_.sigma() ? largest * largest : largest;
      constant += factor * chord.constant;
      slopes.row(row) += factor * chord.slope * part.weights.transpose();
      const double bent = terms_.sigma() ? factor * (high - low) : low < 0 && high > 0 ? factor : 0;
      if (!(bent > 0)) continue;
      for (std::size_t j = 0; j < joints_; ++j) {
        const double side = half[j];
        if (side > 0)
          blame[j] +=
              bent * side * (std::abs(derivative_[j].row(row).dot(part.weights)) + curved / radius_.sum());
      }
    }
  }
  return constant;
}

/// The largest L over the box, less its value at the center.
double BoxBound::combined(const Eigen::VectorXd& half, const Columns& slopes, Eigen::VectorXd& blame) const {
  const auto n = static_cast<Eigen::Index>(joints_);
  Eigen::VectorXd gradient = Eigen::VectorXd::Zero(n);
  for (Eigen::Index j = 0; j < n; ++j)
    if (half[j] > 0) gradient[j] = derivative_[j].cwiseProduct(slopes).sum();
  Eigen::MatrixXd hessian = Eigen::MatrixXd::Zero(n, n);
  for (std::size_t a = 0; a < movers_.size(); ++a) {
    const TermAxis& inner = terms_.axes()[movers_[a]];
    if (!(half[inner.coordinate] > 0)) continue;
    for (std::size_t b = a; b < movers_.size(); ++b) {
      const TermAxis& outer = terms_.axes()[movers_[b]];
      if (!(half[outer.coordinate] > 0)) continue;
      double entry = 0;
      for (std::size_t k = 0; k < count_; ++k) {
        const Eigen::Vector3d slope = slopes.col(k);
        if (slope != Eigen::Vector3d::Zero()) entry += slope.dot(second(movers_[a], movers_[b], k));
      }
      entry *= inner.multiplier * outer.multiplier;
      hessian(inner.coordinate, outer.coordinate) += entry;
      if (a != b) hessian(outer.coordinate, inner.coordinate) += entry;
    }
  }
  const double third = remainder(3, slopes.colwise().norm().transpose());
  const double radius = radius_.sum();
  double sum = 0;
  for (Eigen::Index j = 0; j < n; ++j) {
    if (!(half[j] > 0)) continue;
    // |H_ij d_i d_j| <= |H_ij| (d_i^2 half_j/half_i + d_j^2 half_i/half_j)/2
    double bend = hessian(j, j);
    for (Eigen::Index other = 0; other < n; ++other)
      if (other != j) bend += std::abs(hessian(j, other)) * half[other] / half[j];
    const double slope = std::abs(gradient[j]);
    const bool inside = bend < 0 && slope < -bend * half[j];
    const double along = inside ? -0.5 * slope * slope / bend : (slope + 0.5 * bend * half[j]) * half[j];
    sum += along;
    blame[j] += along + (radius > 0 ? third * half[j] / radius : 0);
  }
  return std::min(sum, largest_of_concave(gradient, hessian, half)) + third;
}

BoxBound::Result BoxBound::operator()(const Eigen::VectorXd& center, const Eigen::VectorXd& half) {
  at_ = terms_.columns(center);
  set_reach(half);
  set_first(half);
  Columns slopes = Columns::Zero(3, count_);
  Eigen::VectorXd blame = Eigen::VectorXd::Zero(joints_);
  double plain = 0;
  const double constant = chords(half, slopes, blame, plain);
  const double linear = constant + at_.columns.cwiseProduct(slopes).sum() + combined(half, slopes, blame);
  Result result;
  blame.maxCoeff(&result.widest);
  result.at_center = terms_.value(terms_.vectors(at_));
  const double added = terms_.added(), radius = 1 + radius_.sum(), rounding = rounding_ * radius * radius;
  if (!terms_.sigma()) {
    result.upper = std::min(plain, linear) + added + rounding;
  } else {
    // The sum of the chords loses digits where it is much less than its parts: the allowance is of the
    // square, 2 g dg of each term and epsilon of each part.
    const double squares = std::max(linear, 0.0) + 8 * rounding * (std::sqrt(plain) + rounding);
    result.upper = std::hypot(std::sqrt(std::min(plain, squares)), added) + rounding;
  }
  return result;
}

SearchedMaximum branch_and_bound(const ErrorTerms& terms, const std::vector<Limits>& ranges,
                                 double known_lower, double gap, std::size_t boxes) {
  const double enough = known_lower * (1 + gap);
  if (!terms.length() || terms.sigma()) return BoxSearch(terms, ranges, enough).run(boxes);
  const std::vector<Limits> all = with_base(ranges);
  const ErrorTerms along_x = terms.along_any_direction(ranges.size());
  SearchedMaximum found = BoxSearch(along_x, all, enough).run(boxes);
  found.at.conservativeResize(std::ssize(ranges));
  return found;
}

std::size_t boxes_of_gap(double gap) {
  constexpr double at_one_percent = 0x1p17, most = 0x1p21;
  return static_cast<std::size_t>(std::min(most, at_one_percent * 0.01 / gap));
}

double rounding_allowance(const ErrorTerms& terms, const std::vector<Limits>& ranges) {
  return BoxBound(terms, ranges).rounding();
}

std::size_t influential_joints(const ErrorTerms& terms, const std::vector<Limits>& ranges) {
  const bool turned = terms.length() && !terms.sigma();
  const ErrorTerms along_x = turned ? terms.along_any_direction(ranges.size()) : terms;
  const std::vector<Limits> all = turned ? with_base(ranges) : ranges;
  const BoxBound bound(along_x, all);
  std::size_t count = 0;
  for (std::size_t j = 0; j < all.size(); ++j) count += bound.matters(j) && all[j].lower < all[j].upper;
  return count;
}

}  // namespace qerr
