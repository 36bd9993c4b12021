#include <gtest/gtest.h>

#include <cmath>
#include <numeric>
#include <sstream>

#include "bound/proven/ascent.hpp"
#include "bound/proven/box_bound.hpp"
#include "bound/proven/chain_bound.hpp"
#include "qerr/bound/proven_maximum.hpp"
#include "qerr/filter/family.hpp"
#include "qerr/filter/norms.hpp"
#include "support/measured.hpp"
#include "support/random_model.hpp"

/// How tight the upper bounds are. That they are never exceeded is tested elsewhere, against searches; a
/// bound that is looser than it was holds as well, and makes a proof slower or impossible. The values are
/// those of the program itself.
namespace qerr {
namespace {

using testing::ChainMix;
using testing::Dice;
using testing::Measured;

OperationalModel model_of_mix(Dice& dice, const ChainMix& mix) {
  OperationalModel m{make_chain(testing::random_robot(dice, mix), "", ""), {}, {}};
  m.transmission = testing::random_transmission(dice, m.chain, 1e-4, 1e-3, false);
  m.coordinates = {Coordinate::x,  Coordinate::y,  Coordinate::z,
                   Coordinate::rx, Coordinate::ry, Coordinate::rz};
  m.lengths = {Coordinate::xyz, Coordinate::rxyz};
  m.frame = dice.chance(0.5) ? CoordinateFrame::tip : CoordinateFrame::base;
  return m;
}

/// An error that moves two neighbours, as of a differential.
void couple_neighbours(Dice& dice, OperationalModel& m) {
  const auto n = static_cast<Eigen::Index>(m.chain.independent.size());
  if (n < 2) return;
  Eigen::MatrixXd coupling = Eigen::MatrixXd::Identity(n, n);
  const auto first = static_cast<Eigen::Index>(dice.below(static_cast<std::size_t>(n) - 1));
  coupling(first + 1, first) = dice.between(-1, 1);
  m.transmission.coupling = coupling;
}

/// Whole turns, arcs, and joints that hardly move.
std::vector<Limits> ranges_of_all_kinds(Dice& dice, std::size_t count) {
  std::vector<Limits> ranges;
  for (std::size_t i = 0; i < count; ++i) {
    const double middle = dice.between(-2, 2), half = dice.chance(0.25) ? 3.2 : dice.between(0, 2);
    ranges.push_back({middle - half, middle + half});
  }
  return ranges;
}

TEST(ChainBound, IsAsTightAsMeasured) {
  const Measured measured("proven_bounds.csv", 1e-6);  // the tables of some bounds are in float
  for (std::uint64_t seed = 0; seed < 12; ++seed) {
    Dice dice(500 + seed);
    OperationalModel m = model_of_mix(dice, ChainMix{1 + seed % 4, 0.25, 0});
    if (seed % 3 == 1) couple_neighbours(dice, m);
    if (seed % 3 == 2) m.sources.push_back(testing::displaced_origin(dice, m.chain));
    const bool tip = seed % 2 == 1;
    const RotationAxes axes = tip ? RotationAxes::tip : RotationAxes::base;
    const ChainForm form = chain_form(m, ranges_of_all_kinds(dice, m.chain.independent.size()));
    const std::vector<Eigen::Vector3d> along{Eigen::Vector3d::UnitX(), dice.direction()};
    for (const double cells : {4.0, 11.0}) {
      const auto expect = [&](const char* figure, double value) {
        std::ostringstream name;
        name << "chain " << seed << ',' << figure << ',' << cells;
        measured.expect(name.str(), value);
      };
      const PositionWorstCase worst = position_worst_case_bound(form, along, cells);
      expect("xyz worst case", worst.length);
      expect("x worst case", worst.along[0]);
      expect("direction worst case", worst.along[1]);
      expect("xyz sigma", position_sigma_bound(form, cells));
      const std::vector<double> sigma = component_sigma_bound(form, along, cells);
      expect("x sigma", sigma[0]);
      expect("direction sigma", sigma[1]);
      if (tip) {
        expect("tip x worst case", tip_component_bound(form, TipFigure::worst_case, along, cells)[0]);
        expect("tip direction sigma", tip_component_bound(form, TipFigure::sigma, along, cells)[1]);
      }
      const RotationBound turned = rotation_worst_case_bound(form, axes, along, cells),
                          turned_sigma = rotation_sigma_bound(form, axes, along, cells);
      expect("rx worst case", turned.along[0]);
      expect("rotation worst case", turned.along[1]);
      expect("rx sigma", turned_sigma.along[0]);
      if (!tip) {
        expect("rxyz worst case", rotation_worst_case_bound(form, axes, {}, cells).length);
        expect("rxyz sigma", rotation_sigma_bound(form, axes, {}, cells).length);
      }
    }
  }
}

TEST(BoxBound, IsAsTightAsMeasured) {
  const Measured measured("proven_bounds.csv", 1e-6);  // the tables of some bounds are in float
  for (std::uint64_t seed = 0; seed < 16; ++seed) {
    Dice dice(700 + seed);
    ChainMix mix{1 + seed % 5};
    mix.square = seed % 3 == 0 ? 0.7 : 0;
    OperationalModel m = model_of_mix(dice, mix);
    if (seed % 4 == 1) m.sources.push_back(testing::displaced_origin(dice, m.chain));
    const std::size_t joints = m.chain.independent.size();
    const Eigen::VectorXd middle = dice.vector(static_cast<Eigen::Index>(joints) + 2, -1.5, 1.5),
                          part = dice.vector(static_cast<Eigen::Index>(joints) + 2, 0.5, 1);
    for (const std::size_t c : {0u, 4u, 6u, 7u})
      for (const bool sigma : {false, true}) {
        ErrorTerms terms(m, c, sigma);
        std::vector<Limits> ranges(joints, Limits{-3, 3});
        if (terms.length() && !sigma) {  // over all directions, which have two angles
          terms = terms.along_any_direction(joints);
          ranges.insert(ranges.end(), 2, {-1.6, 1.6});
        }
        const auto n = static_cast<Eigen::Index>(ranges.size());
        BoxBound bound(terms, ranges);
        for (const double width : {0.01, 0.3, 1.0}) {
          Eigen::VectorXd half = width * part.head(n);
          for (Eigen::Index j = 0; j < n; ++j)
            if (!bound.matters(static_cast<std::size_t>(j))) half[j] = 0;
          const BoxBound::Result result = bound(middle.head(n), half);
          std::ostringstream name;
          name << "box " << seed << ' ' << width << ',' << c << (sigma ? " sigma" : " worst case") << ','
               << result.widest;
          measured.expect(name.str(), result.upper);
        }
      }
  }
}

/// Couplings, mimics, sources, errors along a motion: of each a part of the models.
OperationalModel model_with_everything(Dice& dice, std::uint64_t seed, std::size_t joints) {
  ChainMix mix{joints, 0.25, seed % 3 == 0 ? 0.5 : 0};
  mix.square = seed % 4 == 2 ? 0.6 : 0;
  OperationalModel m = model_of_mix(dice, mix);
  if (seed % 5 == 1) couple_neighbours(dice, m);
  if (seed % 5 == 4) m.transmission = testing::random_transmission(dice, m.chain, 1e-4, 1e-3, true);
  if (seed % 2 == 1) m.sources.push_back(testing::displaced_origin(dice, m.chain));
  if (seed % 3 == 1) {
    m.sources.push_back({.where = IndependentError::Where::joint,
                         .owner = m.chain.independent.size() - 1,
                         .mean = 2e-5,
                         .half_width = 1e-4,
                         .sigma = 4e-5});
    m.sources.push_back({.where = IndependentError::Where::encoder, .half_width = 2e-4, .sigma = 9e-5});
  }
  if (seed % 4 == 3) {
    const auto n = static_cast<Eigen::Index>(m.chain.independent.size());
    SignalMoments tip{Eigen::VectorXd::Zero(6), dice.vector(6, 1e-6, 1e-5), Eigen::MatrixXd::Zero(6, 6)};
    tip.covariance.diagonal() = tip.peak.cwiseAbs2() / 3;
    m.along_motion = ErrorAlongMotion{
        {Eigen::VectorXd::Zero(n), Eigen::VectorXd::Zero(n), Eigen::MatrixXd::Zero(n, n)}, tip, {}};
  }
  return m;
}

std::string numbered(const char* what, std::uint64_t seed, std::size_t coordinate, bool sigma) {
  std::ostringstream name;
  name << what << ' ' << seed << ',' << coordinate << (sigma ? " sigma" : " worst case");
  return name.str();
}

TEST(ProvenMaximum, IsAsTightAsMeasured) {
  const Measured lower("proven_bounds.csv", 1e-8), upper("proven_bounds.csv", 1e-6),
      at_maximum("proven_bounds.csv", 1e-3);
  for (std::uint64_t seed = 0; seed < 7; ++seed) {
    Dice dice(900 + seed);
    const std::size_t joints = 1 + seed % 7;
    const OperationalModel m = model_with_everything(dice, seed, joints);
    const std::vector<Limits> ranges = ranges_of_all_kinds(dice, m.chain.independent.size());
    std::vector<Figure> figures;
    for (const std::size_t c : {0u, 4u, 6u, 7u})
      for (const Bound bound : {Bound::worst_case, Bound::worst_case_rigorous, Bound::sigma})
        figures.push_back({c, -1, bound});
    const auto proven = proven_maxima(m, {}, ranges, figures, {.gap = joints > 4 ? 0.4 : 0.05});
    for (std::size_t i = 0; i < figures.size(); ++i) {
      const bool sigma = figures[i].bound == Bound::sigma;
      const std::string name = numbered("maximum", seed, figures[i].signal, sigma) +
                               (figures[i].bound == Bound::worst_case_rigorous ? " rigorous" : "");
      // Where the linear worst case has several maxima, the rigorous one differs among them.
      (figures[i].bound == Bound::worst_case_rigorous ? at_maximum : lower)
          .expect(name + ",lower", proven[i].lower);
      upper.expect(name + ",upper", proven[i].upper);
    }
  }
}

TEST(ProvenMaximum, BehindFiltersAndWithLimitsIsAsTightAsMeasured) {
  const Measured lower("proven_bounds.csv", 1e-8), upper("proven_bounds.csv", 1e-6),
      at_maximum("proven_bounds.csv", 1e-3);
  const std::vector<Norms> filters{norms(difference_filter(1000, 1)), norms(difference_filter(250, 2))};
  for (std::uint64_t seed = 0; seed < 4; ++seed) {
    Dice dice(1700 + seed);
    OperationalModel m = model_with_everything(dice, seed, 1 + seed % 4);
    for (IndependentError& s : m.sources) s.sigma_ratios = {2, 3};
    if (m.along_motion) m.along_motion->filtered.assign(2, m.along_motion->tip);
    const std::vector<Limits> ranges = ranges_of_all_kinds(dice, m.chain.independent.size());
    const auto joints = static_cast<Eigen::Index>(ranges.size());
    ProofOptions options{.gap = 0.1};
    options.noise_in_motion = {dice.vector(joints, 1e-3, 2e-3), dice.vector(joints, 1e-2, 2e-2)};
    std::vector<Figure> figures;
    for (const std::size_t c : {2u, 3u, 6u})
      for (const std::ptrdiff_t filter : {-1, 0, 1})
        for (const Bound bound :
             {Bound::worst_case, filter < 0 ? Bound::worst_case_rigorous : Bound::sigma_in_motion,
              Bound::sigma})
          figures.push_back({c, filter, bound});
    const auto expect = [&](const char* limit, const std::vector<ProvenMaximum>& proven) {
      for (std::size_t i = 0; i < figures.size(); ++i) {
        std::ostringstream name;
        name << "filtered " << seed << limit << ',' << figures[i].signal << " filter " << figures[i].filter
             << " bound " << static_cast<int>(figures[i].bound);
        (figures[i].bound == Bound::worst_case_rigorous ? at_maximum : lower)
            .expect(name.str() + ",lower", proven[i].lower);
        upper.expect(name.str() + ",upper", proven[i].upper);
      }
    };
    const auto proven = proven_maxima(m, filters, ranges, figures, options);
    expect("", proven);
    options.gap = 0.01;
    for (const double factor : {0.7, 1.4}) {
      options.limits.clear();
      for (const ProvenMaximum& known : proven) options.limits.push_back(factor * known.lower);
      expect(factor < 1 ? " low" : " high", proven_maxima(m, filters, ranges, figures, options));
    }
  }
}

/// After few boxes, so that which box is halved, and along which joint, is seen.
TEST(BranchAndBound, IsAsFastAsMeasured) {
  const Measured measured("proven_bounds.csv", 1e-6);
  for (std::uint64_t seed = 0; seed < 12; ++seed) {
    Dice dice(1100 + seed);
    const OperationalModel m = model_with_everything(dice, seed, 1 + seed % 5);
    const std::vector<Limits> ranges = ranges_of_all_kinds(dice, m.chain.independent.size());
    for (const std::size_t c : {1u, 5u, 6u, 7u})
      for (const bool sigma : {false, true}) {
        const ErrorTerms terms(m, c, sigma);
        if (terms.terms().empty()) continue;
        const std::string name = numbered("boxes", seed, c, sigma);
        measured.expect(name + ",joints", static_cast<double>(influential_joints(terms, ranges)));
        measured.expect(name + ",rounding", rounding_allowance(terms, ranges));
        for (const std::size_t boxes : {1u, 20u, 400u}) {
          const SearchedMaximum found = branch_and_bound(terms, ranges, 0, 0.01, boxes);
          measured.expect(name + ",after " + std::to_string(boxes), found.upper);
          measured.expect(name + ",value after " + std::to_string(boxes), terms.value(found.at));
        }
      }
  }
}

TEST(ChainBound, OfGapsAndDependentJointsIsAsTightAsMeasured) {
  const Measured measured("proven_bounds.csv", 1e-6);
  for (std::uint64_t seed = 0; seed < 6; ++seed) {
    Dice dice(1300 + seed);
    const OperationalModel m = model_with_everything(dice, seed, 2 + seed % 3);
    const std::vector<Limits> ranges = ranges_of_all_kinds(dice, m.chain.independent.size());
    Eigen::VectorXd middle(static_cast<Eigen::Index>(ranges.size()));
    for (std::size_t j = 0; j < ranges.size(); ++j)
      middle[static_cast<Eigen::Index>(j)] = std::midpoint(ranges[j].lower, ranges[j].upper);
    for (const std::size_t c : {0u, 3u, 6u, 7u})
      for (const bool sigma : {false, true}) {
        const ErrorTerms terms(m, c, sigma);
        if (terms.terms().empty()) continue;
        const std::string name = numbered("gap", seed, c, sigma);
        const double reached = terms.value(ascend(terms, ranges, middle));
        measured.expect(name + ",ascent", reached);
        for (const double gap : {0.5, 0.1}) {
          const auto upper =
              chain_upper_bound(m, ranges, {c, -1, sigma ? Bound::sigma : Bound::worst_case}, reached, gap);
          measured.expect(name + (gap > 0.2 ? ",wide" : ",narrow"), upper.value_or(-1));
        }
      }
  }
}

/// Slides alone, joints that do not move, a tip on all axes, ranges beyond a turn.
TEST(ChainBound, OfDegenerateChainsIsAsTightAsMeasured) {
  const Measured measured("proven_bounds.csv", 1e-6);
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    Dice dice(1500 + seed);
    ChainMix mix{3, seed % 5 == 0 ? 1.0 : 0.3, 0};
    mix.reach = seed % 5 == 1 ? 0 : 0.5;
    const OperationalModel m = model_of_mix(dice, mix);
    std::vector<Limits> ranges = ranges_of_all_kinds(dice, m.chain.independent.size());
    for (std::size_t j = 0; j < ranges.size(); ++j) {
      if (seed % 5 == 2 && j != seed % 3) ranges[j].upper = ranges[j].lower;
      if (seed % 5 == 3) ranges[j].upper = ranges[j].lower + 1e-10;
      if (seed % 5 == 4) ranges[j] = {-5.0 - static_cast<double>(j), 4};
    }
    const RotationAxes axes = seed % 2 == 0 ? RotationAxes::base : RotationAxes::tip;
    const ChainForm form = chain_form(m, ranges);
    const std::vector<Eigen::Vector3d> along{Eigen::Vector3d::UnitY(), Eigen::Vector3d::UnitZ(),
                                             dice.direction()};
    const auto expect = [&](const std::string& figure, double value) {
      // Of a tip on all axes there is rounding alone.
      measured.expect("degenerate " + std::to_string(seed) + ',' + figure, 1e-9 + value);
    };
    const double cells = 7;
    expect("xyz sigma", position_sigma_bound(form, cells));
    expect("xyz worst case", position_worst_case_bound(form, along, cells).length);
    for (std::size_t i = 0; i < along.size(); ++i) {
      const std::string which = ' ' + std::to_string(i);
      expect("worst case" + which, position_worst_case_bound(form, along, cells).along[i]);
      expect("sigma" + which, component_sigma_bound(form, along, cells)[i]);
      expect("tip worst case" + which, tip_component_bound(form, TipFigure::worst_case, along, cells)[i]);
      expect("tip sigma" + which, tip_component_bound(form, TipFigure::sigma, along, cells)[i]);
      expect("turned" + which, rotation_worst_case_bound(form, axes, along, cells).along[i]);
      expect("turned sigma" + which, rotation_sigma_bound(form, axes, along, cells).along[i]);
    }
  }
}

}  // namespace
}  // namespace qerr
