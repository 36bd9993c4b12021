#include "bound/length_errors.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdint>

#include "bound/linearization_remainder.hpp"

namespace qerr {

namespace {

constexpr Eigen::Index most_tried = 12;

double square_from(const Eigen::Vector3d& mean, const Eigen::Vector3d& corner) {
  return corner.squaredNorm() + mean.squaredNorm() + 2 * std::abs(mean.dot(corner));  // of both +-corner
}

double largest_of_all(const Eigen::Vector3d& mean, const Eigen::Matrix3Xd& generators) {
  const Eigen::Index n = generators.cols();
  Eigen::Vector3d corner = generators.rowwise().sum();
  double largest = square_from(mean, corner);
  std::uint64_t signs = 0;
  for (std::uint64_t k = 1; k < (std::uint64_t{1} << (n - 1)); ++k) {
    const auto flipped = static_cast<Eigen::Index>(__builtin_ctzll(k));  // Gray code: one sign a step
    signs ^= std::uint64_t{1} << flipped;
    corner += (signs >> flipped & 1 ? -2 : 2) * generators.col(flipped);
    largest = std::max(largest, square_from(mean, corner));
  }
  return largest;
}

/// The largest over the vertices at the ends of the edges along g_i of the face whose normal is `normal`.
double largest_at_edge(const Eigen::Vector3d& mean, const Eigen::Matrix3Xd& generators, Eigen::Index i,
                       const Eigen::Vector3d& normal) {
  constexpr double in_face = 1e-12;
  const Eigen::Vector3d along = generators.col(i), across = normal.cross(along);
  double largest = 0;
  for (const double side : {-1, 1})
    for (const double end : {-1, 1}) {
      Eigen::Vector3d corner = Eigen::Vector3d::Zero();
      for (Eigen::Index k = 0; k < generators.cols(); ++k) {
        const Eigen::Vector3d g = generators.col(k);
        const double off = normal.dot(g), aside = side * across.dot(g);
        const double sign = std::abs(off) > in_face * normal.norm() * g.norm()     ? off
                            : std::abs(aside) > in_face * across.norm() * g.norm() ? aside
                                                                                   : end * along.dot(g);
        corner += sign < 0 ? Eigen::Vector3d(-g) : g;
      }
      largest = std::max(largest, square_from(mean, corner));
    }
  return largest;
}

double largest_vertex(const Eigen::Vector3d& mean, const Eigen::Matrix3Xd& generators) {
  double largest = 0;
  Eigen::Index longest = 0;
  generators.colwise().squaredNorm().maxCoeff(&longest);
  bool parallel = true;
  for (Eigen::Index i = 0; i < generators.cols(); ++i)
    for (Eigen::Index j = 0; j < generators.cols(); ++j) {
      const Eigen::Vector3d a = generators.col(i), b = generators.col(j), normal = a.cross(b);
      if (!(normal.norm() > 1e-12 * a.norm() * b.norm())) continue;
      parallel = false;
      largest = std::max(largest, largest_at_edge(mean, generators, i, normal));
    }
  if (!parallel) return largest;
  Eigen::Vector3d corner = Eigen::Vector3d::Zero();
  for (const auto& g : generators.colwise())
    corner += g.dot(generators.col(longest)) < 0 ? Eigen::Vector3d(-g) : Eigen::Vector3d(g);
  return square_from(mean, corner);
}

}  // namespace

double largest_corner(const Eigen::Vector3d& mean, const Eigen::Matrix3Xd& generators) {
  if (generators.cols() == 0) return mean.norm();
  return std::sqrt(generators.cols() <= most_tried ? largest_of_all(mean, generators)
                                                   : largest_vertex(mean, generators));
}

namespace {

std::size_t index_of(const std::vector<Coordinate>& list, Coordinate c) {
  return static_cast<std::size_t>(std::find(list.begin(), list.end(), c) - list.begin());
}

double length_at(const Eigen::VectorXd& values, const std::array<std::size_t, 3>& components) {
  double sum = 0;
  for (const std::size_t c : components) sum += std::pow(values[static_cast<Eigen::Index>(c)], 2);
  return std::sqrt(sum);
}

}  // namespace

LengthErrors::LengthErrors(const OperationalModel& model, const ErrorFigures& requested,
                           const FigureLayout& layout, InstructionSet set)
    : layout_(layout),
      filters_(requested.filters),
      rigorous_(requested.rigorous),
      own_worst_(layout.filtered_sigma > layout.filtered_worst),
      own_sigma_(layout.in_motion > layout.filtered_sigma),
      jacobian_(model.chain, set),
      columns_(6 * model.chain.joints.size() * batch_size),
      joints_(model.chain.joints.size()),
      components_(model.coordinates.size()) {
  const LinearizationRemainder r = linearization_remainder(model.chain, joint_error(model).worst_case);
  rotation_remainder_ = r.rotation;
  rotation_angle_ = r.rotation_angle;
  for (std::size_t f = 0; f < filters_.size(); ++f)
    in_motion_.push_back(f < requested.noise_in_motion.size() && requested.noise_in_motion[f].size() > 0);
  double shift = 0;  // of origins
  for (const IndependentError& e : independent_errors(model))
    if (e.where == IndependentError::Where::origin)
      shift += std::abs(e.mean) + e.half_width;
    else
      add_generator(model, e);
  for (const Coordinate c : model.lengths) {
    const Coordinate first = first_component(c);
    Length length{static_cast<std::size_t>(first), {}};
    for (std::size_t k = 0; k < 3; ++k)
      length.components[k] =
          index_of(model.coordinates, static_cast<Coordinate>(static_cast<std::size_t>(first) + k));
    const double of_origins = c == Coordinate::xyz ? shift : 0;
    length.added = of_origins;
    for (const Norms& norms : filters_) length.added_behind.push_back(norms.l1.upper * of_origins);
    if (model.along_motion) {
      length.added += length_at(model.along_motion->tip.peak, length.components);
      for (std::size_t f = 0; f < filters_.size(); ++f)
        length.added_behind[f] += length_at(model.along_motion->filtered[f].peak, length.components);
    }
    lengths_.push_back(length);
  }
}

/// Errors along the same direction of the joints have one corner: their half widths add.
void LengthErrors::add_generator(const OperationalModel& model, const IndependentError& error) {
  const Eigen::VectorXd of_independent = moved_joints(model.transmission, error);
  biased_ = biased_ || error.mean != 0;
  Eigen::VectorXd of_joints(static_cast<Eigen::Index>(joints_));
  for (std::size_t k = 0; k < joints_; ++k) {
    const ChainJoint& joint = model.chain.joints[k];
    of_joints[static_cast<Eigen::Index>(k)] =
        joint.multiplier * of_independent[static_cast<Eigen::Index>(joint.coordinate)];
  }
  for (Generator& g : generators_)
    if (g.of_joints == of_joints) {
      g.half_width += error.half_width;
      g.mean += error.mean;
      return;
    }
  generators_.push_back({std::move(of_joints), error.half_width, error.mean});
}

void LengthErrors::set_worst(const Length& length, std::size_t index, std::size_t i, double* figures) const {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  Eigen::Matrix3Xd corners(3, static_cast<Eigen::Index>(generators_.size()));
  for (std::size_t g = 0; g < generators_.size(); ++g) {
    Eigen::Vector3d along = Eigen::Vector3d::Zero();
    for (std::size_t k = 0; k < joints_; ++k)
      for (std::size_t row = 0; row < 3; ++row)
        along[static_cast<Eigen::Index>(row)] += columns_[(6 * k + length.first + row) * batch_size + i] *
                                                 generators_[g].of_joints[static_cast<Eigen::Index>(k)];
    corners.col(static_cast<Eigen::Index>(g)) = generators_[g].half_width * along;
    mean += generators_[g].mean * along;
  }
  const double linear = largest_corner(mean, corners), worst = linear + length.added;
  figures[(layout_.worst_case + index) * batch_size + i] = worst;
  if (rigorous_) {
    // The remainder of a position is that of its components: it bounds a length.
    const std::size_t x = length.components[0];
    const double remainder =
        figures[(layout_.rigorous + x) * batch_size + i] - figures[(layout_.worst_case + x) * batch_size + i];
    figures[(layout_.rigorous + index) * batch_size + i] =
        length.first == 0 ? worst + remainder
                          : std::min(linear + rotation_remainder_, rotation_angle_) + length.added;
  }
  if (!own_worst_) return;
  for (std::size_t f = 0; f < filters_.size(); ++f) {
    const Norms& norms = filters_[f];
    const double behind =
        biased_ ? largest_corner(norms.dc_gain * mean, norms.l1.upper * corners) : norms.l1.upper * linear;
    figures[(layout_.filtered_worst + f * layout_.coordinates + index) * batch_size + i] =
        behind + length.added_behind[f];
  }
}

/// @param block  of figures: index of the first coordinate's
double LengthErrors::root_of_sum(const Length& length, std::size_t block, const double* figures) const {
  double sum = 0;
  for (const std::size_t c : length.components) sum += std::pow(figures[(block + c) * batch_size], 2);
  return std::sqrt(sum);
}

void LengthErrors::set_sigmas(const Length& length, std::size_t index, std::size_t i, double* figures) const {
  const auto set = [&](std::size_t block) {
    figures[(block + index) * batch_size + i] = root_of_sum(length, block, figures + i);
  };
  set(layout_.sigma);
  for (std::size_t f = 0; f < filters_.size(); ++f) {
    if (own_sigma_) set(layout_.filtered_sigma + f * layout_.coordinates);
    if (in_motion_[f]) set(layout_.in_motion + f * layout_.coordinates);
  }
}

void LengthErrors::operator()(const double* q, double* figures) {
  jacobian_(q, columns_.data());
  for (std::size_t l = 0; l < lengths_.size(); ++l)
    for (std::size_t i = 0; i < batch_size; ++i) {
      set_sigmas(lengths_[l], components_ + l, i, figures);
      set_worst(lengths_[l], components_ + l, i, figures);
    }
}

}  // namespace qerr
