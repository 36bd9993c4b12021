#include "qerr/bound/signal.hpp"

#include "bound/signals/signals.hpp"
#include "qerr/bound/operational_error.hpp"

namespace qerr {
const std::vector<SignalKind>& signal_kinds() {
  static const std::vector<SignalKind> all{
#define QERR_SIGNAL(name) name##_signal(),
#include "bound/signals/list.inc"
#undef QERR_SIGNAL
  };
  return all;
}

namespace {

std::vector<Signal> signals_of(const SignalKind& kind, const OperationalModel& model) {
  std::vector<Signal> signals = kind.signals(model);
  for (std::size_t i = 0; i < signals.size(); ++i) {
    signals[i].kind = &kind;
    signals[i].index = i;
  }
  return signals;
}

SignalMoments moments_of(const SignalMoments& all, Eigen::Index signal) {
  return {all.mean.segment(signal, 1), all.peak.segment(signal, 1),
          all.covariance.block(signal, signal, 1, 1)};
}

}  // namespace

std::vector<Signal> find_signals(const OperationalModel& model, std::string_view word) {
  constexpr std::string_view of_joint = "joint:";
  const std::string_view bare = word.starts_with(of_joint) ? word.substr(of_joint.size()) : word;
  for (const SignalKind& kind : signal_kinds()) {
    const std::vector<Signal> all = signals_of(kind, model);
    if (word == kind.group) return all;
    for (const Signal& signal : all)
      if (signal.name == word || signal.name == bare) return {signal};
  }
  return {};
}

std::vector<std::string> signal_names(const OperationalModel& model) {
  std::vector<std::string> names;
  for (const SignalKind& kind : signal_kinds())
    for (const Signal& signal : kind.signals(model)) names.push_back(signal.name);
  return names;
}

OperationalModel coordinate_model(OperationalModel model, std::size_t signal) {
  const std::size_t before = model.coordinates.size() + model.lengths.size();
  const Signal s = model.signals.at(signal - before);
  const ChainCoordinate own = s.kind->of_chain(model, s.index);
  if (model.along_motion) {  // which has no lengths
    const auto row = static_cast<Eigen::Index>(signal - model.lengths.size());
    model.along_motion->tip = moments_of(model.along_motion->tip, row);
    for (SignalMoments& m : model.along_motion->filtered) m = moments_of(m, row);
  }
  model.chain = *own.chain;
  model.coordinates = {own.coordinate};
  model.lengths.clear();
  model.signals.clear();
  return model;
}

Signal signal_of(Coordinate c) {
  return {std::string(info(c).name), std::string(info(c).unit), c, nullptr, 0};
}

}  // namespace qerr
