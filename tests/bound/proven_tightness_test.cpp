#include <gtest/gtest.h>

#include <cmath>
#include <sstream>

#include "bound/proven/box_bound.hpp"
#include "bound/proven/chain_form.hpp"
#include "bound/proven/component_sigma.hpp"
#include "bound/proven/position_sigma.hpp"
#include "bound/proven/position_worst_case.hpp"
#include "bound/proven/rotation_bound.hpp"
#include "bound/proven/tip_component.hpp"
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

}  // namespace
}  // namespace qerr
