#pragma once

// clang-format off
/// qerr: how large the errors of a robot's encoders get at its tip, and in its filtered velocity and acceleration.
///
/// design:    encoder -> joint error -> kinematics -> operational error -> filter -> derivative error -> report
/// measured:  log -> simulate the model -> residual -> effects -> extended model -> gain -> report
///
/// Every folder is one word of these two lines, and knows only the folders on the floors below it:
/// 0 core; 1 encoder, kinematics, filter; 2 effect; 3 bound, simulate; 4 design; 5 input, report.
///
/// A whole report takes two calls, `read_spec` and `analyze`; each step is also a free function of its own.
/// All values are in SI units. Errors are thrown as qerr::Error; nothing is printed.

#include "qerr/bound/effect_shares.hpp"
#include "qerr/bound/figure.hpp"
#include "qerr/bound/independent_error.hpp"
#include "qerr/bound/operational_error.hpp"
#include "qerr/bound/proven_maximum.hpp"
#include "qerr/bound/signal.hpp"
#include "qerr/bound/velocity_estimators.hpp"
#include "qerr/bound/workspace.hpp"
#include "qerr/core/double_double.hpp"
#include "qerr/core/error.hpp"
#include "qerr/core/instruction_set.hpp"
#include "qerr/core/parameter.hpp"
#include "qerr/core/quantity.hpp"
#include "qerr/design/requirement.hpp"
#include "qerr/diagnose/diagnosis.hpp"
#include "qerr/diagnose/plan.hpp"
#include "qerr/effect/effect.hpp"
#include "qerr/effect/effect_kind.hpp"
#include "qerr/encoder/encoder.hpp"
#include "qerr/encoder/transmission.hpp"
#include "qerr/filter/family.hpp"
#include "qerr/filter/filter.hpp"
#include "qerr/filter/norms.hpp"
#include "qerr/input/first_spec.hpp"
#include "qerr/input/read_log.hpp"
#include "qerr/input/spec.hpp"
#include "qerr/kinematics/chain.hpp"
#include "qerr/kinematics/configurations.hpp"
#include "qerr/kinematics/coordinates.hpp"
#include "qerr/kinematics/robot_model.hpp"
#include "qerr/report/analysis.hpp"
#include "qerr/report/comparison.hpp"
#include "qerr/report/design_report.hpp"
#include "qerr/report/diagnosis_report.hpp"
#include "qerr/report/filter_report.hpp"
#include "qerr/report/robot_report.hpp"
#include "qerr/report/simulation_report.hpp"
#include "qerr/report/write.hpp"
#include "qerr/simulate/log.hpp"
#include "qerr/simulate/simulate.hpp"

// clang-format on
