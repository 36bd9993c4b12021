#pragma once

#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "input/yaml_tree.hpp"
#include "qerr/input/spec.hpp"
#include "qerr/kinematics/chain.hpp"

namespace qerr {

/// A change of a spec: a dotted path, and its value, whose place is that of the change in messages.
using SpecChange = std::pair<std::string, Node>;

/// The kinematic chain of a spec's tree, to which the entries by joints belong; without joints if the tree
/// has no robot.
using ChainOf = std::function<const Chain&(const Node& root)>;

/// Replaces or adds the values at dotted paths (`filters.velocity.derivative`); items of lists are counted
/// from zero, `requirements.0.at_most` or `requirements[0].at_most`. Where keys contain dots, the longest
/// matching key is used.
///
/// In a mapping by joints (`encoders`, `configurations.limits`, `design.encoders`) a pattern changes every
/// entry that governs a joint which it fits. A joint without an entry of its own, or whose pattern governs
/// others, too, first gets a copy of what holds for it. In an encoder's entry the key of a kind (`bits`)
/// removes those that it excludes (`counts_per_rev`, `decoding`). Patterns come before single joints,
/// whatever their order; a change of a whole mapping keeps its place.
/// @param chain_of  is called when joints are needed, with the robot as it is after the changes
/// @returns warnings: a pattern that is an entry itself has changed others, too
/// @throws Error (input) if a path passes through a single value or beyond the end of a list, would begin
/// a new filter with one of its keys, fits no joint of the chain, or is the entry of a joint outside it
std::vector<std::string> apply_changes(Node& root, const std::vector<SpecChange>&, const ChainOf& chain_of);

/// Whether one of two paths is the other one or lies in it, or both state the resolution of one encoder: the
/// last one would hold.
bool set_one_value(const std::string& one, const std::string& other);

/// The change of a path to the value of a YAML text.
/// @param origin  place of the change in messages, such as `--set KEY`
/// @throws Error (input) if the text is not YAML
SpecChange spec_change(const std::string& path, const std::string& text, const std::string& origin);

/// The changes of --set, in the order of the command line.
std::vector<SpecChange> spec_changes(const std::vector<std::pair<std::string, std::string>>& set);

/// The text of a spec with its overrides and further changes written into it; comments and layout of the rest
/// are kept.
/// @param effects  entries that are added to `effects:`; one of the same type and joint is replaced
/// @param remark   a comment at its end
/// @param target   path at which the text will stand, for its paths
/// @throws Error (input), with the place, if the layout of the text does not allow a change
std::string changed_spec(const Spec&, const std::vector<SpecChange>& changes,
                         const std::vector<Node>& effects, const std::string& remark,
                         const std::string& target);

}  // namespace qerr
