#include "bound/proven/figure_model.hpp"

#include <algorithm>
#include <cmath>

#include "bound/figure_column.hpp"
#include "kinematics/sampler.hpp"
#include "qerr/bound/workspace.hpp"
#include "qerr/core/error.hpp"

namespace qerr {

namespace {

Error not_known(const std::string& what, const std::string& remedy) {
  return Error(Fault{{}, "requirements", what + ": its maximum cannot be proven", "", remedy});
}

/// Encoders of the resolutions times a factor each, that round to nearest.
void scale_encoders(OperationalModel& model, const Eigen::VectorXd& factors) {
  for (std::size_t i = 0; i < model.transmission.encoders.size(); ++i) {
    Encoder& encoder = model.transmission.encoders[i];
    encoder.resolution *= factors[static_cast<Eigen::Index>(i)];
    encoder.rounding = Rounding::nearest;
  }
}

/// @param length  whose largest length of displaced origins, mean included, is multiplied by ||H||_1
/// (signal_errors.hpp)
void set_worst_case(OperationalModel& model, const Norms& norms, bool length) {
  const Eigen::VectorXd means = mean_errors(model.transmission);
  scale_encoders(model, Eigen::VectorXd::Constant(means.size(), norms.l1.upper));
  for (IndependentError& s : model.sources) {
    s.half_width *= norms.l1.upper;
    s.mean *= length && s.where == IndependentError::Where::origin ? norms.l1.upper : norms.dc_gain;
  }
  for (Eigen::Index i = 0; i < means.size(); ++i) {
    if (means[i] == 0 || norms.dc_gain == 0) continue;
    IndependentError bias{IndependentError::Where::encoder, static_cast<std::size_t>(i)};
    bias.mean = norms.dc_gain * means[i];
    model.sources.push_back(std::move(bias));
  }
}

}  // namespace

OperationalModel figure_model(const OperationalModel& position, const std::vector<Norms>& filters,
                              const std::vector<Eigen::VectorXd>& noise_in_motion, const Figure& figure) {
  OperationalModel model = position;
  if (figure.filter < 0) return model;
  const auto f = static_cast<std::size_t>(figure.filter);
  if (model.along_motion) model.along_motion->tip = model.along_motion->filtered[f];
  if (!is_sigma(figure.bound)) {
    set_worst_case(model, filters[f], is_length(all_signals(model)[figure.signal]));
    return model;
  }
  if (!sigma_is_known(model.sources, f))
    throw not_known(
        "sigma behind a filter is not known: it depends on the motion, of which nothing is stated",
        "add `motion:`, or velocity to the joints' <limit> in the URDF; or ask for worst_case");
  const bool in_motion = figure.bound == Bound::sigma_in_motion;
  if (in_motion && !is_known(noise_in_motion, f))
    throw not_known("sigma in motion is not known", "ask for sigma, or for worst_case");
  const auto count = static_cast<Eigen::Index>(model.transmission.encoders.size());
  const Eigen::VectorXd ratios = sigma_ratios(model.sources, f, filters[f].h2, in_motion);
  for (std::size_t i = 0; i < model.sources.size(); ++i)
    model.sources[i].sigma *= ratios[static_cast<Eigen::Index>(i)];
  scale_encoders(model, in_motion ? Eigen::VectorXd(std::sqrt(12.0) * noise_in_motion[f])
                                  : Eigen::VectorXd::Constant(count, filters[f].h2));
  return model;
}

FigureValues::FigureValues(const OperationalModel& model, const std::vector<Norms>& filters,
                           const std::vector<Eigen::VectorXd>& noise_in_motion)
    : filters_(filters),
      errors_(model,
              {.rigorous = true, .shares = false, .filters = filters, .noise_in_motion = noise_in_motion}),
      joints_(model.chain.independent.size()),
      q_(joints_ * batch_size),
      figures_(errors_.figures().count * batch_size) {}

double FigureValues::value(const Figure& figure, std::size_t configuration) const {
  const FigureColumn column = figure_column(figure, filters_, errors_.figures());
  return column.factor * figures_[column.figure * batch_size + configuration];
}

std::vector<std::vector<double>> FigureValues::operator()(
    const std::vector<Figure>& figures, const std::vector<Eigen::VectorXd>& configurations) {
  std::vector<std::vector<double>> values(figures.size());
  for (std::size_t first = 0; first < configurations.size(); first += batch_size) {
    const std::size_t count = std::min<std::size_t>(batch_size, configurations.size() - first);
    for (std::size_t i = 0; i < batch_size; ++i)
      for (std::size_t j = 0; j < joints_; ++j)
        q_[j * batch_size + i] = configurations[first + std::min(i, count - 1)][static_cast<Eigen::Index>(j)];
    errors_(q_.data(), figures_.data());
    for (std::size_t f = 0; f < figures.size(); ++f)
      for (std::size_t i = 0; i < count; ++i) values[f].push_back(value(figures[f], i));
  }
  return values;
}

std::vector<std::vector<Eigen::VectorXd>> FigureValues::best_samples(const std::vector<Figure>& figures,
                                                                     const std::vector<Limits>& ranges) {
  constexpr std::uint64_t blocks = 64, block = 1024;
  const Configurations points{.method = SamplingMethod::sobol, .count = blocks * block, .ranges = ranges};
  Sampler sampler(points);
  std::vector<std::vector<Eigen::VectorXd>> best(figures.size());
  std::vector<double> largest(figures.size());
  for (std::uint64_t first = 0; first < blocks * block; first += batch_size) {
    sampler(first, q_.data());
    errors_(q_.data(), figures_.data());
    const bool fresh = first % block == 0;
    for (std::size_t f = 0; f < figures.size(); ++f)
      for (std::size_t i = 0; i < batch_size; ++i) {
        const double here = value(figures[f], i);
        if (fresh && i == 0)
          best[f].emplace_back(static_cast<Eigen::Index>(joints_));
        else if (!(here > largest[f]))
          continue;
        largest[f] = here;
        for (std::size_t j = 0; j < joints_; ++j)
          best[f].back()[static_cast<Eigen::Index>(j)] = q_[j * batch_size + i];
      }
  }
  return best;
}

}  // namespace qerr
