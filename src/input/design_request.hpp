#pragma once

#include <optional>
#include <string>
#include <vector>

#include "design/filter_choice.hpp"
#include "input/object_reader.hpp"
#include "input/read_sections.hpp"
#include "input/yaml_tree.hpp"

namespace qerr {

/// One option of a joint: an encoder, the gear that it is sold with, and their price.
struct EncoderOption {
  std::string name;
  Node entry;                         ///< of the encoder in a spec
  std::vector<Node> effects;          ///< that come with it, without a joint (`on_joint`)
  std::optional<double> price = 0.0;  ///< without what is paid by the bit; empty: a catalogue's cell is
  double price_per_bit = 0;           ///< of log2(counts per revolution)
};

struct JointOptions {
  std::size_t joint = 0;  ///< independent joint, in chain order
  std::vector<EncoderOption> options;
};

/// What a filter of the spec may become: its low-pass is replaced.
struct FilterOptions {
  std::size_t filter = 0;  ///< of the spec
  FilterRange range;
  Place place;
};

/// The values that a gain of some joints' controllers may take, in all of them together.
struct GainOptions {
  std::vector<std::size_t> joints;
  std::string key;             ///< kp or kd
  std::vector<double> values;  ///< descending [N m/rad, N m s/rad, or N/m, N s/m]
  Place place;
};

/// The section `design:` of a spec: what is minimized, and what may be chosen.
struct DesignRequest {
  enum class Minimize { price, resolution, figure };
  Minimize minimize = Minimize::price;
  Node figure;                   ///< of `figure_entry`, if a figure is minimized
  std::optional<double> budget;  ///< highest price
  std::vector<JointOptions> encoders;
  std::vector<FilterOptions> filters;
  std::vector<GainOptions> gains;
  std::string price_unit;  ///< of the catalogues; "" if they state none
  Place place;
};

struct Spec;

/// A quantity as an entry of `requirements:` without a limit to speak of (1e300), with the statistic that is
/// given, else that of its first requirement, else `max`.
/// @throws Error (input) if it is no quantity of the spec
Node figure_entry(const Field& quantity, const Node* statistic, const Spec&);

/// The parts of the section `design:`. All throw Error (input) with the place of a fault.

/// Options of one joint, or values of a range, beyond which they are a mistake.
inline constexpr std::size_t most_options = 10000;

/// The values of a key: one, a list, a range FROM..TO of whole numbers, or a list with ranges.
std::vector<Node> values_of(const Field&);

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
