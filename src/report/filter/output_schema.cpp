#include "report/output_schemas.hpp"

namespace qerr {

namespace {

std::vector<SchemaMember> filter_noise_members() {
  using namespace schema;
  const Json row = object({{"encoder", text()},
                           {"motion", one_of({"sine", "constant_speed"})},
                           {"speed", number(), "of a constant speed", true},
                           {"speed_unit", text(), "", true},
                           {"amplitude", number(), "of a sine", true},
                           {"amplitude_unit", text(), "", true},
                           {"frequency_hz", number(), "of a sine", true},
                           {"counts_per_sample", number()},
                           {"sigma", number_or_null(), "null: the filter's memory is too long"},
                           {"sigma_ipqn", number()},
                           {"sigma_unit", text()}});
  return {{"ipqn_within_10_percent_above", number_or_null(), "counts per sample", true},
          {"ipqn_within_1_percent_above", number_or_null(), "counts per sample", true},
          {"noise_rise_time_s", number_or_null(), "", true},
          {"in_motion", list(row), "with --speed or --sine", true}};
}

Json one_filter_schema() {
  using namespace schema;
  const Json at = object({{"frequency", number()},
                          {"gain_error", number_or_null()},
                          {"phase_error", number_or_null()},
                          {"tracking_error", number_or_null()}});
  return object(joined({{"name", text()},
                        {"derivative", number()},
                        {"sample_rate", number()},
                        {"h2_norm", number()},
                        {"h2_error", number(), "bound of its numerical error"},
                        {"l1_norm", interval()},
                        {"dc_gain", number_or_null(), "H(1)"},
                        {"group_delay_s", number_or_null(), "limit at 0 Hz"},
                        {"poles_max_modulus", number()},
                        {"bandwidth_hz", number_or_null(), "-3 dB"},
                        {"noise_bandwidth_hz", number_or_null()},
                        {"settling_time_s", number_or_null(), "to 2 %"},
                        {"at", list(at), "with --at", true},
                        {"motion_band", object({{"largest", number()}, {"rms", number()}}),
                         "tracking error, with --motion-band", true},
                        {"sections", list(list(number())), "with --coefficients", true},
                        {"taps", list(number()), "with --coefficients", true}},
                       filter_noise_members()));
}

Json quantized_sine_schema() {
  using namespace schema;
  const Json squares = object({{"least", number()}, {"largest", number()}});
  return object({{"encoder", text()},
                 {"amplitude_counts", number()},
                 {"largest_mean_counts", number()},
                 {"mean_envelope_counts", number()},
                 {"mean_square_counts2", squares},
                 {"mean_square_envelope_counts2", squares}});
}

Json estimators_schema() {
  using namespace schema;
  const Json error = object({{"error", number_or_null()}, {"snr_db", number_or_null()}});
  const Json errors = object({{"printed", error, "the paper's bound, as printed"},
                              {"varying", error, "for a speed that varies between two edges"},
                              {"constant", error}});
  const Json row = object({{"speed", number()},
                           {"quanta_per_sample", number()},
                           {"finite_difference", errors},
                           {"inverse_time", errors},
                           {"better", one_of({"finite_difference", "inverse_time"})}});
  return object({{"encoder", text()},
                 {"unit", text()},
                 {"resolution", number()},
                 {"sample_rate", number()},
                 {"clock", number()},
                 {"crossing_speed", number_or_null()},
                 {"edge_distance", object({{"shortest", number()}, {"longest", number_or_null()}}),
                  "of neighbouring edges, with the effects of the disc [counts]"},
                 {"speeds", list(row)}});
}

}  // namespace

Json filter_schema() {
  using namespace schema;
  return object({{"qerr", text(), "the version that wrote the report"},
                 {"command", constant("filter")},
                 {"spec", spec_source()},
                 {"filters", list(one_filter_schema())},
                 {"quantized_sine", list(quantized_sine_schema()), "with --sine", true},
                 {"estimators", list(estimators_schema()), "with --estimators", true}});
}

}  // namespace qerr
