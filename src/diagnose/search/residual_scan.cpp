#include "diagnose/search/residual_scan.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <utility>
#include <vector>

#include "core/random.hpp"
#include "core/statistics.hpp"
#include "diagnose/search/peaks.hpp"
#include "diagnose/search/unnamed_terms.hpp"
#include "effect/effects/effects.hpp"

namespace qerr {

namespace {

constexpr double turn = 2 * std::numbers::pi;
constexpr int most_events = 4;

bool has_near(const std::vector<Scanned::Rate>& rates, double value, double within) {
  // Between two whole orders that are chosen there may be the one order that they imitate.
  return std::any_of(rates.begin(), rates.end(), [&](const Scanned::Rate& r) {
    return std::abs(r.value - value) < (r.whole ? 0.4 : 1) * within;
  });
}

/// Whether a term gains what its coefficients and the number of its alternatives cost it where the residual
/// has the least variance: less never enters a model.
bool is_worth_a_trial(const ErrorModel& m, const Term& t, const Eigen::ArrayXd& residual,
                      double alternatives) {
  const double price =
      static_cast<double>(t.size()) * std::log(m.rows()) + 2 * std::log(std::max(1.0, alternatives));
  return m.gain(t, residual) >= m.floor() * price;
}

/// Distance of the positions of a table whose steps are even, which passages may repeat; 0 where they differ
/// by more than a fifth, as those of random poses do: these resolve any order.
double even_step(const Eigen::ArrayXd& path) {
  std::vector<double> sorted(path.begin(), path.end());
  std::sort(sorted.begin(), sorted.end());
  const double range = sorted.back() - sorted.front();
  double count = 0, sum = 0, squares = 0;
  for (std::size_t k = 1; k < sorted.size(); ++k) {
    const double step = sorted[k] - sorted[k - 1];
    if (step * 8 * static_cast<double>(sorted.size()) < range) continue;  // the same position once more
    ++count, sum += step, squares += step * step;
  }
  if (count < 2) return 0;
  const double mean = sum / count;
  return squares / count - mean * mean < 0.04 * mean * mean ? mean : 0;
}

/// The order that the motion still resolves: a period of four counts, and two rows a period in nine tenths
/// of the motion. At a constant speed, or in even steps, an order beyond that is the alias of another.
double highest_order(const Evidence& record) {
  const double of_counts = 0.5 * std::numbers::pi / record.step();
  if (record.rows() < 3) return of_counts;
  if (const double step = record.ordered ? 0 : even_step(record.path); step > 0)
    return std::min(of_counts, std::numbers::pi / step);
  if (!record.ordered) return of_counts;
  const Eigen::Index n = record.rows() - 1, stride = std::max<Eigen::Index>(1, n / 20000);
  std::vector<double> moved;
  for (Eigen::Index k = 0; k < n; k += stride)
    if (const double by = std::abs(record.path[k + 1] - record.path[k]); by > 4 * record.path_noise)
      moved.push_back(by);
  if (moved.size() < 20) return of_counts;
  const auto tenth = moved.begin() + static_cast<std::ptrdiff_t>(moved.size() / 10);
  std::nth_element(moved.begin(), tenth, moved.end());
  const double recorded = record.interval * static_cast<double>(n) / (record.time[n] - record.time[0]);
  return std::min(of_counts, std::numbers::pi / (*tenth * recorded));
}

/// The order near one of a periodogram whose sine lowers the sum of squares most beside a constant. Where the
/// path covers few periods, a peak of the periodogram is displaced by the mean and by its own side lobes.
double refined_order(const ErrorModel& m, const Eigen::ArrayXd& residual, double order) {
  constexpr double few_periods = 8;
  const double resolution = turn / m.sampled().range();
  if (order > few_periods * resolution) return order;
  double best = m.gain(free_order_term(m.sampled(), order), residual);
  for (double step = 0.25 * resolution; step > 0.005 * resolution; step /= 2) {
    bool better = true;
    for (int move = 0; better && move < most_moves_of_step; ++move) {
      better = false;
      for (const double other : {order - step, order + step}) {
        if (other < 0.75 * resolution) continue;
        if (const double gain = m.gain(free_order_term(m.sampled(), other), residual);
            gain > best * (1 + 1e-9)) {
          best = gain, order = other, better = true;
          break;
        }
      }
    }
  }
  return order;
}

bool scan_orders(const ErrorModel& m, const Eigen::ArrayXd& residual, const Eigen::ArrayXd& scores,
                 std::vector<Scanned::Rate>& known) {
  const double range = m.sampled().range();
  const RateScan s{turn / range, highest_order(m.record()), 5};
  double hypotheses = 1;
  bool any = false;
  for (double rate : strongest_rates(scores, m.sampled().path, s, hypotheses)) {
    // A whole number of the faster shaft has no more alternatives than are below it.
    const double whole = 2 * rate / std::max(1.0, std::abs(m.sampled().encoder.shaft_ratio));
    if (!is_worth_a_trial(m, free_order_term(m.sampled(), rate), residual, std::min(whole, hypotheses)))
      continue;
    rate = refined_order(m, residual, rate);
    if (has_near(known, rate, 0.25 * turn / range)) continue;
    known.push_back({rate, hypotheses});
    any = true;
  }
  return any;
}

bool scan_loaded_orders(const ErrorModel& m, const Eigen::ArrayXd& residual, const Eigen::ArrayXd& scores,
                        std::vector<Scanned::Rate>& known) {
  const double range = m.sampled().range();
  const RateScan s{1.5 * turn / range, highest_order(m.record()), 2};
  const Eigen::ArrayXd load = m.sampled().effort / std::max(1e-300, m.sampled().effort.abs().maxCoeff());
  double hypotheses = 1;
  bool any = false;
  for (const double rate : strongest_rates(scores * load, m.sampled().path, s, hypotheses)) {
    if (!is_worth_a_trial(m, loaded_order_term(m.sampled(), rate), residual, hypotheses)) break;
    if (has_near(known, rate, 0.25 * turn / range)) continue;
    known.push_back({rate, hypotheses});
    any = true;
  }
  return any;
}

bool scan_lines(const ErrorModel& m, const Eigen::ArrayXd& residual, const Eigen::ArrayXd& scores,
                std::vector<Scanned::Rate>& known, double duration) {
  const RateScan s{turn * 8 / duration, std::numbers::pi / m.sampled().interval, 3};
  double hypotheses = 1;
  bool any = false;
  for (const double rate : strongest_rates(scores, m.sampled().time, s, hypotheses)) {
    if (!is_worth_a_trial(m, vibration_term(m.sampled(), rate / turn), residual, hypotheses)) break;
    if (has_near(known, rate / turn, 0.25 / duration)) continue;
    known.push_back({rate / turn, hypotheses});
    any = true;
  }
  return any;
}

bool scan_events(const ErrorModel& m, Eigen::ArrayXd left, std::vector<Event>& known, double duration) {
  const Eigen::ArrayXd& weight = m.weight();
  bool any = false;
  for (int i = 0; i < most_events; ++i) {
    Event event = strongest_event(left, weight, m.sampled().time);
    if (event.hypotheses == 0) break;
    const Term t = offset_step_term(m.sampled(), event.time);
    const Eigen::ArrayXd step = t.columns.col(0) - (t.columns.col(0) * weight).sum() / weight.sum();
    const double size = (step * weight * left).sum() / (step.square() * weight).sum();
    if (size * size * (step.square() * weight).sum() < 2 * std::log(event.hypotheses)) break;
    if (std::none_of(known.begin(), known.end(),
                     [&](const Event& e) { return std::abs(e.time - event.time) < 2e-3 * duration; })) {
      find_transitions(event, left, weight, m.sampled().time);
      known.push_back(event);
      any = true;
    }
    left -= size * step;
  }
  return any;
}

bool scan_places(const ErrorModel& m, const Eigen::ArrayXd& residual, std::vector<Bump>& known) {
  const Bump b = strongest_bump(residual, m.weight(), m.sampled().path);
  if (b.width == 0 ||
      !is_worth_a_trial(m, bump_term(m.sampled(), b.position, b.width), residual, b.hypotheses) ||
      std::any_of(known.begin(), known.end(),
                  [&](const Bump& p) { return std::abs(p.position - b.position) < b.width; }))
    return false;
  known.push_back({b.position, b.width, b.hypotheses});
  return true;
}

/// Less its mean.
Eigen::ArrayXd centred(const ErrorModel& m, const Eigen::ArrayXd& residual) {
  return residual - (residual * m.weight()).sum() / m.weight().sum();
}

}  // namespace

bool scan_events(const ErrorModel& m, const Eigen::ArrayXd& residual, Scanned& scanned) {
  const Evidence& sampled = m.sampled();
  const double duration = sampled.ordered ? sampled.time[sampled.rows() - 1] : 0;
  return duration > 0 && scan_events(m, centred(m, residual), scanned.events, duration);
}

bool scan_residual(const ErrorModel& m, const Eigen::ArrayXd& with_mean, Scanned& scanned) {
  const Eigen::ArrayXd& weight = m.weight();
  const Eigen::ArrayXd residual = centred(m, with_mean);
  const Eigen::ArrayXd scores = residual * weight;
  const Evidence& sampled = m.sampled();
  bool any = false;
  if (!sampled.is_stationary()) any |= scan_orders(m, residual, scores, scanned.orders);
  if (!sampled.is_stationary() && sampled.effort.size() > 0)
    any |= scan_loaded_orders(m, residual, scores, scanned.loaded_orders);
  if (const double duration = sampled.ordered ? sampled.time[sampled.rows() - 1] : 0; duration > 0) {
    any |= scan_lines(m, residual, scores, scanned.lines, duration);
    any |= scan_events(m, residual, scanned);
  }
  if (!sampled.is_stationary()) any |= scan_places(m, residual, scanned.places);
  return any;
}

namespace {

constexpr double refuted = 0.001;

/// Part of what a name explains beside all chosen terms that it must explain beside the names alone.
constexpr double least_part_alone = 0.25;

/// Part of an uncatalogued shape that it leaves, where its form is guessed.
constexpr double guess_error = 0.2;

/// Whether an order is no more than those beside it, at distances that the range resolves.
bool is_among_neighbours(const ErrorModel& m, const Choice& c, std::size_t i) {
  const Term& t = m.term(c.chosen[i]);
  if (!t.named() || !t.harmonic) return false;
  const double order = std::abs(wave_number(t.effect, m.sampled().encoder));
  const double resolution = 2 * std::numbers::pi / m.sampled().range();
  if (order < resolution) return false;  // of less than a period there is no neighbour
  const Eigen::ArrayXd residual = c.residual + addition(t, m.coefficients(c.chosen, c.fit, i));
  double sum = 0;
  int count = 0;
  for (int k = 0; k < 8; ++k)
    for (const double other : {order - (1.5 + k) * resolution, order + (1.5 + k) * resolution}) {
      if (other < 0.75 * resolution) continue;
      sum += m.gain(free_order_term(m.sampled(), other), residual);
      ++count;
    }
  const double ratio = m.gain(t, residual) / std::max(sum / count, 1e-300);
  // Where a joint stays at few places its neighbours have much of any order; one that leaves nothing but
  // white noise is right.
  constexpr double beyond_neighbours = 2;
  if (!c.structured || m.is_complete(c.chosen)) return ratio < beyond_neighbours;
  return fisher_f_tail(ratio, 2, 2.0 * count) > refuted;
}

/// Whether a name explains little beside the other names, although much beside all terms.
bool corrects_shapes(const ErrorModel& m, const Choice& c, std::size_t i) {
  if (!m.term(c.chosen[i]).named()) return false;
  LinearModel::Set names, others;
  for (const std::size_t g : c.chosen) {
    if (!m.term(g).named()) continue;
    names.push_back(g);
    if (g != c.chosen[i]) others.push_back(g);
  }
  if (names.size() == c.chosen.size()) return false;
  return m.fit(others).rss - m.fit(names).rss < least_part_alone * m.lost_without(c, i);
}

/// Whether the form of an uncatalogued shape is one of many that it could have, unlike that of a step or a
/// line.
bool is_guessed(Shape s) { return s == Shape::hysteresis || s == Shape::exponential || s == Shape::bump; }

/// Whether a name is smaller than what the largest guessed shape may leave.
bool is_detail_of_guess(const ErrorModel& m, const Choice& c, std::size_t i) {
  if (!m.term(c.chosen[i]).named() || m.term(c.chosen[i]).constant) return false;
  const auto size = [&](std::size_t k) {
    return standard_deviation(addition(m.term(c.chosen[k]), m.coefficients(c.chosen, c.fit, k)));
  };
  double largest = 0;
  for (std::size_t k = 0; k < c.chosen.size(); ++k)
    if (!m.term(c.chosen[k]).named() && is_guessed(m.term(c.chosen[k]).pattern))
      largest = std::max(largest, size(k));
  return size(i) < guess_error * largest;
}

/// Whether an order of which less than half a period is seen may be, with another curve beside it, a part of
/// one curve: the other is uncatalogued, or less than a period of it is seen.
bool is_part_of_curve(const ErrorModel& m, const Choice& c, std::size_t i) {
  return m.is_arc(c.chosen[i]) && std::any_of(c.chosen.begin(), c.chosen.end(), [&](std::size_t g) {
           return g != c.chosen[i] && (!m.term(g).named() || m.periods(g) < 1);
         });
}

/// Whether the record does not tell a scanned order from the whole numbers beside it: its 95 % interval, from
/// the derivative of its sine by the order, is wider than half of their distance. A number between is as
/// likely then. An arc of less than a turn of the shaft resolves none: there whole numbers are what is known
/// of shafts.
bool is_no_whole_number(const ErrorModel& m, const Choice& c, std::size_t i) {
  const Term& t = m.term(c.chosen[i]);
  if (!t.named() || !t.harmonic || m.candidate(c.chosen[i]).alternatives <= 1) return false;
  constexpr double by = 1e-4;
  const double order = t.effect.number("order");
  const bool of_encoder = t.effect.choices.at("shaft") == "encoder";
  const double of_turn = std::abs(wave_number(t.effect, m.sampled().encoder)) / order;
  if (m.sampled().range() * of_turn < 2 * std::numbers::pi) return false;
  const auto columns = [&](double at) -> Eigen::MatrixXd {
    return periodic_term(m.sampled(), at, of_encoder).columns;
  };
  const Eigen::VectorXd slope =
      (columns(order + by) - columns(order - by)) * m.coefficients(c.chosen, c.fit, i) / (2 * by);
  const Eigen::MatrixXd others = m.columns(c.chosen);
  const Eigen::VectorXd weighted = m.weight().matrix().cwiseProduct(slope);
  const LinearModel alone(others, slope, m.weight().matrix(), others.cols());
  const Eigen::VectorXd beside = slope - others * alone.fit({}, {}).coefficients;
  const double information = beside.dot(weighted);
  return !(information > 0) || 1.96 * std::sqrt(m.scale(c) / information) > 0.25;
}

/// Whether another chosen order is so near that the record does not resolve the two, within the main lobe of
/// its range, which is two spacings, and all of them leave something. Whole orders are nearly resolved by
/// half a turn. One order whose amplitude varies, as that of teeth under a load, has such neighbours.
/// Harmonics of a slower shaft are further apart than a quarter.
bool is_beside_order(const ErrorModel& m, const Choice& c, std::size_t i) {
  const auto order = [&](std::size_t k) {
    const Term& t = m.term(c.chosen[k]);
    return !t.harmonic ? 0 : t.named() ? std::abs(wave_number(t.effect, m.sampled().encoder)) : t.shape;
  };
  const double here = order(i), turn = 2 * std::numbers::pi, lobe = 2 * turn / m.sampled().range();
  if (!m.sampled().prismatic && m.sampled().range() >= 0.5 * turn) return false;
  if (!m.term(c.chosen[i]).named() || here == 0 || m.is_complete(c.chosen)) return false;
  for (std::size_t k = 0; k < c.chosen.size(); ++k)
    if (k != i && order(k) > 0 && std::abs(order(k) - here) < std::min(lobe, 0.25 * here)) return true;
  return false;
}

/// Whether a name explains as much in many other places of the record: its columns, shifted in time, fit what
/// the others leave as well as where they belong. So does any curve a slow error that has nothing to do with
/// it. A shift by a period of the motion changes nothing, and is left out.
bool fits_anywhere(const ErrorModel& m, const Choice& c, std::size_t i) {
  constexpr Eigen::Index shifts = 40, fewest = 10;
  const Term& t = m.term(c.chosen[i]);
  const Evidence& e = m.sampled();
  if (!t.named() || t.constant || t.step || t.reshaped || !e.ordered || !c.structured) return false;
  const Eigen::Index n = e.rows();
  const Eigen::ArrayXd target = c.residual + addition(t, m.coefficients(c.chosen, c.fit, i));
  const double gain = m.gain(t, target);
  Term shifted = t;
  Eigen::Index other = 0, as_good = 0;
  for (Eigen::Index s = 1; s < shifts; ++s) {
    const Eigen::Index by = s * n / shifts;
    shifted.columns.topRows(n - by) = t.columns.bottomRows(n - by);
    shifted.columns.bottomRows(by) = t.columns.topRows(by);
    double alike = 0, all = 0;
    for (Eigen::Index k = 0; k < t.size(); ++k) {
      const Eigen::ArrayXd column =
          t.columns.col(k) - (t.columns.col(k) * m.weight()).sum() / m.weight().sum();
      alike += m.gain(shifted, column);
      all += (column.square() * m.weight()).sum();
    }
    if (alike > 0.3 * all) continue;
    ++other;
    as_good += m.gain(shifted, target) >= gain;
  }
  return other >= fewest && 10 * as_good > other;
}

/// Whether a reading would come before what it reads, beside a curve that is left or only guessed. A late
/// reference does so, and then nothing of that kind is left; what follows the speed in part does, too.
bool is_ahead_of_time(const ErrorModel& m, const Choice& c, std::size_t i) {
  const Term& t = m.term(c.chosen[i]);
  if (t.effect.type != latency_effect().name || m.coefficients(c.chosen, c.fit, i)[0] >= 0) return false;
  const bool guessed = std::any_of(c.chosen.begin(), c.chosen.end(), [&](std::size_t g) {
    const Term& other = m.term(g);
    return !other.named() && (is_guessed(other.pattern) || other.pattern == Shape::unknown);
  });
  return guessed || (c.structured && !m.is_complete(c.chosen));
}

/// Whether the most of a term is what smoothing has taken from the path: the reference has it, too. Beside
/// noise a motion may be distorted by a part of it, of which the mean over a record shows the more.
bool is_of_smoothing(const ErrorModel& m, const Choice& c, std::size_t i) {
  constexpr double most = 0.5, deviations = 4;
  const Eigen::ArrayXd removed = m.sampled().reference - m.sampled().path, &weight = m.weight();
  const Eigen::ArrayXd own = addition(m.term(c.chosen[i]), m.coefficients(c.chosen, c.fit, i));
  const double power = (weight * own.square()).sum(), common = (weight * own * removed).sum();
  const double noise = (weight.square() * own.square() * removed.square()).sum();
  return common > most * power && common > deviations * std::sqrt(noise);
}

}  // namespace

std::vector<std::string> without_contrast(const ErrorModel& m, const Choice& c) {
  std::vector<std::string> families;
  for (std::size_t i = 0; i < c.chosen.size(); ++i)
    if (is_among_neighbours(m, c, i) || corrects_shapes(m, c, i) || is_detail_of_guess(m, c, i) ||
        is_part_of_curve(m, c, i) || is_beside_order(m, c, i) || fits_anywhere(m, c, i) ||
        is_ahead_of_time(m, c, i) || is_of_smoothing(m, c, i))
      families.push_back(m.candidate(c.chosen[i]).family);
  return families;
}

std::vector<std::string> outweighed(const ErrorModel& m, const Choice& c) {
  // Of the names that explained less, in 660 generated logs of one to three causes, 29 of 48 were wrong.
  constexpr double least_part_of_rest = 0.2;
  constexpr double part_of_shapes = 0.5;  // from here on the curves say more of its size than the record
  if (!c.structured || m.is_complete(c.chosen)) return {};
  const double rest = c.fit.rss - (m.samples().variance * m.weight()).sum();
  LinearModel::Set names;
  for (const std::size_t g : c.chosen)
    if (m.term(g).named()) names.push_back(g);
  const LinearModel::Fit alone = m.fit(names);
  std::vector<std::string> family;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0, name = 0; i < c.chosen.size(); ++i) {
    const Term& t = m.term(c.chosen[i]);
    if (!t.named()) continue;
    const Eigen::VectorXd own = m.coefficients(c.chosen, c.fit, i),
                          change = own - m.coefficients(names, alone, name++);
    if (t.step || (t.harmonic && m.periods(c.chosen[i]) >= 1)) continue;
    const double lost = m.lost_without(c, i);
    const bool of_shapes = !t.constant && standard_deviation(addition(t, change)) >
                                              part_of_shapes * standard_deviation(addition(t, own));
    if ((lost < least_part_of_rest * rest || of_shapes) && lost < least)
      least = lost, family = {m.candidate(c.chosen[i]).family};
  }
  return family;
}

