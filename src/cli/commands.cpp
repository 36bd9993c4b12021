#include "cli/command.hpp"

namespace qerr::cli {

const std::vector<Command>& commands() {
  static const std::vector<Command> table{analyze_command(),  check_command(),    filter_command(),
                                          simulate_command(), diagnose_command(), threshold_command(),
                                          robot_command(),    list_command(),     schema_command()};
  return table;
}

}  // namespace qerr::cli
