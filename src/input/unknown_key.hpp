#pragma once

#include <vector>

#include "input/object_reader.hpp"

namespace qerr {

/// Adds the fault of a key that a mapping does not have, with the habit behind it: a misspelling, a key of
/// another section, a missing space after the colon, a decimal comma, or entries that are not indented below
/// their section. Messages show twenty faults: what further keys may mean is not looked for.
void add_unknown_key(const Field& map, const Node::Entry&, const std::vector<std::string>& known,
                     std::vector<Fault>& faults);

/// `bits: 17` of a text `bits:17`; "" for any other text.
std::string with_space_after_colon(const std::string& text);

/// Whether an empty section precedes the entry, so that the entry was probably meant to be in it.
const Node::Entry* empty_section_before(const Node& map, const Node::Entry&);

}  // namespace qerr
