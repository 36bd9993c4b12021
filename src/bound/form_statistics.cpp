#include "bound/form_statistics.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "bound/joined_tally.hpp"

namespace qerr {

namespace {

constexpr float infinite = std::numeric_limits<float>::infinity();
/// Places of the sample that says where the order statistics lie.
constexpr std::size_t sample_blocks = 16, sample_size = sample_blocks * batch_size;
/// Standard deviations of a sampled rank, and further places for ranks at the ends: a rank outside is met
/// once in 1e4 forms, and found among all values then.
constexpr double deviations = 4, further = 2;
/// Floats below the smallest normal one are rounded by less than this.
constexpr double smallest = 0x1p-124;

float rounded_down(double x) { return std::nextafter(static_cast<float>(x), -infinite); }
float rounded_up(double x) { return std::nextafter(static_cast<float>(x), infinite); }

}  // namespace

FormStatistics::FormStatistics(const ColumnStatistics& s, std::size_t coordinate, bool squared)
    : s_(s), coordinate_(coordinate), squared_(squared), weights_(forms_per_tile * s.count_) {
  const double rounding = static_cast<double>(s.count_ + 3) * 0x1p-24;
  // The sums in double that values are compared with are rounded, too.
  error_ = rounding / (1 - rounding) + 1e-13;
}

void FormStatistics::evaluate(std::span<const ColumnForm> forms) {
  set_weights(forms);
  const bool screen = !s_.ranks_.empty() && !s_.constant_[coordinate_];
  if (screen) {
    set_bands(forms);
    scan();
  }
  ranked_of_ = nullptr;
  all_of_.form = nullptr;
  for (std::size_t f = 0; f < forms.size(); ++f) {
    finish(f, {&forms[f], false}, *forms[f].statistic);
    if (forms[f].rigorous) finish(f, {&forms[f], true}, *forms[f].rigorous);
  }
}

void FormStatistics::set_weights(std::span<const ColumnForm> forms) {
  std::fill(weights_.begin(), weights_.end(), 0.0f);
  units_.assign(forms.size(), 1);
  spreads_.assign(forms.size(), 0);
  const double scale = s_.scale_[coordinate_];
  for (std::size_t f = 0; f < forms.size(); ++f) {
    const double* const weights = forms[f].weights;
    const double own = power_to_unit(*std::max_element(weights, weights + s_.count_));
    for (std::size_t k = 0; k < s_.count_; ++k)
      weights_[f * s_.count_ + k] = static_cast<float>(weights[k] * own);
    units_[f] = 1 / (own * (squared_ ? scale * scale : scale));
    if (forms[f].rigorous && !forms[f].rotation) spreads_[f] = spread(forms[f], units_[f]);
  }
}

double FormStatistics::spread(const ColumnForm& form, double unit) const {
  double sum = 0;
  for (std::size_t j = 0; j < s_.mean_norm_.size(); ++j)
    sum +=
        form.remainder->per_column[static_cast<Eigen::Index>(j)] * (s_.largest_norm_[j] - s_.least_norm_[j]);
  return sum / unit * (1 + 1e-12);
}

/// An exact value t has a float v with |v - t| <= error t + smallest, and its figure lies in [t, t + spread]
/// above a constant. Figures of values outside of this range are certainly smaller, or larger.
FormStatistics::Range FormStatistics::ambiguous(double x, double spread) const {
  const double least = (x - smallest) / (1 + error_), most = (x + smallest) / (1 - error_);
  return {(least - spread) * (1 - error_) - smallest, (most + spread) * (1 + error_) + smallest};
}

std::vector<FormStatistics::Range> FormStatistics::bands_of(float* sample, double spread) const {
  const double last = sample_size - 1;
  struct Places {
    double lower, upper;
  };
  std::vector<Places> places;
  for (const std::uint64_t rank : s_.ranks_) {
    const double part = static_cast<double>(rank) / static_cast<double>(s_.configurations_ - 1);
    const double margin = deviations * std::sqrt(sample_size * part * (1 - part)) + further;
    const Places own{std::floor(part * last - margin), std::ceil(part * last + margin)};
    if (!places.empty() && own.lower <= places.back().upper)
      places.back().upper = std::max(places.back().upper, own.upper);
    else
      places.push_back(own);
  }
  std::vector<Range> bands;
  if (places.size() == 1 && places[0].lower > 0 && places[0].upper > last)
    std::nth_element(sample, sample + static_cast<std::ptrdiff_t>(places[0].lower), sample + sample_size);
  else
    std::sort(sample, sample + sample_size);
  for (const Places& p : places) {
    Range r{-infinite, infinite};
    if (p.lower >= 0) r.lower = ambiguous(sample[static_cast<std::size_t>(p.lower)], spread).lower;
    if (p.upper <= last) r.upper = ambiguous(sample[static_cast<std::size_t>(p.upper)], spread).upper;
    if (!bands.empty() && r.lower <= bands.back().upper)
      bands.back().upper = std::max(bands.back().upper, r.upper);
    else
      bands.push_back(r);
  }
  return bands;
}

void FormStatistics::set_bands(std::span<const ColumnForm> forms) {
  sample_.resize(forms_per_tile * sample_size);
  s_.kernels_.values(s_.block(coordinate_, squared_), sample_blocks, s_.count_, weights_.data(),
                     sample_.data());
  ranges_.resize(forms.size());
  bands_per_form_ = 0;
  for (std::size_t f = 0; f < forms.size(); ++f) {
    ranges_[f] = bands_of(sample_.data() + f * sample_size, spreads_[f]);
    bands_per_form_ = std::max(bands_per_form_, ranges_[f].size());
  }
}

void FormStatistics::scan() {
  const std::size_t most = s_.configurations_ / 6, room = most + 2 * batch_size;
  bands_.assign(forms_per_tile * bands_per_form_, {infinite, infinite});
  // Kept for the next tile of this thread: fresh pages would take longer than the sums.
  thread_local std::vector<float> values;
  thread_local std::vector<std::int32_t> at;
  values.resize(std::max(values.size(), bands_.size() * room));
  at.resize(std::max(at.size(), bands_.size() * room));
  for (std::size_t b = 0; b < bands_.size(); ++b) {
    const std::size_t f = b / bands_per_form_, i = b % bands_per_form_;
    if (f < ranges_.size() && i < ranges_[f].size())
      bands_[b] = {rounded_down(ranges_[f][i].lower), rounded_up(ranges_[f][i].upper)};
    bands_[b].most = static_cast<std::uint32_t>(most);
    bands_[b].values = values.data() + b * room;
    bands_[b].at = at.data() + b * room;
  }
  s_.kernels_.screen(s_.block(coordinate_, squared_), s_.padded_ / batch_size, s_.count_, weights_.data(),
                     bands_.data(), bands_per_form_);
  // The padding of the last block has the value 0.
  const auto padding = static_cast<std::uint32_t>(s_.padded_ - s_.configurations_);
  for (ScreenBand& band : bands_) {
    if (band.lower > 0) {
      if (band.below >= padding) band.below -= padding;
    } else if (band.upper > 0 && band.count <= band.most) {
      while (band.count > 0 && band.at[band.count - 1] >= static_cast<std::int32_t>(s_.configurations_))
        --band.count;
    }
  }
}

/// The rigorous bound from the linear one, both without what is added along a motion.
double FormStatistics::rigorous_at(const ColumnForm& form, double linear, std::size_t place) const {
  const LinearizationRemainder& r = *form.remainder;
  if (form.rotation) return std::min(linear + r.rotation, r.rotation_angle);
  const double* const norms = s_.row(place) + s_.columns_.coordinates() * s_.count_;
  double sum = r.position;
  for (std::size_t j = 0; j < s_.mean_norm_.size(); ++j)
    sum += r.per_column[static_cast<Eigen::Index>(j)] * norms[j];
  return linear + sum;
}

double FormStatistics::value_at(Figure figure, std::size_t place) const {
  const double* const row = s_.row(place) + coordinate_ * s_.count_;
  const double* const weights = figure.form->weights;
  double sum = 0;
  if (squared_) {
    for (std::size_t k = 0; k < s_.count_; ++k) sum += row[k] * row[k] * weights[k];
    return std::sqrt(sum + figure.form->added);
  }
  for (std::size_t k = 0; k < s_.count_; ++k) sum += row[k] * weights[k];
  if (figure.rigorous) sum = rigorous_at(*figure.form, sum, place);
  return sum + figure.form->added;
}

double FormStatistics::mean(Figure figure) const {
  const ColumnForm& form = *figure.form;
  if (squared_) {
    std::vector<const double*> columns;
    for (std::size_t k = 0; k < s_.count_; ++k) columns.push_back(s_.columns_.column(coordinate_, k));
    alignas(64) double partial[batch_size];
    s_.kernels_.root_sums(columns.data(), s_.count_, form.weights, form.added, s_.padded_, partial);
    long double sum = 0;
    for (const double part : partial) sum += part;
    sum -= static_cast<long double>(std::sqrt(form.added)) *
           static_cast<long double>(s_.padded_ - s_.configurations_);
    return static_cast<double>(sum / static_cast<long double>(s_.configurations_));
  }
  if (figure.rigorous && form.rotation) {  // its smaller one of two bounds has no mean in closed form
    long double sum = 0;
    for (std::size_t i = 0; i < s_.configurations_; ++i) sum += value_at(figure, i);
    return static_cast<double>(sum / static_cast<long double>(s_.configurations_));
  }
  double sum = form.added;
  for (std::size_t k = 0; k < s_.count_; ++k) sum += s_.mean_[coordinate_ * s_.count_ + k] * form.weights[k];
  if (!figure.rigorous) return sum;
  sum += form.remainder->position;
  for (std::size_t j = 0; j < s_.mean_norm_.size(); ++j)
    sum += form.remainder->per_column[static_cast<Eigen::Index>(j)] * s_.mean_norm_[j];
  return sum;
}

void FormStatistics::finish(std::size_t f, Figure figure, Statistic& result) {
  const WantedStatistics& wanted = s_.wanted_;
  const std::uint64_t count = s_.configurations_;
  const auto order = [&](std::uint64_t rank) { return order_statistic(f, figure, rank); };
  if (wanted.min) result.min = order(0);
  if (wanted.max) result.max = order(count - 1);
  if (wanted.mean) result.mean = mean(figure);
  for (const StatisticKind* kind : wanted.percentiles)
    result.*kind->value = percentile(kind->percentile, count, order);
}

double FormStatistics::order_statistic(std::size_t f, Figure figure, std::uint64_t rank) {
  if (s_.constant_[coordinate_]) return figure.rigorous ? of_all(figure, rank) : value_at(figure, 0);
  const std::optional<double> found = screened(f, figure, rank);
  return found ? *found : of_all(figure, rank);
}

/// The order statistic of a rank from the values that were kept; empty if they are not enough.
std::optional<double> FormStatistics::screened(std::size_t f, Figure figure, std::uint64_t rank) {
  const bool only_top = bands_per_form_ == 1 && bands_[f].upper == infinite;
  for (std::size_t b = f * bands_per_form_; b < (f + 1) * bands_per_form_; ++b) {
    const ScreenBand& band = bands_[b];
    if (band.count > band.most) continue;
    const std::uint64_t below = only_top ? s_.configurations_ - band.count : band.below;
    if (rank < below || rank >= below + band.count) continue;
    const Range near = ambiguous(ranked(band, rank - below), figure.rigorous ? spreads_[f] : 0);
    const bool beyond = (near.lower < band.lower && band.lower > -infinite) ||
                        (near.upper >= band.upper && band.upper < infinite);
    if (beyond) return std::nullopt;
    const float lower = rounded_down(near.lower), upper = rounded_up(near.upper);
    const std::uint64_t smaller = below + s_.kernels_.below(band.values, band.count, lower);
    near_.resize(band.count + 16);
    const std::uint32_t found =
        s_.kernels_.within(band.values, band.at, band.count, lower, upper, near_.data());
    exact_.clear();
    for (std::uint32_t i = 0; i < found; ++i)
      exact_.push_back(value_at(figure, static_cast<std::size_t>(near_[i])));
    if (rank - smaller >= exact_.size()) return std::nullopt;
    const auto wanted = exact_.begin() + static_cast<std::ptrdiff_t>(rank - smaller);
    std::nth_element(exact_.begin(), wanted, exact_.end());
    return *wanted;
  }
  return std::nullopt;
}

/// The value in float of a rank in a band, by bisection: floats that are not negative are ordered like the
/// integers of the same bits.
double FormStatistics::ranked(const ScreenBand& band, std::uint64_t rank) {
  if (ranked_of_ != &band) ranked_.clear();
  ranked_of_ = &band;
  for (const auto& [known, value] : ranked_)
    if (known == rank) return value;
  auto low = std::bit_cast<std::uint32_t>(std::max(band.lower, 0.0f));
  // Scaled columns and weights are at most 1.
  auto high = std::bit_cast<std::uint32_t>(std::min(band.upper, static_cast<float>(s_.count_ + 1)));
  while (high - low > 1) {
    const std::uint32_t middle = low + (high - low) / 2;
    const bool enough = s_.kernels_.below(band.values, band.count, std::bit_cast<float>(middle)) > rank;
    (enough ? high : low) = middle;
  }
  ranked_.emplace_back(rank, std::bit_cast<float>(low));
  return ranked_.back().second;
}

double FormStatistics::of_all(Figure figure, std::uint64_t rank) {
  if (all_of_.form != figure.form || all_of_.rigorous != figure.rigorous) {
    all_.resize(s_.configurations_);
    for (std::size_t i = 0; i < all_.size(); ++i) all_[i] = value_at(figure, i);
    all_of_ = figure;
  }
  const auto nth = all_.begin() + static_cast<std::ptrdiff_t>(rank);
  std::nth_element(all_.begin(), nth, all_.end());
  return *nth;
}

}  // namespace qerr
