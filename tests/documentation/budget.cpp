#include <iostream>

#include "qerr/qerr.hpp"

int main() try {
  const qerr::Analysis analysis = qerr::analyze(qerr::read_spec("spec.yaml"));
  const auto& velocity = analysis.workspace.derivatives.at(0);  // of x, y, z
  std::cout << "velocity: " << velocity.at(0).worst_case.p99 << " m/s\n";
  std::cout << qerr::write(analysis, "json");
} catch (const qerr::Error& error) {
  std::cerr << error.what() << '\n';  // file, line, rule, value, remedy
  return 1;
}
