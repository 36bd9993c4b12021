#include <string>

#include "core/text.hpp"
#include "diagnose/record/sanity/sanity_steps.hpp"

/// Records that are too short, or in which a joint rests.
namespace qerr::sanity {

void check_motion(Sanity& s, std::size_t encoder) {
  if (!has_counts(s, encoder) || !has_reference(s, encoder)) return;
  const auto read = recorded_counts(s, encoder);
  // A resting joint changes its counts by one at most: where it rests on an edge.
  if (((read->counts - read->counts[0]).abs() > 1).any() || peak_to_peak(read->counts) > 1) return;
  s.data.push_back(
      {"the joint does not move: its counts change by " + significant(peak_to_peak(read->counts), 1) +
           " in the whole record",
       s.model.chain.independent[encoder].name, 1, time_of(s, 0),
       "move the joint in both directions, by a revolution of its encoder or more: at rest only a "
       "constant error of more than half a count, a drift and noise can be seen"});
}

}  // namespace qerr::sanity
