#include <algorithm>
#include <cmath>

#include "bound/proven/chain_bound.hpp"
#include "bound/proven/recursion.hpp"

namespace qerr {

namespace {

/// Rounding error of a table's value over the largest sum of the magnitudes of its terms: a value is a sum of
/// at most 20 products of floats (2^-24 each); positions in a table of at most 128 nodes are known to 3
/// roundings of 128 cells, which moves m by 6 2^-24 of the diameter of the disc in each of two coordinates.
constexpr double float_rounding = 64 * 0x1p-24;

/// What belongs to the moved frame of a joint.
struct MomentLevel : DirectionTable<float> {  // slices: [m along polar][m along azimuth]
  FrameErrors errors;
  std::vector<DirectedOrigin> origins;  ///< in the moved frame
  MomentDisc disc;
  double pre_reach = 0;  ///< of the tip from the frame before the motion
  double shift = 0;      ///< largest change of |m|
  double size = 0;       ///< largest |sum of all errors from here to the tip| for |u| = 1
};

class PositionRecursion {
 public:
  PositionRecursion(const ChainForm& form, const std::vector<double>& distant_signs, bool with_origins);
  void run(double cells);
  double along(const Eigen::Vector3d& u) const;
  double length() const;

 private:
  void lay_out(double cells);
  void raise(std::size_t k, const DirectionFrame& at, float* values) const;
  void add_terms(std::size_t k, std::size_t row, float* values) const;
  void set_tables(std::size_t k, const DirectionFrame& at, SliceSum& sum, double& constant) const;
  double origins_at(std::size_t link, const Eigen::Vector3d& u) const;

