#include "qerr/encoder/transmission.hpp"

namespace qerr {

namespace {

template <class Function>
Eigen::VectorXd of_each(const Transmission& t, Function f) {
  Eigen::VectorXd values(static_cast<Eigen::Index>(t.encoders.size()));
  for (Eigen::Index i = 0; i < values.size(); ++i) values[i] = f(t.encoders[static_cast<std::size_t>(i)]);
  return values;
}

}  // namespace

Eigen::VectorXd resolutions(const Transmission& t) {
  return of_each(t, [](const Encoder& e) { return e.resolution; });
}

Eigen::VectorXd mean_errors(const Transmission& t) {
  return of_each(t, [](const Encoder& e) { return mean_error(e); });
}

}  // namespace qerr
