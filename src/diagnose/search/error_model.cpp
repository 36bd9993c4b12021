#include "diagnose/search/error_model.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "diagnose/record/with_effects.hpp"
#include "qerr/effect/effect_kind.hpp"

namespace qerr {

namespace {

/// The variance of the samples is known from quantization and noise; a remainder may be this much below it by
/// chance and by the correlation of the roundings.
constexpr double least_variance = 0.9;

/// Ratio of a residual to that of rounding and noise up to which nothing worth mentioning is left.
constexpr double complete = 1.3;

bool is_of_lines(const Term& t) { return t.named() && effect_kind(t.effect.type).stage == Stage::line; }

}  // namespace

ErrorModel::ErrorModel(const Evidence& record, const ErrorSamples& samples, std::vector<Candidate> candidates,
                       const std::vector<Event>& events, const std::vector<Effect>& clocks,
                       const ExcessVariance& excess)
    : record_(&record),
      samples_(&samples),
      excess_(excess),
      candidates_(std::move(candidates)),
      base_(record.encoder.zero_known ? 0 : 1) {
  list_groups();
  weigh(events, clocks);
  const Eigen::MatrixXd base = Eigen::MatrixXd::Ones(samples.size(), base_);
  Columns columns = columns_of(base);
  for (const Candidate& c : candidates_)
    for (Eigen::Index i = 0; i < c.term->size(); ++i) columns.push_back(c.term->columns.col(i).data());
  linear_.emplace(columns, samples.error.matrix(), weight_.matrix(), base_);
  floor_ = least_variance * (samples.variance * weight_).sum() / linear_->rows();
}

double ErrorModel::periods(std::size_t i) const {
  const Term& t = term(i);
  return t.named() && t.harmonic ? periods_covered(t.effect, sampled())
                                 : std::numeric_limits<double>::infinity();
}

bool ErrorModel::is_arc(std::size_t i) const {
  return periods(i) < distinct_periods && term(i).effect.number("order") > 1;
}

void ErrorModel::list_groups() {
  Eigen::Index count = base_;
  std::vector<std::string> families;
  for (const Candidate& c : candidates_) {
    ColumnGroup g;
    g.first = count, g.count = c.term->size();
    g.positive = c.term->positive, g.least = c.least, g.most = c.most;
    const auto known = std::find(families.begin(), families.end(), c.family);
    g.family = static_cast<int>(known - families.begin());
    if (known == families.end()) families.push_back(c.family);
    groups_.push_back(g);
    count += g.count;
  }
}

Eigen::ArrayXd ErrorModel::weights(const ErrorSamples& s) const {
  const double immaterial = std::pow(material * record_->step(), 2);
  return (s.variance + excess_.at(s.sampling.evidence).max(immaterial)).inverse();
}

void ErrorModel::weigh(const std::vector<Event>& events, const std::vector<Effect>& clocks) {
  weight_ = weights(*samples_);
  if (!sampled().ordered) return;
  // A sample that a step divides belongs to neither side.
  for (const Event& event : events)
    weight_ = ((sampled().time - event.time).abs() < 2 * sampled().interval).select(0.0, weight_);
  // Nor does one at which the side of a play is unknown.
  if ((sampled().direction.abs() == 1).any()) weight_ = (sampled().direction.abs() == 1).select(weight_, 0.0);
  const auto within = reads_within(*record_, clocks, sampled().time);
  if (static_cast<double>(within.count()) >= least_part_within * static_cast<double>(samples_->size()))
    weight_ = within.select(weight_, 0.0);
}

void ErrorModel::price(double independent, double worth, double worth_of_shapes) {
  const double least = worth * worth * weight_.sum(),
               other = worth_of_shapes * worth_of_shapes * weight_.sum();
  // A shape that the catalogue does not have must be better than a named one by what is material, as must an
  // arc; a table better than as many sines as have its number of coefficients. What repeats with every line
  // is none of the deviations of a larger error from its name, which are slow.
  const double of_lines = std::pow(std::min(worth, material * sampled().step()), 2) * weight_.sum();
  for (std::size_t i = 0; i < groups_.size(); ++i) {
    const auto count = static_cast<double>(groups_[i].count);
    groups_[i].price = count * std::log(std::max(independent, 2.0)) +
                       2 * std::log(std::max(1.0, candidates_[i].alternatives));
    groups_[i].least_gain = is_table(i)                     ? std::max(2.0, 0.5 * count) * other
                            : is_of_lines(term(i))          ? of_lines
                            : term(i).named() && !is_arc(i) ? least
                                                            : 2 * other;
  }
}

LinearModel::Set ErrorModel::search(const std::vector<LinearModel::Set>& starts, double independent) const {
  std::vector<LinearModel::Set> ends, seen;
  for (const LinearModel::Set& start : starts)
    ends.push_back(linear_->search(groups_, start, 0, independent, floor_, seen));
  return *std::min_element(ends.begin(), ends.end(),
                           [&](const LinearModel::Set& a, const LinearModel::Set& b) {
                             return criterion(a, independent) < criterion(b, independent);
                           });
}

double ErrorModel::criterion(const LinearModel::Set& set, double independent) const {
  return linear_->criterion(groups_, set, fit(set).rss, independent, floor_);
}

Eigen::MatrixXd ErrorModel::columns(const LinearModel::Set& set) const {
  Eigen::Index count = base_;
  for (const std::size_t g : set) count += groups_[g].count;
  Eigen::MatrixXd c(samples_->size(), count);
  c.leftCols(base_).setOnes();
  Eigen::Index at = base_;
  for (const std::size_t g : set) {
    c.middleCols(at, groups_[g].count) = term(g).columns.matrix();
    at += groups_[g].count;
  }
  return c;
}

Eigen::ArrayXd ErrorModel::residual(const LinearModel::Set& set, const LinearModel::Fit& f) const {
  return samples_->error - (columns(set) * f.coefficients).array();
}

Eigen::VectorXd ErrorModel::coefficients(const LinearModel::Set& set, const LinearModel::Fit& f,
                                         std::size_t position) const {
  Eigen::Index at = base_;
  for (std::size_t i = 0; i < position; ++i) at += groups_[set[i]].count;
  return f.coefficients.segment(at, groups_[set[position]].count);
}

double ErrorModel::gain(const Term& t, const Eigen::ArrayXd& residual) const {
  const Eigen::VectorXd constant = Eigen::VectorXd::Ones(residual.size());
  Columns columns{constant.data()};
  for (Eigen::Index i = 0; i < t.size(); ++i) columns.push_back(t.columns.col(i).data());
  const LinearModel linear(columns, residual.matrix(), weight_.matrix(), 1);
  // Below the rounding of a huge residual the difference may be negative, and a search for its maximum
  // endless.
  return std::max(0.0, linear.fit({}, {}).rss - linear.fit({{.first = 1, .count = t.size()}}, {0}).rss);
}

double ErrorModel::lost_without(const Choice& choice, std::size_t position) const {
  LinearModel::Set without = choice.chosen;
  without.erase(without.begin() + static_cast<std::ptrdiff_t>(position));
  return std::max(0.0, fit(without).rss - choice.fit.rss);
}

bool ErrorModel::is_complete(const LinearModel::Set& set) const {
  const Eigen::ArrayXd left = residual(set, fit(set));
  const double rounding = record_->step() * record_->step() / 12 + record_->path_noise * record_->path_noise;
  return mean_of_used(left.square() - samples_->variance) < (complete * complete - 1) * rounding;
}

double ErrorModel::mean_of_used(const Eigen::ArrayXd& x) const {
  return (weight_ > 0).select(x, 0.0).sum() / rows();
}

double ErrorModel::correlation() const { return 1 + mean_of_used(samples_->shared * weight_); }

double ErrorModel::scale(const Choice& choice) const {
  return std::max(choice.fit.rss / rows(), floor_) * choice.correlation;
}

}  // namespace qerr