  const ChainForm& form_;
  const SliceKernels& kernels_;
  std::vector<double> reach_;
  std::vector<MomentLevel> levels_;  // [k]: of joint k counted from 1; [0]: origins in the base
  bool even_ = true;
};

PositionRecursion::PositionRecursion(const ChainForm& form, const std::vector<double>& distant_signs,
                                     bool with_origins)
    : form_(form),
      kernels_(select_kernels<SliceKernels>(instruction_set())),
      reach_(form.reaches()),
      levels_(form.size() + 1) {
  const std::vector<FrameErrors> errors = worst_case_errors(form, distant_signs);
  const std::vector<double> before = reaches_before_motion(form);
  for (std::size_t k = 0; k < levels_.size(); ++k) {
    levels_[k].errors = errors[k];
    levels_[k].pre_reach = before[k];
    if (errors[k].fixed.size > 0) even_ = false;
  }
  if (with_origins)
    for (const DirectedOrigin& o : form.origins) {
      levels_[o.link].origins.push_back(o);
      if (o.mean != 0) even_ = false;
    }
  double size = 0;
  for (std::size_t k = form.size() + 1; k-- > 0;) {
    MomentLevel& l = levels_[k];
    l.shift = l.errors.fixed.moment;
    size += l.errors.fixed.size;
    for (const LocalError& e : l.errors.independent) {
      l.shift += e.width * e.moment;
      size += e.width * e.size;
    }
    for (const DirectedOrigin& o : l.origins) size += o.half_width + std::abs(o.mean);
    l.size = size * (1 + 1e-12);
  }
}

void PositionRecursion::lay_out(double cells) {
  const double step = std::acos(-1.0) / 2 / cells;
  double radius = 0, total = 0;
  for (const MomentLevel& l : levels_) total += l.shift;
  for (std::size_t k = 1; k < levels_.size(); ++k) {
    MomentLevel& l = levels_[k];
    const ChainStep& joint = form_.steps[k - 1];
    // u at azimuth a before the motion q is at a - q after it.
    l.arc = joint.prismatic ? fixed_grid(step) : arc_grid(-joint.upper, -joint.lower, step);
    l.directions = direction_grid(even_, step, l.arc);
    const double least = total > 0 ? 1e-7 * total : 1e-12;  // some extent, so that steps are not 0
    const bool point = radius <= least;
    l.disc = moment_disc(std::max(radius, least), point ? 3 : 2 * static_cast<int>(cells / 2) + 1);
    if (k + 1 < levels_.size()) {
      // Maps m_j of a stencil of the next table: |m_j| <= |m|/cos^2 (diameter), of its own cells.
      const ChainStep& next = form_.steps[k];
      const ArcGrid arc = next.prismatic ? fixed_grid(step) : arc_grid(-next.upper, -next.lower, step);
      const double cosine = std::cos(direction_grid(even_, step, arc).diameter());
      radius = (l.disc.reach() * (1 + 2e-6) + l.shift) / (cosine * cosine) * (1 + 1e-6);
    }
  }
  for (std::size_t k = 1; k < levels_.size(); ++k) levels_[k].directions.azimuths = &levels_[k].arc;
}

/// Tables of V_k at the direction `at` of the moved frame of joint k: those of A_(k+1), and a constant.
void PositionRecursion::set_tables(std::size_t k, const DirectionFrame& at, SliceSum& sum,
                                   double& constant) const {
  if (k == form_.size()) return;
  const MomentLevel& next = levels_[k + 1];
  const Eigen::Matrix3d to_next = form_.steps[k].rotation.transpose();
  const DirectionStencil s =
      direction_stencil(next.directions, {to_next * at.u, to_next * at.polar, to_next * at.azimuth});
  sum.count = static_cast<int>(s.count);
  sum.table_nodes = next.disc.nodes;
  for (std::size_t i = 0; i < s.count; ++i) {
    const DirectionStencil::Vertex& v = s.vertices[i];
    sum.table[i] = next.table.data() + next.place(v, next.disc.size());
    sum.weight[i] = static_cast<float>(v.weight);
  }
  constant += s.moment_residual * next.disc.radius * next.pre_reach + s.direction_residual * next.size;
  // Maps from m to positions, completed for each shift in `raise`.
  for (std::size_t i = 0; i < s.count; ++i) {
    const Eigen::Matrix2d map = s.vertices[i].map / next.disc.step;
    sum.row_a[i] = static_cast<float>(map(0, 0)), sum.row_b[i] = static_cast<float>(map(0, 1));
    sum.column_a[i] = static_cast<float>(map(1, 0)), sum.column_b[i] = static_cast<float>(map(1, 1));
  }
}

double PositionRecursion::origins_at(std::size_t link, const Eigen::Vector3d& u) const {
  double sum = 0;
  for (const DirectedOrigin& o : levels_[link].origins)
    sum += o.half_width * std::abs(u.dot(o.direction)) + o.mean * u.dot(o.direction);
  return sum;
}

/// Raises values to F_k at the nodes of the disc of A_k, at a direction of the moved frame.
void PositionRecursion::raise(std::size_t k, const DirectionFrame& at, float* values) const {
  const MomentLevel& l = levels_[k];
  SliceSum sum;
  double constant = l.errors.fixed.constant_at(at.u);
  set_tables(k, at, sum, constant);
  const Eigen::Vector3d p = k == form_.size() ? Eigen::Vector3d(form_.tip.translation())
                                              : Eigen::Vector3d(form_.steps[k].translation);
  const Eigen::Vector2d along(p.dot(at.polar), p.dot(at.azimuth));
  const double middle = 0.5 * (l.disc.nodes - 1), h = l.disc.step;
  const SliceSum maps = sum;
  const double next_middle = k < form_.size() ? 0.5 * (levels_[k + 1].disc.nodes - 1) : 0;
  for (std::size_t signs = 0; signs < std::size_t{1} << l.errors.independent.size(); ++signs) {
    Eigen::Vector3d moment = l.errors.fixed.moment_at(at.u);
    double value = constant;
    for (std::size_t e = 0; e < l.errors.independent.size(); ++e) {
      const double sign = signs >> e & 1 ? 1 : -1;
      moment += sign * l.errors.independent[e].moment_at(at.u);
      value += sign * l.errors.independent[e].constant_at(at.u);
    }
    // m = (a, b) h + first
    const double first[2] = {moment.dot(at.polar) - middle * h, moment.dot(at.azimuth) - middle * h};
    for (int i = 0; i < sum.count; ++i) {
      const double ra = maps.row_a[i], rb = maps.row_b[i], ca = maps.column_a[i], cb = maps.column_b[i];
      sum.row_0[i] = static_cast<float>(ra * first[0] + rb * first[1] + next_middle);
      sum.column_0[i] = static_cast<float>(ca * first[0] + cb * first[1] + next_middle);
      sum.row_a[i] = static_cast<float>(ra * h), sum.row_b[i] = static_cast<float>(rb * h);
      sum.column_a[i] = static_cast<float>(ca * h), sum.column_b[i] = static_cast<float>(cb * h);
    }
    sum.value_0 = static_cast<float>(value + along[0] * first[0] + along[1] * first[1]);
    sum.value_a = static_cast<float>(along[0] * h);
    sum.value_b = static_cast<float>(along[1] * h);
    kernels_.raise(sum, l.disc.view(), values);
  }
}

/// Adds what does not depend on the azimuth: allowances, prismatic motion.
void PositionRecursion::add_terms(std::size_t k, std::size_t row, float* values) const {
  const MomentLevel& l = levels_[k];
  const ChainStep& joint = form_.steps[k - 1];
  const double polar = l.directions.polar(row), sine = std::sin(polar), cosine = std::cos(polar);
  const double m = l.disc.reach() + l.shift;
  const double beyond = k < form_.size() ? levels_[k + 1].pre_reach : 0;
  const double rounding = float_rounding * 2 * (m * (l.pre_reach + beyond) + l.size);
  const double between = l.arc.intervals > 0 ? (1 - std::cos(l.arc.spacing / 2)) * (1 + 1e-9) : 0;
  for (int a = 0; a < l.disc.nodes; ++a)
    for (int b = l.disc.begin[a]; b < l.disc.end[a]; ++b) {
      double added =
          rounding + between * (std::hypot(cosine * l.disc.at(a), l.disc.at(b)) * reach_[k] + sine * l.size);
      if (joint.prismatic) {
        const double along_axis = -sine * l.disc.at(a);
        added += std::max(along_axis * joint.lower, along_axis * joint.upper);
      }
      values[a * l.disc.nodes + b] += static_cast<float>(added);
    }
}

void PositionRecursion::run(double cells) {
  lay_out(cells);
  for (std::size_t k = form_.size(); k > 0; --k) {
    MomentLevel& l = levels_[k];
    const std::size_t slice = l.disc.size();
    const auto fill = [&](const DirectionFrame& at, float* values) {
      raise(k, at, values);
      if (const double added = origins_at(k, at.u); added != 0)
        for (std::size_t c = 0; c < slice; ++c) values[c] += static_cast<float>(added);
    };
    tabulate(l, slice, fill, [&](std::size_t row, std::size_t, float* values) { add_terms(k, row, values); });
    if (k < form_.size()) std::vector<float>().swap(levels_[k + 1].table);
  }
}

double PositionRecursion::along(const Eigen::Vector3d& direction) const {
  const MomentLevel& l = levels_[1];
  const auto value_at = [&](const Eigen::Vector3d& base) {
    const Eigen::Vector3d u = form_.steps[0].rotation.transpose() * base;
    const Angles angles = angles_of(u);
    const DirectionFrame at = direction_frame(angles.polar, angles.cosine, angles.sine);
    const DirectionStencil s = direction_stencil(l.directions, at);
    const double value = s.direction_residual * l.size + (at.u - u).norm() * l.size;
    return l.added(value, s, l.disc.size(), l.disc.size() / 2) + origins_at(0, base);
  };
  const double there = value_at(direction);
  return (even_ ? there : std::max(there, value_at(-direction))) * (1 + 1e-12);
}

double PositionRecursion::length() const {
  const MomentLevel& l = levels_[1];
  std::vector<double> values;
  for (std::size_t i = 0; i < l.directions.rows * l.directions.columns(); ++i)
    values.push_back(l.table[i * l.disc.size() + l.disc.size() / 2]);
  return largest_over_directions(l.directions, values) * (1 + 1e-12);
}

}  // namespace

PositionWorstCase position_worst_case_bound(const ChainForm& form,
                                            const std::vector<Eigen::Vector3d>& directions, double cells) {
  PositionWorstCase bound;
  bound.along.resize(directions.size());
  for (const std::vector<double>& signs : distant_signs(form)) {
    PositionRecursion r(form, signs, true);
    r.run(cells);
    for (std::size_t i = 0; i < directions.size(); ++i)
      bound.along[i] = std::max(bound.along[i], r.along(directions[i]));
    if (form.origins.empty()) {
      bound.length = std::max(bound.length, r.length());
    } else {
      PositionRecursion without(form, signs, false);
      without.run(cells);
      bound.length = std::max(bound.length, without.length());
    }
  }
  return bound;
}

}  // namespace qerr
