#pragma once

#include <Eigen/Geometry>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <vector>

#include "qerr/bound/operational_error.hpp"
#include "qerr/simulate/simulate.hpp"

/// A straightforward simulation with Eigen: sample by sample, with fixed sizes where possible, transforms and
/// AngleAxis, without allocation in the loop. It computes the results of `simulate` for an ideal robot along
/// sines.
namespace plain {

using namespace qerr;

inline constexpr int most_joints = 16;
using Joints = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, most_joints, 1>;
using Columns = Eigen::Matrix<double, 6, Eigen::Dynamic, 0, 6, most_joints>;

inline Eigen::Isometry3d pose(const Chain& chain, const Joints& q) {
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  for (std::size_t k = 0; k < chain.joints.size(); ++k) {
    pose = pose * chain.joints[k].origin;
    pose.rotate(Eigen::AngleAxisd(q[static_cast<Eigen::Index>(k)], chain.joints[k].axis));
  }
  return pose * chain.tip_offset;
}

inline Columns jacobian(const Chain& chain, const Joints& q, Eigen::Isometry3d& pose) {
  Columns j(6, q.size());
  pose = Eigen::Isometry3d::Identity();
  for (Eigen::Index k = 0; k < q.size(); ++k) {
    const ChainJoint& joint = chain.joints[static_cast<std::size_t>(k)];
    pose = pose * joint.origin;
    j.col(k).head<3>() = pose.translation();
    j.col(k).tail<3>() = pose.linear() * joint.axis;
    pose.rotate(Eigen::AngleAxisd(q[k], joint.axis));
  }
  pose = pose * chain.tip_offset;
  for (Eigen::Index k = 0; k < q.size(); ++k) {
    const Eigen::Vector3d axis = j.col(k).tail<3>(), arm = pose.translation() - j.col(k).head<3>();
    j.col(k).head<3>() = axis.cross(arm);
  }
  return j;
}

inline Eigen::Vector3d rotation_vector(const Eigen::Matrix3d& r) {
  const Eigen::Vector3d twice_sine{r(2, 1) - r(1, 2), r(0, 2) - r(2, 0), r(1, 0) - r(0, 1)};
  const double sine = 0.5 * twice_sine.norm();
  if (sine < 1e-300) return Eigen::Vector3d::Zero();
  return twice_sine * (0.5 * std::atan2(sine, 0.5 * (r.trace() - 1)) / sine);
}

/// A filter on one channel: sections by trapezoidal integrators.
class ChannelFilter {
 public:
  explicit ChannelFilter(const Filter& filter) : gain_(static_cast<double>(filter.gain)) {
    const auto plain = [](auto c) { return static_cast<double>(c); };
    for (const Section& s : filter.sections) {
      const double a01 = plain(s.a[0]) + plain(s.a[1]);
      sections_.push_back({plain(s.a[2]) != 0, plain(s.b[0]), plain(s.b[1]), plain(s.b[2]), plain(s.a[0]),
                           a01, 1 / (a01 + plain(s.a[2]))});
    }
  }
  void settle(double x) {
    x *= gain_;
    for (State& s : sections_) {
      (s.second ? s.s2 : s.s1) = x / s.a0;
      x *= s.b0 / s.a0;
    }
  }
  double step(double x) {
    x *= gain_;
    for (State& s : sections_) {
      if (s.second) {
        const double high = (x - s.a01 * s.s1 - s.a0 * s.s2) * s.inverse, band = high + s.s1,
                     low = s.s2 + band;
        x = s.b0 * low + s.b1 * band + s.b2 * high;
        s.s1 = band + high;
        s.s2 = low + band;
      } else {
        const double high = (x - s.a0 * s.s1) * s.inverse, low = s.s1 + high;
        x = s.b0 * low + s.b1 * high;
        s.s1 = low + high;
      }
    }
    return x;
  }

 private:
  struct State {
    bool second;
    double b0, b1, b2, a0, a01, inverse;
    double s1 = 0, s2 = 0;
  };
  std::vector<State> sections_;
  double gain_;
};

/// Mean, sum of squared deviations and peak of one channel (Welford).
struct Moments {
  double mean = 0, squares = 0, peak = 0;
  void add(double value, double count) {
    const double off = value - mean;
    mean += off / count;
    squares += off * (value - mean);
    peak = std::max(peak, std::abs(value));
  }
};

struct Output {
  std::vector<ChannelFilter> filters;  // by channel; empty: the position itself
  std::vector<Moments> moments;
  double count = 0;
};

/// Figures of each output and coordinate over all runs, as in SimulatedSignal; the bound along the path, and
/// the root mean square of J Delta.
struct Signal {
  double sigma = 0, mean = 0, peak = 0, linear = 0, parts = 0;
};
struct Result {
  std::vector<std::vector<Signal>> signals;
  Eigen::VectorXd rigorous;
  Eigen::MatrixXd path_squares;
};

class Simulator {
 public:
  Simulator(const OperationalModel& model, const std::vector<Filter>& filters, const Motion& motion,
            std::uint64_t settling)
      : model_(model), filters_(filters), motion_(motion), settling_(settling) {
    steps_ = resolutions(model.transmission);
    const Eigen::VectorXd h = 0.5 * steps_;
    remainder_ = linearization_remainder(model.chain, h);
    samples_ = static_cast<std::uint64_t>(std::floor(motion.duration * motion.sample_rate + 0.5));
    const auto m = static_cast<Eigen::Index>(model.coordinates.size());
    result_.rigorous = Eigen::VectorXd::Zero(m);
    result_.path_squares = Eigen::MatrixXd::Zero(m, steps_.size());
  }

