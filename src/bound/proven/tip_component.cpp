#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "bound/proven/chain_bound.hpp"
#include "bound/proven/recursion.hpp"

namespace qerr {

namespace {

/// As float_rounding of the worst case in the base.
constexpr double tip_component_rounding = 64 * 0x1p-24;

/// G of the moved frame of a joint.
struct LeverLevel : DirectionTable<float> {
  FrameErrors errors;
  MomentDisc disc;    ///< of l
  double offset = 0;  ///< largest distance of the frame from the one before
  double slope = 0;   ///< largest change of G per change of l
  double size = 0;    ///< largest G for |u| = 1 and l = 0
};

class LeverRecursion {
 public:
  LeverRecursion(const ChainForm& form, std::vector<FrameErrors> errors, bool sigma, double cells);
  double along(const Eigen::Vector3d& in_tip) const;
  bool even() const { return even_; }

 private:
  void lay_out(double cells);
  void fill(std::size_t k, const DirectionFrame& at, float* values) const;
  void finish(std::size_t k, const DirectionFrame& at, double polar, float* values) const;
  void raise(std::size_t k, const MomentDisc& disc, const Eigen::Vector2d& center, const DirectionFrame& at,
             float* values) const;
  double allowance(std::size_t k, double polar, const Eigen::Vector2d& lever) const;
  double with_own(std::size_t k, const DirectionFrame& at, const Eigen::Vector2d& lever, double value) const;

