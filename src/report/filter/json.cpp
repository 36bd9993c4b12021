#include "report/json_header.hpp"

namespace qerr {

namespace {

using ReportedFilter = In<FilterFigures, FilterReport>;
using ComparedEncoder = In<EncoderEstimators, EstimatorReport>;

/// A figure of the filter's noise: empty unless it was asked for.
template <class T>
auto noise(T FilterNoise::*value) {
  return [value](const ReportedFilter& f) {
    const auto& noise = f.whole.noise;
    return f.i < noise.size() ? std::optional<T>(noise[f.i].*value) : std::nullopt;
  };
}

RowsOf<EstimatorRow> bound(EstimatorError EstimatorRow::*errors, double EstimatorError::*bound) {
  return {{"error", [=](auto& r) { return r.*errors.*bound; }, nullable},
          {"snr_db", [=](auto& r) { return worst_case_snr_db(r.speed, r.*errors.*bound); }, nullable}};
}

RowsOf<EstimatorRow> bounds(EstimatorError EstimatorRow::*errors) {
  return {{"printed", bound(errors, &EstimatorError::printed), "the paper's bound, as printed"},
          {"varying", bound(errors, &EstimatorError::varying), "for a speed that varies between two edges"},
          {"constant", bound(errors, &EstimatorError::constant)}};
}

}  // namespace

RowsOf<Fidelity> rows(Of<Fidelity>) {
  return {{"frequency", &Fidelity::frequency},
          {"gain_error", &Fidelity::gain_error, nullable},
          {"phase_error", &Fidelity::phase_error, nullable},
          {"tracking_error", &Fidelity::tracking_error, nullable}};
}

RowsOf<BandTracking> rows(Of<BandTracking>) {
  return {{"largest", &BandTracking::largest}, {"rms", &BandTracking::rms}};
}

RowsOf<NoiseRow> rows(Of<NoiseRow>) {
  return {{"encoder", &NoiseRow::encoder},
          {"motion", [](auto& r) { return r.motion.sine ? "sine" : "constant_speed"; },
           one_of({"sine", "constant_speed"})},
          {"speed", [](auto& r) { return only_if(!r.motion.sine, r.motion.size); }, "of a constant speed",
           optional},
          {"speed_unit", [](auto& r) { return only_if(!r.motion.sine, r.motion.unit()); }, optional},
          {"amplitude", [](auto& r) { return only_if(r.motion.sine, r.motion.size); }, "of a sine", optional},
          {"amplitude_unit", [](auto& r) { return only_if(r.motion.sine, r.motion.unit()); }, optional},
          {"frequency_hz", [](auto& r) { return only_if(r.motion.sine, r.motion.frequency); }, "of a sine",
           optional},
          {"counts_per_sample", &NoiseRow::counts_per_sample},
          {"sigma", &NoiseRow::sigma, "null: the filter's memory is too long"},
          {"sigma_ipqn", &NoiseRow::sigma_ipqn},
          {"sigma_unit", &NoiseRow::unit}};
}

RowsOf<ReportedFilter> rows(Of<ReportedFilter>) {
  using Figures = FilterFigures;
  return {
      {"name", &Figures::name},
      {"derivative", [](auto& f) { return f->filter.derivative; }},
      {"sample_rate", [](auto& f) { return f->filter.sample_rate; }},
      {"h2_norm", [](auto& f) { return f->norms.h2; }},
      {"h2_error", [](auto& f) { return f->norms.h2_error; }, "bound of its numerical error"},
      {"l1_norm", [](auto& f) { return f->norms.l1; }},
      {"dc_gain", [](auto& f) { return f->norms.dc_gain; }, "H(1)", nullable},
      {"group_delay_s", &Figures::group_delay, "limit at 0 Hz", nullable},
      {"poles_max_modulus", &Figures::poles_max_modulus},
      {"bandwidth_hz", &Figures::bandwidth, "-3 dB"},
      {"noise_bandwidth_hz", &Figures::noise_bandwidth},
      {"settling_time_s", &Figures::settling_time, "to 2 %"},
      {"at", &Figures::fidelity, "with --at", optional},
      {"motion_band", &Figures::tracking, "tracking error, with --motion-band", optional},
      {"sections",
       [](auto& f) {
         return f.whole.questions.coefficients && f->filter.taps.empty()
                    ? std::optional(second_order_sections(f->filter))
                    : std::nullopt;
       },
       "with --coefficients", optional},
      {"taps",
       [](auto& f) {
         return impulse_response(f->filter, f.whole.questions.coefficients ? f->filter.taps.size() : 0);
       },
       "with --coefficients", optional},
      {"ipqn_within_10_percent_above", noise(&FilterNoise::within_10_percent), "counts per sample", optional},
      {"ipqn_within_1_percent_above", noise(&FilterNoise::within_1_percent), "counts per sample", optional},
      {"noise_rise_time_s", noise(&FilterNoise::rise_time), optional},
      {"in_motion", noise(&FilterNoise::rows), "with --speed or --sine", optional}};
}

RowsOf<SineErrorRow> rows(Of<SineErrorRow>) {
  using Sine = SineErrorRow;
  return {{"encoder", &Sine::encoder},
          {"amplitude_counts", &Sine::amplitude},
          {"largest_mean_counts", &Sine::largest_mean},
          {"mean_envelope_counts", &Sine::mean_envelope},
          {"mean_square_counts2", {{"least", &Sine::least_square}, {"largest", &Sine::largest_square}}},
          {"mean_square_envelope_counts2",
           {{"least", [](auto& r) { return 1.0 / 12 + r.square_below; }},
            {"largest", [](auto& r) { return 1.0 / 12 + r.square_above; }}}}};
}

RowsOf<EstimatorRow> rows(Of<EstimatorRow>) {
  return {
      {"speed", &EstimatorRow::speed},
      {"quanta_per_sample", &EstimatorRow::quanta_per_sample},
      {"finite_difference", bounds(&EstimatorRow::finite_difference)},
      {"inverse_time", bounds(&EstimatorRow::inverse_time)},
      {"better", [](auto& r) { return r.inverse_time_is_better() ? "inverse_time" : "finite_difference"; },
       one_of({"finite_difference", "inverse_time"})}};
}

RowsOf<ComparedEncoder> rows(Of<ComparedEncoder>) {
  using Estimators = EncoderEstimators;
  return {{"encoder", &Estimators::encoder},
          {"unit", &Estimators::unit},
          {"resolution", &Estimators::resolution},
          {"sample_rate", [](auto& e) { return e.whole.sample_rate; }},
          {"clock", [](auto& e) { return e.whole.clock; }},
          {"crossing_speed", &Estimators::crossing_speed, nullable},
          {"edge_distance",
           {{"shortest", [](auto& e) { return e->edges.shortest; }},
            {"longest", [](auto& e) { return e->edges.longest; }, nullable}},
           "of neighbouring edges, with the effects of the disc [counts]"},
          {"speeds", &Estimators::rows}};
}

RowsOf<FilterReport> rows(Of<FilterReport>) {
  return header<FilterReport>("filter").with(
      {{"spec", &FilterReport::spec},
       {"filters", within(&FilterReport::filters)},
       {"quantized_sine", &FilterReport::sine_errors, "with --sine", optional},
       {"estimators",
        [](auto& r) {
          const auto encoders = within(&EstimatorReport::encoders);
          return r.estimators ? std::optional(encoders(*r.estimators)) : std::nullopt;
        },
        "with --estimators", optional}});
}

}  // namespace qerr
