#include <algorithm>
#include <cmath>
#include <deque>
#include <numbers>

#include "bound/proven/chain_bound.hpp"
#include "bound/proven/kernels.hpp"
#include "bound/proven/recursion.hpp"
#include "core/parallel.hpp"

namespace qerr {

namespace {

/// The largest rounding error of a table's value over (sum of sigmas) (largest reach). Points, node positions
/// and the interpolation are sums of fewer than 100 products of numbers up to the reach, and G_k changes by
/// at most the root of the summed variances per length; that is 100 units in the last place, 2^-53 each,
/// for each of the operations below: coordinates, forms, weights, averages.
constexpr double tip_rounding = 1e-13;
/// Rounding of the quadratic forms, relative to the square of (sum of sigmas) (largest reach).
constexpr double rounding_of_form = 1e-14;

Eigen::Matrix3d cross_matrix(const Eigen::Vector3d& z) {
  Eigen::Matrix3d m;
  m << 0, -z.z(), z.y(), z.z(), 0, -z.x(), -z.y(), z.x(), 0;
  return m;
}

/// Cylinder about a joint's axis that holds the tip.
struct Cylinder {
  double radius, lowest, highest;
};

/// Where points lie in the frame before a joint, of those of a cylinder of its moved frame whose images are
/// within `reach` of the origin.
/// @param least  extent; 1e-6 of the largest reach
Cylinder image(const Cylinder& c, const ChainStep& step, double reach, double least) {
  Eigen::Vector3d low = step.translation, high = step.translation;
  if (step.prismatic) {
    low += step.lower * step.rotation.col(2);
    high += step.upper * step.rotation.col(2);
  }
  const double sine = step.rotation.row(2).head<2>().norm();
  const double height = std::max(std::abs(c.lowest), std::abs(c.highest));
  const double a = step.rotation(2, 2) * c.lowest, b = step.rotation(2, 2) * c.highest;
  // Margins of 1e-12 of the largest reach for rounding; tables have some extent, so that their spacing is not
  // 0.
  const double margin = 1e-6 * least;
  Cylinder out;
  out.lowest = std::max(std::min(low.z(), high.z()) + std::min(a, b) - sine * c.radius, -reach) - margin;
  out.highest = std::min(std::max(low.z(), high.z()) + std::max(a, b) + sine * c.radius, reach) + margin;
  const double across = std::max(low.head<2>().norm(), high.head<2>().norm());
  out.radius = std::max(std::min(across + c.radius + sine * height, reach) + margin, least);
  if (out.highest - out.lowest < least) out.highest += least, out.lowest -= least;
  return out;
}

/// M_k over a cylinder, with the form V_k.
struct TipLevel {
  ArcGrid arc;
  std::vector<double> values;
  std::vector<int> node_of_bin;
  TipTable view;
  double radius_spacing = 0, height_spacing = 0;
};

void add_form(TipTable& t, const Eigen::Matrix3d& a, const Eigen::Vector3d& b, double variance) {
  const Eigen::Matrix3d q = variance * a.transpose() * a;
  const Eigen::Vector3d l = variance * a.transpose() * b;
  const double entries[6] = {q(0, 0), q(1, 1), q(2, 2), q(0, 1), q(0, 2), q(1, 2)};
  for (int i = 0; i < 6; ++i) t.q[i] += entries[i];
  for (int i = 0; i < 3; ++i) t.b[i] += l[i];
  t.c += variance * b.squaredNorm();
}

void set_bins(TipLevel& t) {
  t.view.bins = 4 * t.arc.nodes;  // a bin spans at most 8/bins rad, less than a node's spacing
  t.node_of_bin.resize(t.view.bins + 1);
  for (std::size_t i = 0; i <= t.view.bins; ++i) {
    const double place = 4.0 * static_cast<double>(i) / static_cast<double>(t.view.bins);
    const double quarter = std::floor(place),
                 part = quarter == 1 || quarter == 3 ? 1 - (place - quarter) : place - quarter;
    double angle = std::atan2(part, 1 - part);
    if (quarter == 1) angle = std::numbers::pi - angle;
    if (quarter == 2) angle = std::numbers::pi + angle;
    if (quarter >= 3) angle = 2 * std::numbers::pi - angle;
    if (quarter >= 4) angle = 2 * std::numbers::pi;
    const double node = std::max(0.0, angle - 1e-9) / t.arc.node_spacing;
    t.node_of_bin[i] = static_cast<int>(std::min(std::floor(node), static_cast<double>(t.arc.nodes - 1)));
  }
  t.view.node_of_bin = t.node_of_bin.data();
}

/// The chain with its last moved frame turned about its axis.
ChainForm tip_at_azimuth_0(ChainForm form) {
  const Eigen::Vector3d p = form.tip.translation();
  const double azimuth = std::atan2(p.y(), p.x());
  form.steps.back().rotation *= Eigen::AngleAxisd(azimuth, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  form.tip.translation() = Eigen::Vector3d(p.head<2>().norm(), 0, p.z());
  return form;
}

void set_nodes(TipLevel& t, const Cylinder& domain, double step, double cells) {
  const auto nodes = [&](double length) {
    return std::max<std::size_t>(static_cast<std::size_t>(std::ceil(std::max(length / step, cells / 4))) + 1,
                                 2);
  };
  TipTable& v = t.view;
  v.radii = nodes(domain.radius);
  v.heights = nodes(domain.highest - domain.lowest);
  v.lowest = domain.lowest;
  t.radius_spacing = domain.radius / static_cast<double>(v.radii - 1);
  t.height_spacing = (domain.highest - domain.lowest) / static_cast<double>(v.heights - 1);
  v.radii_per_length = 1 / t.radius_spacing;
  v.heights_per_length = 1 / t.height_spacing;
  v.columns = t.arc.full ? 1 : t.arc.nodes + 1;
  v.node_cos = t.arc.node_cos.data();
  v.node_sin = t.arc.node_sin.data();
  if (!t.arc.full) set_bins(t);
}

class TipRecursion {
 public:
  TipRecursion(const ChainForm& form, double cells)
      : form_(tip_at_azimuth_0(form)),
        kernels_(select_kernels<TipKernels>(instruction_set())),
        reaches_(form.reaches()) {
    double sum = 0;
    for (const DirectedError& e : form_.errors) sum += std::sqrt(e.variance) * e.of_joints.cwiseAbs().sum();
    scale_ = sum;
    if (!(reaches_[0] > 0)) reaches_[0] = 1;
    lay_out(cells);
    add_forms();
  }

  double operator()() {
    const std::size_t n = form_.size();
    for (std::size_t k = 1; k <= n; ++k) fill(k);
    const Eigen::Vector3d p = form_.tip.translation();
    const TipLevel& last = tables_[n];
    TipTable at_tip = last.view;
    at_tip.values = nullptr;
    double form_only = 0;
    kernels_.evaluate(at_tip, &p[0], &p[1], &p[2], &form_only, 1);
    return std::hypot(form_only, of_tip_) * (1 + tip_rounding);
  }

 private:
  void lay_out(double cells);
  void add_forms();
  void fill(std::size_t k);
  void fill_rows(std::size_t k, std::size_t height);
  void maxima(std::size_t k, double r, double z, double* values, std::vector<double>& memory) const;

  const ChainForm form_;
  const TipKernels& kernels_;
  std::vector<double> reaches_;
  std::deque<TipLevel> tables_;  // [k]: of joint k, counted from 1; [0]: of the base
  double scale_ = 0, of_tip_ = 0;
};

/// Cylinders and grids from the tip to the base, as each holds the images of all nodes of the one beyond it.
void TipRecursion::lay_out(double cells) {
  const std::size_t n = form_.size();
  tables_.resize(n + 1);
  const Eigen::Vector3d p = form_.tip.translation();
  Cylinder at{p.head<2>().norm(), p.z(), p.z()};
  double reach = p.norm();  // of the points that are looked up
  const double step = reaches_[0] / cells, angle = 2 / cells;
  for (std::size_t k = n; k > 0; --k) {
    TipLevel& t = tables_[k];
    const ChainStep& joint = form_.steps[k - 1];
    t.arc = joint.prismatic ? fixed_grid(angle) : arc_grid(joint.lower, joint.upper, angle);
    double wider = t.arc.intervals > 0 ? (1 + 1e-12) / std::cos(t.arc.spacing / 2) : 1;
    if (k < n) {
      const double along_chord = t.arc.full ? 1 : (1 + 1e-12) / std::cos(t.arc.node_spacing / 2);
      at.radius *= along_chord;
      set_nodes(t, at, step, cells);
      // Nodes further away than a cell from all points that are looked up have no influence.
      reach = reach * along_chord + std::hypot(t.radius_spacing, t.height_spacing);
    }
    Cylinder swept = at;
    swept.radius *= wider;
    reach = (reach * wider + (reaches_[k - 1] - reaches_[k])) * (1 + 1e-12);
    at = image(swept, joint, reach, 1e-6 * reaches_[0]);
  }
  scale_ *= std::max(1.0, reach);
}

void TipRecursion::add_forms() {
  for (const DirectedError& e : form_.errors) {
    double whole = 0;
    const bool near = e.last - e.first <= 1;
    const auto share = [&](Eigen::Index k) {
      const double reach = form_.steps[k].prismatic ? 1 : reaches_[static_cast<std::size_t>(k) + 1];
      return std::abs(e.of_joints[k]) * std::max(reach, 1e-3 * reaches_[0]);
    };
    for (Eigen::Index k = e.first; k <= e.last; ++k) whole += share(k);
    for (Eigen::Index k = e.first; k <= e.last; ++k) {
      if (e.of_joints[k] == 0 || (near && k != e.first)) continue;
      const auto joint = static_cast<std::size_t>(k);
      Eigen::Matrix3d a = Eigen::Matrix3d::Zero();
      Eigen::Vector3d b = Eigen::Vector3d::Zero();
      const auto add = [&](double factor, bool prismatic, const Eigen::Vector3d& z,
                           const Eigen::Vector3d& origin) {
        if (prismatic) {
          b += factor * z;
        } else {
          a += factor * cross_matrix(z);
          b -= factor * z.cross(origin);
        }
      };
      add(e.of_joints[k], form_.steps[joint].prismatic, Eigen::Vector3d::UnitZ(), Eigen::Vector3d::Zero());
      if (near && e.last > k)
        add(e.of_joints[k + 1], form_.steps[joint + 1].prismatic, form_.steps[joint + 1].rotation.col(2),
            form_.steps[joint + 1].translation);
      add_form(tables_[joint + 1].view, a, b, near ? e.variance : e.variance * whole / share(k));
    }
  }
  for (TipLevel& t : tables_) t.view.c += rounding_of_form * scale_ * scale_;
}

/// M_k at the nodes of one circle, from samples of G_(k-1).
void TipRecursion::maxima(std::size_t k, double r, double z, double* values,
                          std::vector<double>& memory) const {
  const TipLevel& t = tables_[k];
  const ChainStep& joint = form_.steps[k - 1];
  const ArcGrid& arc = t.arc;
  const std::size_t samples = joint.prismatic ? 2 * arc.nodes : arc.sample_cos.size();
  memory.resize(5 * samples);
  double *x = memory.data(), *y = x + samples, *w = y + samples, *at_samples = w + samples,
         *at_middles = at_samples + samples;
  const auto evaluate = [&](double radius, const double* cosine, const double* sine, const double* shift,
                            double* out, std::size_t count) {
    const Eigen::Matrix3d& m = joint.rotation;
    const Eigen::Vector3d& o = joint.translation;
    for (std::size_t i = 0; i < count; ++i) {
      const double c = radius * cosine[i], s = radius * sine[i], h = z + (shift ? *shift : 0);
      x[i] = o[0] + (m(0, 0) * c + m(0, 1) * s + m(0, 2) * h);
      y[i] = o[1] + (m(1, 0) * c + m(1, 1) * s + m(1, 2) * h);
      w[i] = o[2] + (m(2, 0) * c + m(2, 1) * s + m(2, 2) * h);
    }
    kernels_.evaluate(tables_[k - 1].view, x, y, w, out, count);
  };
  if (joint.prismatic) {
    evaluate(r, arc.node_cos.data(), arc.node_sin.data(), &joint.lower, at_samples, arc.nodes);
    evaluate(r, arc.node_cos.data(), arc.node_sin.data(), &joint.upper, at_middles, arc.nodes);
    for (std::size_t j = 0; j < arc.nodes; ++j) values[j] = std::max(at_samples[j], at_middles[j]);
    return;
  }
  const double around = r / std::cos(arc.spacing / 2);
  evaluate(around, arc.middle_cos.data(), arc.middle_sin.data(), nullptr, at_middles, samples);
  if (arc.full) {
    values[0] = *std::max_element(at_middles, at_middles + samples);
    return;
  }
  evaluate(r, arc.sample_cos.data(), arc.sample_sin.data(), nullptr, at_samples, samples);
  for (std::size_t j = 0; j < arc.nodes; ++j)
    values[j] = std::max(at_samples[arc.first(j)], at_samples[arc.first(j) + arc.intervals]);
  if (arc.intervals == 0) return;
  const std::size_t last = arc.first(arc.nodes - 1) + arc.intervals;
  sliding_maximum(at_middles, last, arc.intervals, 1, x);
  for (std::size_t j = 0; j < arc.nodes; ++j) values[j] = std::max(values[j], at_middles[arc.first(j)]);
}

void TipRecursion::fill(std::size_t k) {
  TipLevel& t = tables_[k];
  const double allowance = tip_rounding * scale_;
  if (k == form_.size()) {
    std::vector<double> memory, row(t.arc.nodes);
    const Eigen::Vector3d p = form_.tip.translation();
    maxima(k, p.head<2>().norm(), p.z(), row.data(), memory);
    of_tip_ = row[0] + allowance;
    return;
  }
  TipTable& v = t.view;
  t.values.resize(v.heights * v.radii * v.columns);
  parallel_for(v.heights, 0, [&](std::size_t h) { fill_rows(k, h); });
  v.values = t.values.data();
}

void TipRecursion::fill_rows(std::size_t k, std::size_t height) {
  TipLevel& t = tables_[k];
  const double allowance = tip_rounding * scale_;
  std::vector<double> memory;
  for (std::size_t i = 0; i < t.view.radii; ++i) {
    double* row = t.values.data() + (height * t.view.radii + i) * t.view.columns;
    maxima(k, static_cast<double>(i) * t.radius_spacing,
           t.view.lowest + static_cast<double>(height) * t.height_spacing, row, memory);
    for (std::size_t j = 0; j < t.arc.nodes; ++j) row[j] += allowance;
    if (t.view.columns > 1) row[t.arc.nodes] = row[0];
  }
}

}  // namespace

double position_sigma_bound(const ChainForm& form, double cells) { return TipRecursion(form, cells)(); }

}  // namespace qerr