  /// @param displacements  of the encoder coordinates, one for each run
  Result operator()(const std::vector<Eigen::VectorXd>& displacements) {
    const std::size_t m = model_.coordinates.size(),
                      channels = m * (2 + static_cast<std::size_t>(steps_.size()));
    std::vector<std::vector<Moments>> pooled(filters_.size() + 1, std::vector<Moments>(channels));
    double count = 0;
    for (const Eigen::VectorXd& displacement : displacements) {
      std::vector<Output> outputs = run(displacement);
      const double n = outputs[0].count;
      for (std::size_t o = 0; o < outputs.size(); ++o)
        for (std::size_t c = 0; c < channels; ++c) {
          Moments &all = pooled[o][c], &one = outputs[o].moments[c];
          const double off = one.mean - all.mean;
          all.squares += one.squares + off * off * count * n / (count + n);
          all.mean += off * n / (count + n);
          all.peak = std::max(all.peak, one.peak);
        }
      count += n;
    }
    for (const auto& moments : pooled) {
      auto& row = result_.signals.emplace_back(m);
      for (std::size_t c = 0; c < m; ++c) {
        double parts = 0;
        for (std::size_t e = 2; e * m < channels; ++e) parts += moments[e * m + c].squares / count;
        row[c] = {std::sqrt(moments[c].squares / count), moments[c].mean, moments[c].peak,
                  std::sqrt(moments[m + c].squares / count), std::sqrt(parts)};
      }
    }
    result_.path_squares /= count;
    return result_;
  }

 private:
  std::vector<Output> run(const Eigen::VectorXd& displacement) {
    const Eigen::Index n = steps_.size();
    const std::size_t m = model_.coordinates.size(), channels = m * (2 + static_cast<std::size_t>(n));
    std::vector<Output> outputs(filters_.size() + 1);
    for (std::size_t o = 0; o < outputs.size(); ++o) {
      outputs[o].moments.resize(channels);
      if (o > 0) outputs[o].filters.assign(channels, ChannelFilter(filters_[o - 1]));
    }
    std::vector<double> inputs(channels);
    Joints truth(n), estimate(n), missed(n);
    Eigen::Isometry3d tip;
    for (std::uint64_t k = 0; k < samples_; ++k) {
      const double time = static_cast<double>(k) / motion_.sample_rate;
      for (Eigen::Index i = 0; i < n; ++i) {
        truth[i] = position(static_cast<std::size_t>(i), time) + displacement[i];
        estimate[i] = std::floor(truth[i] / steps_[i] + 0.5) * steps_[i];
        missed[i] = (estimate[i] - truth[i]) / steps_[i];
      }
      const Columns j = jacobian(model_.chain, truth, tip);
      const Eigen::Isometry3d seen = pose(model_.chain, estimate);
      Eigen::Matrix<double, 6, 1> error;
      error << seen.translation() - tip.translation(),
          rotation_vector(seen.linear() * tip.linear().transpose());
      double of_position = remainder_.position;
      for (Eigen::Index e = 0; e < n; ++e)
        of_position += remainder_.per_column[e] * j.col(e).head<3>().norm();
      const bool counts = k >= settling_;
      for (std::size_t c = 0; c < m; ++c) {
        const auto row = static_cast<Eigen::Index>(c), of = static_cast<Eigen::Index>(model_.coordinates[c]);
        double linear = 0, worst = 0;
        for (Eigen::Index e = 0; e < n; ++e) {
          const double weighted = j(of, e) * steps_[e], part = weighted * missed[e];
          inputs[(2 + static_cast<std::size_t>(e)) * m + c] = part;
          linear += part;
          worst += 0.5 * std::abs(weighted);
          if (counts) result_.path_squares(row, e) += weighted * weighted;
        }
        inputs[c] = error[of];
        inputs[m + c] = linear;
        const double bound =
            of < 3 ? worst + of_position : std::min(worst + remainder_.rotation, remainder_.rotation_angle);
        result_.rigorous[row] = std::max(result_.rigorous[row], bound);
      }
      for (Output& output : outputs) {
        if (counts) output.count += 1;
        for (std::size_t c = 0; c < channels; ++c) {
          double value = inputs[c];
          if (!output.filters.empty()) {
            if (k == 0) output.filters[c].settle(value);
            value = output.filters[c].step(value);
          }
          if (counts) output.moments[c].add(value, output.count);
        }
      }
    }
    return outputs;
  }

  double position(std::size_t i, double time) const {
    const JointMotion& joint = motion_.joints[i];
    double q = joint.center + joint.velocity * time;
    for (const Sine& sine : joint.sines)
      q += sine.amplitude * std::sin(2 * std::numbers::pi * sine.frequency * time + sine.phase);
    return q;
  }

  const OperationalModel& model_;
  const std::vector<Filter>& filters_;
  const Motion& motion_;
  std::uint64_t settling_, samples_ = 0;
  Eigen::VectorXd steps_;
  LinearizationRemainder remainder_;
  Result result_;
};

}  // namespace plain
