#pragma once

#include <optional>
#include <string>
#include <vector>

#include "design/filter_choice.hpp"
#include "input/object_reader.hpp"
#include "input/read_sections.hpp"

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

}  // namespace qerr
