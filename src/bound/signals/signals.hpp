#pragma once

#include "qerr/bound/signal.hpp"

namespace qerr {

#define QERR_SIGNAL(name) SignalKind name##_signal();
#include "bound/signals/list.inc"
#undef QERR_SIGNAL

}  // namespace qerr
