#include "peers.hpp"
#include "qerr_scalar.hpp"

namespace qerr::bench {

std::vector<Contestant> contestants() {
  std::vector<Contestant> rows{qerr_scalar(), qerr_workspace(), kdl()};
#ifdef QERR_WITH_RBDL
  rows.push_back(rbdl());
#endif
#ifdef QERR_WITH_PINOCCHIO
  rows.push_back(pinocchio_peer());
#endif
  return rows;
}

}  // namespace qerr::bench
