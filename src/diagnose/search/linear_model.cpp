#include "diagnose/search/linear_model.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/solve.hpp"
#include "diagnose/search/gram_kernels.hpp"

namespace qerr {

namespace {

constexpr double collinear = 1e-7;          ///< part of a column's square that is left by the others
constexpr std::size_t leading_groups = 12;  ///< whose pairs are tried
constexpr int most_moves = 200;

/// Part of a column's square beside the others below which a term is not visible in a record: its coefficient
/// has ten times the error that it had alone.
constexpr double inseparable = 0.01;

/// Largest sum of squares of a group's addition over that of all y: beyond it, other groups cancel most of
/// the group, and only the difference is known.
constexpr double cancelling = 9;

/// Upper Cholesky factor R of a = R' R in place, with a ridge for nearly dependent columns.
/// @returns whether all pivots were above `collinear`
bool factorize(Eigen::MatrixXd& a) {
  bool regular = true;
  for (Eigen::Index i = 0; i < a.cols(); ++i) {
    for (Eigen::Index j = 0; j < i; ++j)
      a(j, i) = (a(j, i) - a.col(i).head(j).dot(a.col(j).head(j))) / a(j, j);
    const double pivot = a(i, i) - a.col(i).head(i).squaredNorm();
    const bool apart = pivot > collinear;
    a(i, i) = apart ? std::sqrt(pivot) : std::numeric_limits<double>::infinity();
    regular = regular && apart;
  }
  return regular;
}

/// R'^-1 b in place.
void solve_lower(const Eigen::MatrixXd& r, Eigen::Ref<Eigen::MatrixXd> b) {
  r.transpose().triangularView<Eigen::Lower>().solveInPlace(b);
}

Eigen::VectorXd solve_upper(const Eigen::MatrixXd& r, const Eigen::VectorXd& b) {
  return r.triangularView<Eigen::Upper>().solve(b);
}

}  // namespace

Columns columns_of(const Eigen::MatrixXd& matrix) {
  Columns columns;
  for (Eigen::Index i = 0; i < matrix.cols(); ++i) columns.push_back(matrix.col(i).data());
  return columns;
}

Eigen::MatrixXd weighted_gram(const Eigen::MatrixXd& columns, const Eigen::VectorXd& y,
                              const Eigen::VectorXd& weight) {
  return weighted_gram(columns_of(columns), y, weight);
}

Eigen::MatrixXd weighted_gram(const Columns& columns, const Eigen::VectorXd& y,
                              const Eigen::VectorXd& weight) {
  const Eigen::Index rows = y.size(), count = static_cast<Eigen::Index>(columns.size());
  const auto whole = [](Eigen::Index n, std::size_t of) {
    const auto step = static_cast<Eigen::Index>(of);
    return (n + step - 1) / step * step;
  };
  // Some hundred columns of a block of rows stay in the second-level cache; a power of two would put them all
  // into the same lines of the first. Zeros up to whole tiles.
  constexpr Eigen::Index block = 504;
  Eigen::MatrixXd z(std::min(block, whole(rows, GramKernels::widest_lane)),
                    whole(count + 2, GramKernels::tile));
  z.rightCols(z.cols() - count - 2).setZero();
  const Eigen::VectorXd root = weight.cwiseSqrt();
  Eigen::MatrixXd lower = Eigen::MatrixXd::Zero(z.cols(), z.cols());
  const auto add_tile = select_kernels<GramKernels>(instruction_set()).add_tile;
  constexpr Eigen::Index tile = GramKernels::tile;
  for (Eigen::Index first = 0; first < rows; first += block) {
    const Eigen::Index filled = std::min(block, rows - first), size = whole(filled, GramKernels::widest_lane);
    const auto of_block = root.segment(first, filled);
    const auto fill = [&](Eigen::Index i, const double* column) {
      z.col(i).head(filled) =
          of_block.cwiseProduct(Eigen::Map<const Eigen::VectorXd>(column + first, filled));
    };
    for (Eigen::Index i = 0; i < count; ++i) fill(i, columns[static_cast<std::size_t>(i)]);
    fill(count, y.data());
    z.col(count + 1).head(filled) = of_block;
    z.middleRows(filled, size - filled).setZero();
    // A table in time, and what begins with an event, is zero in most blocks.
    std::vector<Eigen::Index> tiles;
    for (Eigen::Index i = 0; i < z.cols(); i += tile)
      if (!z.block(0, i, size, tile).isZero(0)) tiles.push_back(i);
    for (const Eigen::Index i : tiles)
      for (const Eigen::Index j : tiles)
        if (j <= i)
          add_tile(&z(0, i), &z(0, j), static_cast<std::size_t>(size), static_cast<std::size_t>(z.rows()),
                   static_cast<std::size_t>(z.cols()), &lower(i, j));
  }
  return lower.topLeftCorner(count + 2, count + 2).selfadjointView<Eigen::Lower>();
}

LinearModel::LinearModel(const Columns& columns, const Eigen::VectorXd& y, const Eigen::VectorXd& weight,
                         Eigen::Index base)
    : rows_(static_cast<double>((weight.array() > 0).count())), base_(base) {
  const auto count = static_cast<Eigen::Index>(columns.size());
  const Eigen::MatrixXd all = weighted_gram(columns, y, weight);
  scale_ = all.diagonal().head(count).cwiseSqrt();
  for (double& s : scale_) s = s > 0 ? 1 / s : 0;
  gram_ = scale_.asDiagonal() * all.topLeftCorner(count, count) * scale_.asDiagonal();
  moment_ = scale_.cwiseProduct(all.col(count).head(count));
  total_ = all(count, count);
  const double weights = all(count + 1, count + 1);
  const Eigen::VectorXd means = scale_.cwiseProduct(all.col(count + 1).head(count)) / std::sqrt(weights);
  centred_ = gram_ - means * means.transpose();
  spread_ = total_ - std::pow(all(count, count + 1), 2) / weights;
}

/// The groups' columns after projection on the base and a set.
struct LinearModel::Projected {
  std::vector<Eigen::Index> columns;  ///< of base and set
  Eigen::MatrixXd factor;             ///< Cholesky factor of their Gram matrix
  Eigen::MatrixXd across;             ///< factor^-1 of their products with all columns
  Eigen::VectorXd solution;           ///< factor^-1 of their moments
  double rss = 0;
  bool regular = true;
};

LinearModel::Projected LinearModel::project(const std::vector<ColumnGroup>& groups, const Set& set,
                                            bool with_across) const {
  Projected p;
  for (Eigen::Index i = 0; i < base_; ++i) p.columns.push_back(i);
  for (const std::size_t g : set)
    for (Eigen::Index i = 0; i < groups[g].count; ++i) p.columns.push_back(groups[g].first + i);
  p.factor = gram_(p.columns, p.columns);
  p.regular = factorize(p.factor);
  if (with_across) {
    p.across = gram_(p.columns, Eigen::all);
    solve_lower(p.factor, p.across);
  }
  Eigen::MatrixXd right = moment_(p.columns);
  solve_lower(p.factor, right);
  p.solution = right;
  p.rss = std::max(0.0, total_ - p.solution.squaredNorm());
  return p;
}

LinearModel::Fit LinearModel::fit(const std::vector<ColumnGroup>& groups, const Set& set) const {
  const Projected p = project(groups, set, false);
  Fit f;
  f.rss = p.rss, f.regular = p.regular;
  f.coefficients = solve_upper(p.factor, p.solution);
  for (std::size_t i = 0; i < p.columns.size(); ++i)
    f.coefficients[static_cast<Eigen::Index>(i)] *= scale_[p.columns[i]];
  return f;
}

double LinearModel::least_information(const std::vector<ColumnGroup>& groups, const Set& set,
                                      std::size_t group) const {
  const ColumnGroup& c = groups[group];
  const Projected p = project(groups, set, true);
  const auto across = p.across.middleCols(c.first, c.count);
  Eigen::MatrixXd own = gram_.block(c.first, c.first, c.count, c.count) - across.transpose() * across;
  if (symmetric_eigenvalues(own).minCoeff() < inseparable) return 0;
  const Eigen::VectorXd size = scale_.segment(c.first, c.count).cwiseInverse();
  own = size.asDiagonal() * own * size.asDiagonal();
  return symmetric_eigenvalues(own).minCoeff();
}

Eigen::VectorXd LinearModel::information(const std::vector<ColumnGroup>& groups, const Set& set,
                                         std::size_t group) const {
  const ColumnGroup& c = groups[group];
  const Projected p = project(groups, set, true);
  const auto across = p.across.middleCols(c.first, c.count);
  const Eigen::VectorXd size = scale_.segment(c.first, c.count).cwiseInverse();
  return symmetric_eigenvalues(
      size.asDiagonal() * (gram_.block(c.first, c.first, c.count, c.count) - across.transpose() * across) *
      size.asDiagonal());
}

double LinearModel::criterion(const std::vector<ColumnGroup>& groups, const Set& set, double rss, double n,
                              double floor) const {
  double value = 0;
  for (const std::size_t g : set) value += groups[g].price, rss += groups[g].least_gain;
  const double variance = std::max(rss / rows_, floor);
  return value + n * (std::log(variance) + rss / (rows_ * variance));
}

bool LinearModel::possible(const ColumnGroup& g, const Eigen::VectorXd& scaled) const {
  const double value = scaled[0] * scale_[g.first];
  // A part that is none is negative in half of all records: by less than a tenth of the noise.
  const double nothing = -0.1 * std::sqrt(rows_);
  if (g.positive > 0 && (value <= 0 || (scaled.head(g.positive).array() < nothing).any())) return false;
  if (g.most > 0 && (value < g.least || value > g.most)) return false;
  return scaled.dot(centred_.block(g.first, g.first, g.count, g.count) * scaled) <= cancelling * spread_;
}

bool LinearModel::possible(const std::vector<ColumnGroup>& groups, const Set& set, const Fit& f) const {
  if (!f.regular) return false;
  Eigen::Index at = base_;
  for (const std::size_t g : set) {
    const ColumnGroup& c = groups[g];
    const auto coefficients = f.coefficients.segment(at, c.count);
    if (!possible(c, coefficients.cwiseQuotient(scale_.segment(c.first, c.count).cwiseMax(1e-300))))
      return false;
    at += c.count;
  }
  return true;
}

bool LinearModel::possible_beside(const std::vector<ColumnGroup>& groups, const Set& part, const Projected& p,
                                  std::size_t added, const Eigen::VectorXd& scaled,
                                  const Eigen::VectorXd& explained) const {
  if (!possible(groups[added], scaled)) return false;
  const Eigen::VectorXd others = solve_upper(p.factor, p.solution - explained);
  Eigen::Index at = base_;
  return std::all_of(part.begin(), part.end(), [&](std::size_t g) {
    at += groups[g].count;
    return possible(groups[g], others.segment(at - groups[g].count, groups[g].count));
  });
}

LinearModel::Set LinearModel::search(const std::vector<ColumnGroup>& groups, Set set, std::size_t locked,
                                     double n, double floor, std::vector<Set>& seen) const {
  const auto value_of = [&](const Set& s, double rss) { return criterion(groups, s, rss, n, floor); };
  double present = value_of(set, fit(groups, set).rss);
  for (int round = 0; round < most_moves; ++round) {
    Set ascending = set;
    std::sort(ascending.begin(), ascending.end());
    if (std::find(seen.begin(), seen.end(), ascending) != seen.end()) break;
    seen.push_back(std::move(ascending));
    Set best;
    double least = present - 1e-6, fitted = present;
    bool moved = false;
    const auto propose = [&](const Set& next, double rss, const auto& is_possible) {
      const double v = value_of(next, rss);
      if (!(v < least) || !is_possible()) return;
      const Fit f = fit(groups, next);
      if (!possible(groups, next, f)) return;
      best = next, least = v, fitted = value_of(next, f.rss), moved = true;
    };
    // Additions to the whole set, and to it without one member.
    for (std::size_t without = locked; without <= set.size(); ++without) {
      Set part = set;
      if (without < set.size()) part.erase(part.begin() + static_cast<std::ptrdiff_t>(without));
      const Projected p = project(groups, part, true);
      if (!p.regular) continue;
      if (without < set.size()) propose(part, p.rss, [] { return true; });
      struct Gain {
        double gain, net;
        std::size_t group;
      };
      std::vector<Gain> gains;
      std::vector<Eigen::MatrixXd> left(groups.size());
      std::vector<Eigen::VectorXd> score(groups.size());
      for (std::size_t g = 0; g < groups.size(); ++g) {
        const ColumnGroup& c = groups[g];
        if (!c.allowed || std::any_of(part.begin(), part.end(),
                                      [&](std::size_t m) { return groups[m].family == c.family; }))
          continue;
        const auto across = p.across.middleCols(c.first, c.count);
        Eigen::MatrixXd own = gram_.block(c.first, c.first, c.count, c.count) - across.transpose() * across;
        const Eigen::VectorXd r = moment_.segment(c.first, c.count) - across.transpose() * p.solution;
        if (c.count == 1 && c.positive > 0 && r[0] <= 0) {
          score[g] = r, left[g] = own;
          continue;
        }
        Eigen::MatrixXd factor = own;
        if (!factorize(factor)) continue;
        Eigen::MatrixXd solved = r;
        solve_lower(factor, solved);
        const double gain = solved.squaredNorm();
        left[g] = std::move(own), score[g] = r;
        gains.push_back(
            {gain, gain - c.least_gain - c.price * std::max(p.rss / rows_, floor) * rows_ / n, g});
        Set next = part;
        next.push_back(g);
        propose(next, std::max(0.0, p.rss - gain), [&] {
          const Eigen::VectorXd scaled = solve_upper(factor, solved);
          return possible_beside(groups, part, p, g, scaled, across * scaled);
        });
      }
      std::sort(gains.begin(), gains.end(), [](const Gain& a, const Gain& b) { return a.net > b.net; });
      if (gains.size() > leading_groups) gains.resize(leading_groups);
      for (std::size_t i = 0; i < gains.size(); ++i)
        for (std::size_t j = 0; j < i; ++j) {
          const std::size_t a = gains[i].group, b = gains[j].group;
          const ColumnGroup &x = groups[a], &y = groups[b];
          if (x.family == y.family) continue;
          Eigen::MatrixXd both(x.count + y.count, x.count + y.count);
          const Eigen::MatrixXd cross =
              gram_.block(x.first, y.first, x.count, y.count) -
              p.across.middleCols(x.first, x.count).transpose() * p.across.middleCols(y.first, y.count);
          both << left[a], cross, cross.transpose(), left[b];
          Eigen::MatrixXd right(x.count + y.count, 1);
          right << score[a], score[b];
          if (!factorize(both)) continue;
          solve_lower(both, right);
          Set next = part;
          next.push_back(a);
          next.push_back(b);
          propose(next, std::max(0.0, p.rss - right.squaredNorm()), [&] {
            const Eigen::VectorXd scaled = solve_upper(both, right), of_x = scaled.head(x.count);
            return possible(x, of_x) &&
                   possible_beside(groups, part, p, b, scaled.tail(y.count),
                                   p.across.middleCols(x.first, x.count) * of_x +
                                       p.across.middleCols(y.first, y.count) * scaled.tail(y.count));
          });
        }
    }
    if (!moved) break;
    set = std::move(best), present = fitted;
  }
  return set;
}

}  // namespace qerr
