#pragma once

#include <string>
#include <vector>

#include "input/design_request.hpp"
#include "input/read_sections.hpp"

/// The parts of the section `design:`. All throw Error (input) with the place of a fault.
namespace qerr {

/// Options of one joint, or values of a range, beyond which they are a mistake.
inline constexpr std::size_t most_options = 10000;

/// The values of a key: one, a list, a range FROM..TO of whole numbers, or a list with ranges.
std::vector<Node> values_of(const Field&);

double price_at(const Field&);

/// `design.encoders`: what each joint may have.
/// @param priced  a price is minimized or limited, so that each option must state one
void read_design_encoders(const Field&, const std::string& folder, const RobotModel&, bool priced, Spec&,
                          DesignRequest&, Faults&);

/// `design.filters`: what each filter of the spec may become.
void read_design_filters(const Field&, const Spec&, DesignRequest&, Faults&);

/// `design.gains`: the values that kp and kd of controllers may take. @pre control is read
void read_design_gains(const Field&, const RobotModel&, const Spec&, DesignRequest&, Faults&);

}  // namespace qerr