  const ChainForm& form_;
  const SliceKernels& kernels_;
  std::vector<LeverLevel> levels_;  // [k]: of joint k counted from 1; [0]: of the base
  bool sigma_, even_ = true;
};

LeverRecursion::LeverRecursion(const ChainForm& form, std::vector<FrameErrors> errors, bool sigma,
                               double cells)
    : form_(form),
      kernels_(select_kernels<SliceKernels>(instruction_set())),
      levels_(form.size() + 1),
      sigma_(sigma) {
  double slope = 0, size = 0;
  for (std::size_t k = 0; k < levels_.size(); ++k) {
    LeverLevel& l = levels_[k];
    l.errors = std::move(errors[k]);
    if (k > 0) {
      const ChainStep& step = form.steps[k - 1];
      const double travel = step.prismatic ? std::max(std::abs(step.lower), std::abs(step.upper)) : 0;
      l.offset = step.translation.norm() + travel;
      size += slope * l.offset;  // l = (p + t) x u where it was p x u
    }
    const auto add = [&](const LocalError& e) {
      slope += e.width * e.axis.norm();
      size += e.width * e.constant.norm();
    };
    for (const LocalError& e : l.errors.independent) add(e);
    add(l.errors.fixed);
    if (l.errors.fixed.axis.norm() > 0 || l.errors.fixed.constant.norm() > 0) even_ = false;
    l.slope = slope * (1 + 1e-12);
    l.size = size * (1 + 1e-12);
  }
  lay_out(cells);
  for (std::size_t k = 1; k < form.size(); ++k) {
    LeverLevel& l = levels_[k];
    const auto at_node = [&](std::size_t row, std::size_t column, float* values) {
      const double polar = l.directions.polar(row);
      finish(k, direction_frame(polar, l.arc.node_cos[column], l.arc.node_sin[column]), polar, values);
    };
    tabulate(
        l, l.disc.size(), [&](const DirectionFrame& at, float* values) { fill(k, at, values); }, at_node);
    if (k > 1) std::vector<float>().swap(levels_[k - 1].table);
  }
}

void LeverRecursion::lay_out(double cells) {
  const double angle = std::numbers::pi / 2 / cells;
  double radius = form_.tip.translation().norm();
  double whole = radius + 1e-12;  // some extent, so that steps are not 0
  for (const LeverLevel& l : levels_) whole += l.offset;
  for (std::size_t k = form_.size(); k > 0; --k) {
    LeverLevel& l = levels_[k];
    const ChainStep& joint = form_.steps[k - 1];
    // Errors of two neighbours depend on the azimuth, as the second axis is fixed in this frame.
    bool azimuths = false;
    const auto consider = [&](const LocalError& e) {
      azimuths = azimuths || e.axis.head<2>().norm() > 0 || e.constant.head<2>().norm() > 0;
    };
    for (const LocalError& e : l.errors.independent) consider(e);
    consider(l.errors.fixed);
    l.arc = joint.prismatic ? fixed_grid(angle) : arc_grid(joint.lower, joint.upper, angle, azimuths);
    l.directions = direction_grid(even_, angle, l.arc);
    if (k < form_.size()) {
      const double cosine = std::cos(l.directions.diameter());
      radius = std::max(radius / (cosine * cosine) * (1 + 1e-6), 1e-7 * whole);
      l.disc = moment_disc(radius, 2 * static_cast<int>(cells / 2) + 1);
      radius = l.disc.reach() * (1 + 2e-6);
    }
    radius += l.offset;
  }
}

/// Raises values to F_k at a direction of the frame before the motion of joint k.
void LeverRecursion::raise(std::size_t k, const MomentDisc& disc, const Eigen::Vector2d& center,
                           const DirectionFrame& at, float* values) const {
  const ChainStep& joint = form_.steps[k - 1];
  const DirectionFrame before{joint.rotation * at.u, joint.rotation * at.polar, joint.rotation * at.azimuth};
  SliceSum sum;
  double constant = 0;
  if (k == 1) {
    const Eigen::Vector2d none = Eigen::Vector2d::Zero();
    constant = with_own(0, before, none, 0);
  } else {
    const LeverLevel& next = levels_[k - 1];
    const DirectionStencil s = direction_stencil(next.directions, before);
    const Eigen::Vector3d arm = joint.translation.cross(before.u);
    const double middle = 0.5 * (disc.nodes - 1), next_middle = 0.5 * (next.disc.nodes - 1);
    const Eigen::Vector2d first = center + Eigen::Vector2d(arm.dot(before.polar), arm.dot(before.azimuth)) -
                                  Eigen::Vector2d::Constant(middle * disc.step);
    sum.count = static_cast<int>(s.count);
    sum.table_nodes = next.disc.nodes;
    for (std::size_t i = 0; i < s.count; ++i) {
      const DirectionStencil::Vertex& v = s.vertices[i];
      const Eigen::Matrix2d map = (v.opposite ? -1 : 1) * v.map / next.disc.step;
      const Eigen::Vector2d origin = map * first;
      sum.table[i] = next.table.data() + next.place(v, next.disc.size());
      sum.weight[i] = static_cast<float>(v.weight);
      sum.row_0[i] = static_cast<float>(origin[0] + next_middle);
      sum.column_0[i] = static_cast<float>(origin[1] + next_middle);
      sum.row_a[i] = static_cast<float>(map(0, 0) * disc.step);
      sum.row_b[i] = static_cast<float>(map(0, 1) * disc.step);
      sum.column_a[i] = static_cast<float>(map(1, 0) * disc.step);
      sum.column_b[i] = static_cast<float>(map(1, 1) * disc.step);
    }
    constant = s.moment_residual * next.disc.radius * next.slope + s.direction_residual * next.size;
  }
  sum.value_0 = static_cast<float>(constant);
  kernels_.raise(sum, disc.view(), values);
}

/// Of the arcs between samples of q, and of rounding.
double LeverRecursion::allowance(std::size_t k, double polar, const Eigen::Vector2d& lever) const {
  const LeverLevel &l = levels_[k], &before = levels_[k - 1];
  const double between = l.arc.intervals > 0 ? (1 - std::cos(l.arc.spacing / 2)) * (1 + 1e-9) : 0;
  const double size = before.size + before.slope * l.offset;  // in the frame before the motion
  const double radius = std::max(before.disc.radius, lever.norm() + l.offset);
  return between *
             (std::hypot(std::cos(polar) * lever[0], lever[1]) * before.slope + std::sin(polar) * size) +
         tip_component_rounding * 2 * (2 * radius * l.slope + l.size);
}

/// G_k from A_k.
double LeverRecursion::with_own(std::size_t k, const DirectionFrame& at, const Eigen::Vector2d& lever,
                                double value) const {
  const FrameErrors& errors = levels_[k].errors;
  const Eigen::Vector3d l = lever[0] * at.polar + lever[1] * at.azimuth;
  double sum = sigma_ ? value * value : value;
  for (const LocalError& e : errors.independent) {
    const double c = e.width * (e.axis.dot(l) + e.constant.dot(at.u));
    sum += sigma_ ? c * c : std::abs(c);
  }
  if (sigma_) return std::sqrt(sum);
  return sum + errors.fixed.axis.dot(l) + errors.fixed.constant.dot(at.u);
}

void LeverRecursion::fill(std::size_t k, const DirectionFrame& at, float* values) const {
  const LeverLevel& l = levels_[k];
  const ChainStep& joint = form_.steps[k - 1];
  if (!joint.prismatic) return raise(k, l.disc, Eigen::Vector2d::Zero(), at, values);
  // l + q z x u; convex in q, so that the ends are enough. z x u = sin(polar) azimuth.
  for (const double motion : {joint.lower, joint.upper})
    raise(k, l.disc, Eigen::Vector2d(0, -motion * at.polar.z()), at, values);
}

/// G_k from A_k, with the allowances.
void LeverRecursion::finish(std::size_t k, const DirectionFrame& at, double polar, float* values) const {
  const MomentDisc& disc = levels_[k].disc;
  for (int a = 0; a < disc.nodes; ++a)
    for (int b = disc.begin[a]; b < disc.end[a]; ++b) {
      const Eigen::Vector2d lever(disc.at(a), disc.at(b));
      float& value = values[a * disc.nodes + b];
      value = static_cast<float>(with_own(k, at, lever, value + allowance(k, polar, lever)));
    }
}

double LeverRecursion::along(const Eigen::Vector3d& in_tip) const {
  const std::size_t n = form_.size();
  const ChainStep& joint = form_.steps[n - 1];
  const Eigen::Vector3d u = form_.tip.linear() * in_tip, l = form_.tip.translation().cross(u);
  const auto [polar, cosine, sine] = angles_of(u);
  const DirectionFrame at = direction_frame(polar, cosine, sine);
  const Eigen::Vector2d lever(l.dot(at.polar), l.dot(at.azimuth));
  const MomentDisc point = moment_disc(1e-9 * (l.norm() + 1e-3), 3);
  std::vector<float> values(9, -std::numeric_limits<float>::max());
  if (joint.prismatic) {
    for (const double motion : {joint.lower, joint.upper})
      raise(n, point, lever + Eigen::Vector2d(0, motion * std::sin(polar)), at, values.data());
  } else {
    const ArcGrid& arc = levels_[n].arc;
    for (std::size_t i = 0; i <= arc.intervals && i < arc.sample_cos.size(); ++i)
      raise(n, point, lever,
            direction_frame(polar, arc.sample_cos[i] * cosine - arc.sample_sin[i] * sine,
                            arc.sample_sin[i] * cosine + arc.sample_cos[i] * sine),
            values.data());
  }
  return with_own(n, at, lever, values[4] + allowance(n, polar, lever)) +
         tip_component_rounding * (lever.norm() * levels_[n].slope + levels_[n].size);
}

std::vector<FrameErrors> with_origins(const ChainForm& form, std::vector<FrameErrors> errors, bool sigma) {
  for (const DirectedOrigin& o : form.origins) {
    LocalError e;
    e.constant = o.direction;
    e.width = sigma ? std::sqrt(o.variance) : o.half_width;
    if (e.width > 0) errors[o.link].independent.push_back(e);
    if (!sigma) errors[o.link].fixed.constant += o.mean * o.direction;
  }
  return errors;
}

}  // namespace

std::vector<double> tip_component_bound(const ChainForm& form, TipFigure figure,
                                        const std::vector<Eigen::Vector3d>& directions, double cells) {
  std::vector<double> bounds(directions.size());
  const auto include = [&](const LeverRecursion& r) {
    for (std::size_t i = 0; i < directions.size(); ++i) {
      bounds[i] = std::max(bounds[i], r.along(directions[i]));
      if (!r.even()) bounds[i] = std::max(bounds[i], r.along(-directions[i]));
    }
  };
  if (figure == TipFigure::sigma)
    include({form, with_origins(form, sigma_errors(form), true), true, cells});
  else
    for (const std::vector<double>& signs : distant_signs(form))
      include({form, with_origins(form, worst_case_errors(form, signs), false), false, cells});
  return bounds;
}

}  // namespace qerr
