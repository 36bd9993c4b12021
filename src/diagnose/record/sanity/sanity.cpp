#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <set>
#include <vector>

#include "core/random.hpp"
#include "diagnose/record/evidence.hpp"
#include "diagnose/record/sanity/sanity_steps.hpp"
#include "diagnose/record/with_effects.hpp"
#include "qerr/effect/effect_kind.hpp"

namespace qerr {

namespace sanity {

namespace {

/// The column from which the counts of an encoder are read.
std::optional<Eigen::Index> column_of_counts(const Sanity& s, std::size_t encoder) {
  if (const auto counts = s.log.find(LogSignal::counts, encoder)) return counts;
  const Coupling& coupling = s.model.transmission.coupling;
  const auto row = static_cast<Eigen::Index>(encoder);
  const bool uncoupled = coupling(row, row) == 1 && coupling.row(row).cwiseAbs().sum() == 1;
  return uncoupled ? s.log.find(LogSignal::measured, encoder) : std::nullopt;
}

}  // namespace

std::optional<RecordedCounts> recorded_counts(const Sanity& s, std::size_t encoder) {
  const auto column = column_of_counts(s, encoder);
  if (!column) return std::nullopt;
  RecordedCounts read{*column, s.log.columns[static_cast<std::size_t>(*column)].signal == LogSignal::counts,
                      s.log.values.col(*column)};
  if (!read.direct) read.counts /= s.model.transmission.encoders[encoder].resolution;
  return read;
}

bool has_counts(const Sanity& s, std::size_t encoder) { return column_of_counts(s, encoder).has_value(); }

void write_back(Sanity& s, const RecordedCounts& r, std::size_t encoder) {
  s.log.values.col(r.column) =
      r.direct ? r.counts : Eigen::ArrayXd(r.counts * s.model.transmission.encoders[encoder].resolution);
}

Eigen::ArrayXd encoder_reference(const Sanity& s, std::size_t encoder) {
  return qerr::encoder_reference(s.model, s.log, static_cast<Eigen::Index>(encoder)).position;
}

Eigen::ArrayXd reference_in_counts(const Sanity& s, std::size_t encoder) {
  Eigen::ArrayXd reference = encoder_reference(s, encoder);
  reference /= s.model.transmission.encoders[encoder].resolution;
  return reference;
}

bool has_reference(const Sanity& s, std::size_t encoder) {
  return qerr::has_reference(s.model, s.log, static_cast<Eigen::Index>(encoder));
}

Eigen::ArrayXd some_rows(const Eigen::Ref<const Eigen::ArrayXd>& x) {
  constexpr Eigen::Index most = 8192;
  const Eigen::Index n = std::min(x.size(), most);
  Eigen::ArrayXd out(n);
  for (Eigen::Index k = 0; k < n; ++k) out[k] = x[k * x.size() / n];
  return out;
}

double ideal_sigma(const Sanity& s, std::size_t joint) {
  const Transmission& t = s.model.transmission;
  const Eigen::VectorXd steps =
      resolutions(t).cwiseProduct(t.coupling.row(static_cast<Eigen::Index>(joint)).transpose());
  return steps.norm() / std::sqrt(12.0);
}

Cause exact_cause(const Sanity& s, std::size_t encoder, std::string_view effect,
                  std::map<std::string, double> numbers, double p_value, double rms_before,
                  double rms_after) {
  Cause c;
  c.effect = {std::string(effect), s.model.chain.independent[encoder].name, std::move(numbers), {}};
  c.p_value = std::max(p_value, 1e-300);
  c.gain.rms_before = rms_before;
  c.gain.rms_after = rms_after;
  if (s.model.chain.independent[encoder].prismatic()) c.gain.unit = "m";
  return c;
}

const Effect* specified_effect(const Sanity& s, std::size_t encoder, std::string_view effect) {
  for (const Effect& e : s.present)
    if (e.type == effect && e.joint == s.model.chain.independent[encoder].name) return &e;
  return nullptr;
}

void remove_effect(Sanity& s, const Effect* effect) {
  s.present.erase(s.present.begin() + (effect - s.present.data()));
}

void drop_column(Log& log, Eigen::Index column) {
  const Eigen::Index after = log.values.cols() - column - 1;
  log.values.middleCols(column, after) = log.values.rightCols(after).eval();
  log.values.conservativeResize(Eigen::NoChange, log.values.cols() - 1);
  log.columns.erase(log.columns.begin() + column);
}

void keep_rows(Sanity& s, const std::vector<Eigen::Index>& rows) {
  std::vector<std::uint64_t> in_file;
  in_file.reserve(rows.size());
  for (const Eigen::Index k : rows) in_file.push_back(s.log.row_number(k));
  s.log.file_rows = std::move(in_file);
  s.log.values = s.log.values(rows, Eigen::all).eval();
  s.log.rows = rows.size();
  s.log.stretches.clear();
}

std::optional<double> time_of(const Sanity& s, Eigen::Index row) {
  const auto stamps = s.log.find(LogSignal::time);
  return stamps ? std::optional(s.log.values(row, *stamps)) : std::nullopt;
}

namespace {

/// The poses of rows that stand apart, by number: rows whose readings are all the same. Empty where most rows
/// have readings of their own, or where most readings of an encoder have another one count above: a motion
/// passes all counts.
std::vector<std::size_t> poses_of(const Sanity& s) {
  const auto n = static_cast<std::size_t>(s.log.values.rows());
  std::map<std::vector<double>, std::size_t> numbers;
  std::vector<std::vector<double>> readings(n);
  for (std::size_t i = 0; i < s.model.chain.independent.size(); ++i) {
    const auto read = recorded_counts(s, i);
    if (!read) continue;
    std::set<double> distinct;
    for (std::size_t k = 0; k < n; ++k) {
      readings[k].push_back(std::round(read->counts[static_cast<Eigen::Index>(k)]));
      distinct.insert(readings[k].back());
    }
    const auto neighbours =
        std::ranges::count_if(distinct, [&](double count) { return distinct.contains(count + 1); });
    if (2 * static_cast<std::size_t>(neighbours) > distinct.size()) return {};
  }
  std::vector<std::size_t> pose;
  for (const std::vector<double>& r : readings)
    pose.push_back(numbers.try_emplace(r, numbers.size()).first->second);
  return 2 * numbers.size() <= n ? pose : std::vector<std::size_t>{};
}

/// Rows without a time have no order: one by their values, which are then shuffled, makes all that follows
/// the same for any order in the file. Rows of one pose stay together. Poses of a tip are in the order in
/// which they were taken.
void forget_order(Sanity& s) {
  const bool tracked = std::any_of(s.log.columns.begin(), s.log.columns.end(),
                                   [](const LogColumn& c) { return c.signal == LogSignal::tip; });
  if (s.log.has_time() || tracked || !s.log.stretches.empty()) return;
  const auto n = static_cast<std::size_t>(s.log.values.rows());
  std::vector<Eigen::Index> sorted(n), place(n), rows(n);
  std::iota(sorted.begin(), sorted.end(), Eigen::Index{0});
  std::ranges::sort(sorted, [&](Eigen::Index a, Eigen::Index b) {
    return std::ranges::lexicographical_compare(s.log.values.row(a), s.log.values.row(b));
  });
  const auto key = [](Eigen::Index i) { return random_bits(0, static_cast<std::uint64_t>(i), 0); };
  std::iota(place.begin(), place.end(), Eigen::Index{0});
  std::ranges::sort(place, std::ranges::less{}, key);
  for (std::size_t i = 0; i < n; ++i) rows[i] = sorted[static_cast<std::size_t>(place[i])];
  if (const std::vector<std::size_t> pose = poses_of(s); !pose.empty()) {
    std::vector<std::size_t> first(n, n);  // of a pose, among the shuffled rows
    const auto of = [&](Eigen::Index row) { return pose[static_cast<std::size_t>(row)]; };
    for (std::size_t i = 0; i < n; ++i) first[of(rows[i])] = std::min(first[of(rows[i])], i);
    std::ranges::stable_sort(rows, std::ranges::less{}, [&](Eigen::Index row) { return first[of(row)]; });
  }
  keep_rows(s, rows);
}

/// Rms of errors beside what changes slowly from position to position.
double scatter_along(const Eigen::ArrayXd& position, const Eigen::ArrayXd& error) {
  const Eigen::Index n = error.size();
  if (n < 3) return 0;
  const Eigen::ArrayXd sorted = error(ascending_rows(position));
  // That of one row less the mean of its neighbours has 1 + 1/2 of the variance of a row.
  return rms(sorted.segment(1, n - 2) - 0.5 * (sorted.head(n - 2) + sorted.tail(n - 2))) / std::sqrt(1.5);
}

/// Without a reference of any position the counts cannot be compared with anything.
void check_reference_exists(Sanity& s) {
  bool exists =
      s.log.find(LogSignal::tip, 0) || s.log.find(LogSignal::tip, 1) || s.log.find(LogSignal::tip, 2);
  for (std::size_t i = 0; i < s.model.chain.independent.size(); ++i)
    exists = exists || (has_counts(s, i) && has_reference(s, i));
  if (!exists)
    s.cannot_judge =
        "the log has no reference that can be used: record 'JOINT.reference' with a reference sensor at a "
        "joint, "
        "or 'tip.x', 'tip.y', 'tip.z' with a tracker";
}

}  // namespace

bool are_chosen_in_steps(const Sanity& s, std::size_t encoder, const Eigen::ArrayXd& values,
                         double of_fault) {
  if (!has_counts(s, encoder) || !has_reference(s, encoder)) return false;
  const Eigen::ArrayXd error = recorded_counts(s, encoder)->counts - reference_in_counts(s, encoder);
  const double scatter = s.log.has_time() ? standard_deviation(error) : scatter_along(values, error);
  return scatter * scatter < 1.0 / 12 + 0.25 * of_fault;
}

}  // namespace sanity

Sanity check_sanity(const OperationalModel& model, const std::vector<Filter>& filters, Log log,
                    const std::vector<Effect>& present) {
  Sanity s;
  s.log = std::move(log);
  s.model = model;
  s.present = present;
  s.rounding_sigma.assign(model.transmission.encoders.size(), 0);
  s.reference_grid = s.rounding_sigma;
  for (std::size_t i = 0; i < model.transmission.encoders.size(); ++i)
    for (const Effect& effect : present)
      if (const auto modify = effect_kind(effect.type).modify_encoder;
          modify && effect.joint == model.chain.independent[i].name)
        modify(s.model.transmission.encoders[i]);
  const std::size_t encoders = model.transmission.encoders.size();
  for (std::size_t i = 0; i < encoders; ++i) {
    s.rms_before.push_back(
        sanity::has_counts(s, i) && sanity::has_reference(s, i)
            ? rms(sanity::recorded_counts(s, i)->counts * model.transmission.encoders[i].resolution -
                  sanity::encoder_reference(s, i))
            : 0);
  }
  sanity::forget_order(s);
  sanity::check_held_cells(s);
  if (s.log.values.rows() < 8) return s;  // too few for any of the checks
  sanity::check_stamps(s);
  sanity::check_exchange(s);
  for (const auto step :
       {sanity::check_constant_columns, sanity::check_unit, sanity::check_turns, sanity::check_rollover,
        sanity::check_decoding, sanity::check_frozen_reference, sanity::check_log_resolution,
        sanity::check_reference_grid, sanity::check_motion, sanity::check_controller_output})
    for (std::size_t i = 0; i < encoders; ++i) step(s, i);
  sanity::check_loads(s);
  for (std::size_t i = 0; i < encoders; ++i) sanity::check_stuck_bit(s, i);
  sanity::check_outliers(s);
  sanity::check_held_tip(s);
  sanity::check_held_sensors(s);  // before stuck sensors: a hold of many rows looks like one
  for (const auto step : {sanity::check_losses, sanity::check_unrelated, sanity::check_stuck_sensor})
    for (std::size_t i = 0; i < encoders; ++i) step(s, i);
  sanity::check_reference_exists(s);
  for (std::size_t i = 0; i < encoders; ++i) sanity::check_unreferenced(s, i);
  sanity::check_tracker(s);
  sanity::check_tip_outliers(s);
  for (std::size_t i = 0; i < encoders; ++i) sanity::check_velocity_column(s, i);
  for (std::size_t i = 0; i < encoders; ++i) sanity::check_velocity(s, filters, i);
  sanity::check_interpolated(s);  // last: the other checks see all rows
  for (std::size_t i = 0; i < encoders; ++i) sanity::check_reference_noise(s, i);
  return s;
}

std::vector<Evidence> evidence(const Sanity& s, const std::vector<std::size_t>& encoders, unsigned threads) {
  std::vector<Evidence> all = evidence(s.model, s.log, encoders, threads);
  add_coupled_effects(all, s.model.transmission, s.present);
  for (Evidence& e : all) {
    // The error of a rounded reference is not reduced by smoothing where it moves by less than its step a
    // row.
    const double grid = s.reference_grid[static_cast<std::size_t>(e.number)] / std::sqrt(12.0);
    e.noise = std::max(e.noise, grid), e.path_noise = std::max(e.path_noise, grid);
    for (std::size_t i = 0; i < s.rounding_sigma.size(); ++i)
      if (s.rounding_sigma[i] > 0 && s.model.chain.independent[i].name == e.joint)
        e.random_sigma = Eigen::ArrayXd::Constant(e.rows(), s.rounding_sigma[i]);
    e = within_record(with_effects(std::move(e), s.present), s.present);
  }
  return all;
}

}  // namespace qerr
