#include "bound/proven/sampled_starts.hpp"

#include <algorithm>

#include "bound/figure_column.hpp"
#include "kinematics/sampler.hpp"

namespace qerr {

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
