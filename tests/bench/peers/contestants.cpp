#include "peers.hpp"
#include "qerr_batched.hpp"
#include "qerr_scalar.hpp"

namespace qerr::bench {

std::vector<Contestant> contestants() {
  std::vector<Contestant> rows{qerr_scalar()};
  for (Contestant& row : qerr_batched()) rows.push_back(std::move(row));
  rows.push_back(qerr_workspace());
  rows.push_back(kdl());
  rows.push_back(kdl_tuned());
#ifdef QERR_WITH_RBDL
  rows.push_back(rbdl());
#endif
#ifdef QERR_WITH_PINOCCHIO
  rows.push_back(pinocchio_peer());
#endif
  return rows;
}

}  // namespace qerr::bench
