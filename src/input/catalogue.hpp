#pragma once

#include <optional>
#include <string>
#include <vector>

#include "input/yaml_tree.hpp"

namespace qerr {

/// A row of a catalogue: what can be bought for a joint.
struct CatalogueRow {
  std::string name;
  std::optional<double> price;  ///< empty: the cell is
  /// The entry of the encoder in a spec: the cells of the encoder's keys that are not empty.
  Node entry;
  /// Entries of effects that come with it, such as the play of its gear, without a joint (`on_joint`).
  std::vector<Node> effects;
  Place place;
};

/// Sums of prices are compared in whole millionths, of which 2^63 hold 9e12.
inline constexpr double highest_price = 1e9;

/// A table of encoders, and of the gears that they are sold with.
struct Catalogue {
  std::string file;
  std::string price_unit;  ///< of the header `price [EUR]`; "" without one
  std::vector<CatalogueRow> rows;
};

/// Reads a catalogue from CSV. Its columns are
///   name                    of the row, unique
///   price                   optional, a number
///   any key of an encoder   `bits`, `gear_ratio`, `accuracy`, ...; `accuracy [arcsec]` gives all cells
///   without
///                           a unit that one
///   an effect's name        its size, the parameter that it requires: `backlash [arcmin]`.
///   `EFFECT.PARAMETER` is
///                           another parameter
/// and any others, which describe the row for people. Empty cells state nothing. A table that semicolons
/// separate may have decimal commas.
/// @throws Error (input) with the places of all faults: no column `name`, no row, an unnamed or doubled row,
/// a price that is no number or negative, a column that is nearly one of the above; (file_system) if the file
/// cannot be read
Catalogue read_catalogue(const std::string& path);

/// An effect of a catalogue's row as an entry of `effects:` of a spec.
Node on_joint(const Node& effect, const std::string& joint_or_pattern);

}  // namespace qerr
