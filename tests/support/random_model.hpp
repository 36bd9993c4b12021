#pragma once

#include "qerr/bound/operational_error.hpp"
#include "support/random_chain.hpp"

/// Random robots with encoders, coordinates and error sources.
namespace qerr::testing {

inline constexpr Coordinate all_coordinates[] = {Coordinate::x,   Coordinate::y,    Coordinate::z,
                                                 Coordinate::rx,  Coordinate::ry,   Coordinate::rz,
                                                 Coordinate::yaw, Coordinate::roll, Coordinate::pitch};

/// A displaced origin whose direction is in the axes of the joint's parent link, as in a spec.
inline IndependentError in_parent_link(IndependentError origin, const Chain& chain) {
  origin.direction = chain.joints[origin.link].parent_axes * origin.direction;
  return origin;
}

inline IndependentError random_source(Dice& dice, const Chain& chain, std::size_t filters) {
  IndependentError s;
  s.where = static_cast<IndependentError::Where>(dice.below(3));
  s.owner = dice.below(chain.independent.size());
  if (s.where == IndependentError::Where::origin) {
    s.link = dice.below(chain.joints.size());
    s.owner = chain.joints[s.link].coordinate;
    s.direction = dice.direction();
    s = in_parent_link(std::move(s), chain);
  }
  s.mean = dice.chance(0.5) ? dice.between(-1e-3, 1e-3) : 0;
  s.half_width = dice.chance(0.7) ? dice.between(0, 1e-3) : 0;
  s.sigma = dice.chance(0.7) ? dice.between(0, 1e-3) : 0;
  for (std::size_t f = 0; f < filters && dice.chance(0.7); ++f)
    s.sigma_ratios.push_back(dice.between(0, 1e3));
  return s;
}

/// A displaced origin of the frame of a random joint.
inline IndependentError displaced_origin(Dice& dice, const Chain& chain) {
  return in_parent_link({.where = IndependentError::Where::origin,
                         .link = dice.below(chain.joints.size()),
                         .direction = dice.direction(),
                         .mean = 1e-5,
                         .half_width = 2e-4,
                         .sigma = 1e-4},
                        chain);
}

/// A random robot with random encoders, coordinates and sources; or one of the two specialized cases.
/// @param square  fraction of frames at right angles, for which the kernel is specialized, too
inline OperationalModel random_model(Dice& dice, std::size_t filters, double square) {
  ChainMix mix{1 + dice.below(9)};
  mix.square = square;
  const bool plain = dice.chance(0.5);
  if (plain && dice.chance(0.5)) mix.mimic = 0;
  OperationalModel m{make_chain(random_robot(dice, mix), "", ""), {}, {}};
  m.transmission = random_transmission(dice, m.chain, 1e-5, 1e-2, !plain || dice.chance(0.3));
  if (dice.chance(0.3)) m.frame = CoordinateFrame::tip;
  if (plain) {
    const bool equal = dice.chance(0.5);  // all columns have one scale
    for (Encoder& e : m.transmission.encoders) {
      e.rounding = Rounding::nearest;
      if (equal) e.resolution = m.transmission.encoders[0].resolution;
    }
    m.coordinates.assign(all_coordinates, all_coordinates + (dice.chance(0.5) ? 3 : 6));
    return m;
  }
  for (const Coordinate c : all_coordinates)
    if (dice.chance(0.5)) m.coordinates.push_back(c);
  if (m.coordinates.empty()) m.coordinates.push_back(Coordinate::ry);
  for (std::size_t i = dice.below(4); i > 0; --i) m.sources.push_back(random_source(dice, m.chain, filters));
  return m;
}

}  // namespace qerr::testing
