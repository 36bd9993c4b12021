#include "input/urdf_flaws.hpp"

namespace qerr {

namespace {

// Ten times as many as a message shows. The search for similar names takes time for each of them.
constexpr std::size_t most_spoiling_flaws = 200;

}  // namespace

void FlawList::concern(const UrdfElement& element) {
  concern_document();
  const UrdfAttribute* name = element.attribute("name");
  if (element.name == "joint") part_.joints = {name ? name->value : ""};
  if (element.name == "link" && name) part_.link = name->value;
}

Flaw& FlawList::add(bool spoils, Fault fault) {
  Flaw& flaw = flaws_.emplace_back(part_);
  flaw.fault = std::move(fault);
  flaw.spoils = spoils;
  if (spoils && ++spoiling_ > most_spoiling_flaws) raise();
  return flaw;
}

void FlawList::raise() const {
  std::vector<Fault> faults;
  for (const Flaw& flaw : flaws_)
    if (flaw.spoils) faults.push_back(flaw.fault);
  if (!faults.empty()) throw Error(faults);
}

}  // namespace qerr
