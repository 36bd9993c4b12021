#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "bound/proven/chain_bound.hpp"
#include "bound/proven/kernels.hpp"
#include "bound/proven/recursion.hpp"

namespace qerr {

namespace {

/// As float_rounding of the worst case; positions in a table are known to 6 roundings of its side.
constexpr double cone_rounding = 64 * 0x1p-24;

/// Functions of (u, m, s) before the motion of a joint.
struct ConeLevel : DirectionTable<float> {
  std::vector<LocalError> errors;
  double scale = 0;      ///< M of the tables
  double pre_reach = 0;  ///< of the tip from the frame before the motion
  double moment = 0;     ///< largest change of |m| for s = 1
  double size = 0;       ///< largest root of the variance from here to the tip
};

class ConeRecursion {
 public:
  ConeRecursion(const ChainForm& form, double cells);
  double along(const Eigen::Vector3d& u) const;

 private:
  std::size_t slice() const { return nodes_ * nodes_; }
  void fill(std::size_t k, const DirectionFrame& at, float* values) const;
  void at_tip(std::size_t k, const DirectionFrame& at, float* values) const;
  void step(const LocalError& e, const DirectionFrame& at, double scale, ConeSum sum, float* values,
            int first, int last) const;
  ConeSum beyond(std::size_t k, const DirectionFrame& at, double& constant) const;
  void add_terms(std::size_t k, std::size_t row, float* values) const;