std::vector<Scanned::Rate> without_whole_number(const ErrorModel& m, const Choice& c) {
  std::vector<Scanned::Rate> rates;
  for (std::size_t i = 0; i < c.chosen.size(); ++i)
    if (is_no_whole_number(m, c, i))
      rates.push_back({std::abs(wave_number(m.term(c.chosen[i]).effect, m.sampled().encoder)),
                       m.candidate(c.chosen[i]).alternatives});
  return rates;
}

namespace {

constexpr int draws = 9;
constexpr double rounding_refuted = 0.01;

/// Decrease of the weighted sum of squares by a candidate beside others, in another record of the same
/// motion; none where that record has too few samples to fit them.
double gain_in(const ErrorModel& m, const Evidence& simulated, std::uint64_t seed,
               const LinearModel::Set& others, std::size_t extra) {
  const ErrorSamples s = error_samples(simulated, seed, most_samples);
  if (s.size() < fewest_samples) return 0;
  std::vector<ColumnGroup> groups;
  Eigen::MatrixXd columns = Eigen::MatrixXd::Ones(s.size(), m.base());
  LinearModel::Set with = others;
  with.push_back(extra);
  for (const std::size_t g : with) {
    const Term t = searchable(m.candidate(g).over(s.sampling));
    groups.push_back({columns.cols(), t.size(), static_cast<int>(groups.size())});
    columns.conservativeResize(Eigen::NoChange, columns.cols() + t.size());
    columns.rightCols(t.size()) = t.columns.matrix();
  }
  const Eigen::ArrayXd weight = m.weights(s);
  const LinearModel model(columns, s.error.matrix(), weight.matrix(), m.base());
  std::iota(with.begin(), with.end(), std::size_t{0});
  const LinearModel::Set without(with.begin(), with.end() - 1);
  return (model.fit(groups, without).rss - model.fit(groups, with).rss) * m.weight().sum() / weight.sum();
}

/// Noise as it remains in the smoothed path: means of white noise over as many rows as share it.
Eigen::ArrayXd smoothed_noise(const Evidence& record, std::uint64_t stream) {
  const double between =
      record.rows() > 1 ? record.time[record.rows() - 1] / static_cast<double>(record.rows()) : 0;
  const double shared = shared_rows(record) * (between > 0 ? record.interval / between : 1);
  const auto width = std::max<Eigen::Index>(1, std::lround(shared));
  Eigen::ArrayXd sums(record.rows() + width);
  double sum = 0;
  for (Eigen::Index k = 0; k < sums.size(); ++k)
    sums[k] = sum += normal(stream, static_cast<std::uint64_t>(k));
  Eigen::ArrayXd noise(record.rows());
  for (Eigen::Index k = 0; k < noise.size(); ++k) noise[k] = sums[k + width - 1] - (k > 0 ? sums[k - 1] : 0);
  return record.path_noise / std::sqrt(static_cast<double>(width)) * noise;
}

/// Whether a candidate gains as much in simulations of a model without it as it does in the record.
bool gains_without(const ErrorModel& m, const LinearModel::Set& without, const LinearModel::Fit& f,
                   std::size_t extra, double lost, std::uint64_t seed) {
  const Evidence& record = m.record();
  std::vector<RowGroup> rows;
  for (Eigen::Index k = 0; k < record.rows(); ++k) rows.push_back({k, k + 1});
  const Sampling every(record, std::move(rows));
  Eigen::ArrayXd added = Eigen::ArrayXd::Constant(record.rows(), m.base() > 0 ? f.coefficients[0] : 0);
  for (std::size_t i = 0; i < without.size(); ++i)
    added += addition(searchable(m.candidate(without[i]).over(every)), m.coefficients(without, f, i));
  const auto d = static_cast<double>(m.term(extra).size());
  // Noise of a third of what edges are misplaced by (see error_samples) makes all draws one.
  constexpr double negligible = 0.01;  // counts
  const int different = record.path_noise < negligible * record.step() ? 1 : draws;
  double sum = 0;
  const auto refuted = [&] {
    return fisher_f_tail(lost * draws / std::max(sum, 1e-300), d, draws * d) >= rounding_refuted;
  };
  Evidence simulated = record;
  const Eigen::ArrayXd moved = path_without_noise(record) + added;
  for (Eigen::Index k = 0; k < record.rows(); ++k) simulated.measured[k] = quantize(record.encoder, moved[k]);
  // What the first draws refute the others, which add to the sum, refute, too.
  for (int draw = 0; draw < different && !refuted(); ++draw) {
    const std::uint64_t stream = stream_seed(seed, "surrogate", static_cast<std::uint64_t>(draw));
    simulated.path = record.path + smoothed_noise(record, stream);
    sum += gain_in(m, simulated, seed, without, extra) * draws / different;
  }
  return refuted();
}

}  // namespace

std::vector<std::string> brought_by_rounding(const ErrorModel& m, const Choice& choice, std::uint64_t seed) {
  std::vector<std::string> families;
  for (std::size_t i = 0; i < choice.chosen.size(); ++i) {
    LinearModel::Set without = choice.chosen;
    without.erase(without.begin() + static_cast<std::ptrdiff_t>(i));
    const LinearModel::Fit rest = m.fit(without);
    const double lost = rest.rss - choice.fit.rss;
    // Rounding alone does not bring more than a count.
    if (lost > m.weight().sum() * m.record().step() * m.record().step()) continue;
    if (gains_without(m, without, rest, choice.chosen[i], lost, seed))
      families.push_back(m.candidate(choice.chosen[i]).family);
  }
  return families;
}

}  // namespace qerr
