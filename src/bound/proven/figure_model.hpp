#pragma once

#include "qerr/bound/proven_maximum.hpp"

namespace qerr {

/// A model whose worst case or sigma of the unfiltered position is the figure: behind a filter the half
/// widths of all errors are multiplied by ||H||_1 and their means by |H(1)|, or the sigma of the encoders by
/// ||H||_2 (in motion: that of each encoder is replaced) and that of each source by its own ratio.
///
/// The rigorous worst case has the model of the linear one.
/// @throws Error (input; key `requirements`) if sigma behind the filter is not known
OperationalModel figure_model(const OperationalModel&, const std::vector<Norms>& filters,
                              const std::vector<Eigen::VectorXd>& noise_in_motion, const Figure&);

}  // namespace qerr