  const ChainForm& form_;
  const ConeKernels& kernels_;
  std::vector<double> reach_;
  std::vector<ConeLevel> levels_;  // [k]: of joint k counted from 1; [0]: of the base
  int nodes_, arcs_;
};

ConeRecursion::ConeRecursion(const ChainForm& form, double cells)
    : form_(form),
      kernels_(select_kernels<ConeKernels>(instruction_set())),
      reach_(form.reaches()),
      levels_(form.size() + 1),
      nodes_(2 * static_cast<int>(std::ceil(cells / 2)) + 1),
      arcs_(static_cast<int>(std::ceil(2 * cells))) {
  const std::vector<FrameErrors> errors = sigma_errors(form);
  const std::vector<double> before = reaches_before_motion(form);
  const double angle = std::numbers::pi / 2 / cells;
  for (std::size_t k = 0; k < levels_.size(); ++k) {
    levels_[k].errors = errors[k].independent;
    levels_[k].pre_reach = before[k];
  }
  for (const DirectedOrigin& o : form.origins) {
    LocalError e;
    e.constant = o.direction;
    e.width = std::sqrt(o.variance);
    e.size = 1;
    if (e.width > 0) levels_[o.link].errors.push_back(e);
  }
  double squares = 0, total = 0;
  for (const ConeLevel& l : levels_)
    for (const LocalError& e : l.errors) total += e.width * e.moment;
  for (std::size_t k = 1; k < levels_.size(); ++k) {
    ConeLevel& l = levels_[k];
    l.scale = std::max(std::sqrt(squares), 1e-6 * total + 1e-300);
    for (const LocalError& e : l.errors) {
      squares += e.width * e.width * e.moment * e.moment;
      l.moment = std::hypot(l.moment, e.width * e.moment);
    }
    // The slice between two errors of a frame is looked up as far as the second shifts m.
    if (l.errors.size() > 1) l.scale = std::hypot(l.scale, l.moment);
    const ChainStep& joint = form.steps[k - 1];
    l.arc = joint.prismatic ? fixed_grid(angle) : arc_grid(-joint.upper, -joint.lower, angle);
    l.directions = direction_grid(true, angle, l.arc);
  }
  double variance = 0;
  for (std::size_t k = levels_.size(); k-- > 0;) {
    for (const LocalError& e : levels_[k].errors) variance += std::pow(e.width * e.size, 2);
    levels_[k].size = std::sqrt(variance) * (1 + 1e-12);
  }
  for (std::size_t k = form.size(); k > 0; --k) {
    ConeLevel& l = levels_[k];
    tabulate(
        l, slice(), [&](const DirectionFrame& at, float* values) { fill(k, at, values); },
        [&](std::size_t row, std::size_t, float* values) { add_terms(k, row, values); });
    if (k < form.size()) std::vector<float>().swap(levels_[k + 1].table);
  }
}

/// The sum for V_k at the nodes of the tables of joint k, without shift, and what it lacks for s = 1.
ConeSum ConeRecursion::beyond(std::size_t k, const DirectionFrame& at, double& constant) const {
  const ConeLevel &l = levels_[k], &next = levels_[k + 1];
  const Eigen::Matrix3d to_next = form_.steps[k].rotation.transpose();
  const DirectionStencil s =
      direction_stencil(next.directions, {to_next * at.u, to_next * at.polar, to_next * at.azimuth});
  ConeSum sum;
  sum.count = static_cast<int>(s.count);
  sum.nodes = nodes_;
  for (std::size_t i = 0; i < s.count; ++i) {
    const DirectionStencil::Vertex& v = s.vertices[i];
    sum.table[i] = next.table.data() + next.place(v, slice());
    sum.weight[i] = static_cast<float>(v.weight);
    const Eigen::Matrix2d map = v.map * (l.scale / next.scale);
    sum.row_a[i] = static_cast<float>(map(0, 0)), sum.row_b[i] = static_cast<float>(map(0, 1));
    sum.column_a[i] = static_cast<float>(map(1, 0)), sum.column_b[i] = static_cast<float>(map(1, 1));
  }
  const Eigen::Vector3d& t = form_.steps[k].translation;
  sum.value_a = static_cast<float>(l.scale * t.dot(at.polar));
  sum.value_b = static_cast<float>(l.scale * t.dot(at.azimuth));
  sum.root = 1;
  constant += s.moment_residual * (std::sqrt(2.0) * l.scale + l.moment) * next.pre_reach +
              s.direction_residual * next.size;
  return sum;
}

/// Raises values to the largest over the circle of an error's share, by the ends of the half circle and the
/// vertices of the polygon.
void ConeRecursion::step(const LocalError& e, const DirectionFrame& at, double scale, ConeSum sum,
                         float* values, int first, int last) const {
  const Eigen::Vector3d moment = e.moment_at(at.u);
  const double shift[2] = {moment.dot(at.polar) / scale, moment.dot(at.azimuth) / scale};
  const double value = e.constant_at(at.u);
  const ConeSum plain = sum;
  const double spacing = std::numbers::pi / arcs_;
  const auto raise = [&](double beta, double root) {
    for (int i = 0; i < sum.count; ++i) {
      sum.row_s[i] = static_cast<float>(beta * (plain.row_a[i] * shift[0] + plain.row_b[i] * shift[1]));
      sum.column_s[i] =
          static_cast<float>(beta * (plain.column_a[i] * shift[0] + plain.column_b[i] * shift[1]));
    }
    sum.root = static_cast<float>(root);
    sum.value_s = static_cast<float>(beta * (value + plain.value_a * shift[0] + plain.value_b * shift[1]));
    kernels_.raise(sum, first, last, values);
  };
  if (std::hypot(shift[0], shift[1]) == 0 && value == 0) return raise(0, 1);
  raise(1, 0);
  raise(-1, 0);
  for (int i = 0; i < arcs_; ++i) {
    const double angle = (i + 0.5) * spacing - std::numbers::pi / 2;
    raise(std::sin(angle) / std::cos(spacing / 2), std::cos(angle) / std::cos(spacing / 2));
  }
}

/// F_n = m . p + s |(sigma (D . p + e . u))|.
void ConeRecursion::at_tip(std::size_t k, const DirectionFrame& at, float* values) const {
  const Eigen::Vector3d p = form_.tip.translation();
  double squares = 0;
  for (const LocalError& e : levels_[k].errors)
    squares += std::pow(e.moment_at(at.u).dot(p) + e.constant_at(at.u), 2);
  ConeSum sum;
  sum.nodes = nodes_;
  sum.value_a = static_cast<float>(levels_[k].scale * p.dot(at.polar));
  sum.value_b = static_cast<float>(levels_[k].scale * p.dot(at.azimuth));
  sum.value_s = static_cast<float>(std::sqrt(squares));
  kernels_.raise(sum, 0, nodes_, values);
}

void ConeRecursion::fill(std::size_t k, const DirectionFrame& at, float* values) const {
  const ConeLevel& l = levels_[k];
  std::vector<float> memory;
  if (k == form_.size()) return at_tip(k, at, values);
  double constant = 0;
  ConeSum sum = beyond(k, at, constant);
  // The table of the first joint is looked up at m = 0 alone.
  const int first = k == 1 ? nodes_ / 2 : 0, last = k == 1 ? nodes_ / 2 + 1 : nodes_;
  if (l.errors.empty()) kernels_.raise(sum, first, last, values);
  for (std::size_t i = 0; i < l.errors.size(); ++i) {
    if (i > 0) {  // from the slice of the errors before
      memory.assign(values, values + slice());
      std::fill_n(values, slice(), -std::numeric_limits<float>::max());
      sum = {};
      sum.count = 1;
      sum.nodes = nodes_;
      sum.table[0] = memory.data();
      sum.weight[0] = sum.row_a[0] = sum.column_b[0] = 1;
      constant += cone_rounding * 4 * ((l.scale + l.moment) * l.pre_reach + l.size);
    }
    const bool all = i + 1 < l.errors.size();
    step(l.errors[i], at, l.scale, sum, values, all ? 0 : first, all ? nodes_ : last);
  }
  for (std::size_t c = 0; c < slice(); ++c) values[c] += static_cast<float>(constant);
}

void ConeRecursion::add_terms(std::size_t k, std::size_t row, float* values) const {
  const ConeLevel& l = levels_[k];
  const ChainStep& joint = form_.steps[k - 1];
  const double polar = l.directions.polar(row), sine = std::sin(polar), cosine = std::cos(polar);
  const double beyond = k < form_.size() ? levels_[k + 1].pre_reach : 0;
  const double rounding =
      cone_rounding * 4 * ((std::sqrt(2.0) * l.scale + l.moment) * (l.pre_reach + beyond) + l.size);
  const double between = l.arc.intervals > 0 ? (1 - std::cos(l.arc.spacing / 2)) * (1 + 1e-9) : 0;
  const int middle = nodes_ / 2;
  for (int i = 0; i < nodes_; ++i)
    for (int j = 0; j < nodes_; ++j) {
      const double a = static_cast<double>(i - middle) / middle, b = static_cast<double>(j - middle) / middle;
      const double height = 1 - std::max(std::abs(a), std::abs(b));
      double added =
          rounding + between * (std::hypot(cosine * a, b) * l.scale * reach_[k] + sine * height * l.size);
      if (joint.prismatic)
        added += std::max(-sine * a * l.scale * joint.lower, -sine * a * l.scale * joint.upper);
      values[i * nodes_ + j] += static_cast<float>(added);
    }
}

double ConeRecursion::along(const Eigen::Vector3d& direction) const {
  const ConeLevel& l = levels_[1];
  const Eigen::Vector3d u = form_.steps[0].rotation.transpose() * direction;
  const DirectionStencil s = direction_weights(l.directions, u);
  const double value = l.added(s.direction_residual * l.size, s, slice(), slice() / 2);
  double squares = value * value;
  for (const LocalError& e : levels_[0].errors) squares += std::pow(e.constant_at(direction), 2);
  return std::sqrt(squares) * (1 + 1e-12);
}

}  // namespace

std::vector<double> component_sigma_bound(const ChainForm& form,
                                          const std::vector<Eigen::Vector3d>& directions, double cells) {
  const ConeRecursion r(form, cells);
  std::vector<double> bounds;
  for (const Eigen::Vector3d& u : directions) bounds.push_back(r.along(u));
  return bounds;
}

}  // namespace qerr
