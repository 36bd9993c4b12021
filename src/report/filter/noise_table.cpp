#include "report/filter/tables.hpp"
#include "report/fitted_table.hpp"
#include "report/text_table.hpp"

namespace qerr {

namespace {

std::string text_of(const MotionQuestion& m) {
  return significant(m.size, 6) + ' ' + m.unit() + (m.sine ? " at " + readable(m.frequency, "Hz") : "");
}

std::string threshold_text(const std::optional<double>& threshold) {
  return threshold ? significant(*threshold, 3) : "not searched";
}

std::string sine_table(const std::vector<SineErrorRow>& rows, std::size_t width) {
  if (rows.empty()) return {};
  std::vector<std::vector<std::string>> cells{
      {"encoder", "amplitude", "|mean| up to", "envelope", "mean square / IPQN", "envelope"}};
  for (const SineErrorRow& r : rows)
    cells.push_back(
        {escaped(r.encoder, 40), significant(r.amplitude, 5), significant(r.largest_mean, 3),
         significant(r.mean_envelope, 3),
         significant(12 * r.least_square, 5) + ".." + significant(12 * r.largest_square, 5),
         significant(1 + 12 * r.square_below, 5) + ".." + significant(1 + 12 * r.square_above, 5)});
  return "\nError of the quantizer along the sine, in counts, over all zeros of the encoder;\n"
         "envelopes of the paper (Appendix B)\n" +
         fitted_table(cells, width);
}

}  // namespace

std::string noise_table(const FilterReport& report, std::size_t width) {
  if (report.noise.empty()) return {};
  std::vector<std::vector<std::string>> rows{
      {"filter", "within 10 % above", "within 1 % above", "99 % of the noise after"}};
  for (const FilterNoise& f : report.noise)
    rows.push_back({escaped(f.filter, 40),
                    f.followed ? threshold_text(f.within_10_percent) : "memory too long",
                    f.followed ? threshold_text(f.within_1_percent) : "",
                    f.rise_time ? readable(*f.rise_time, "s") : ""});
  std::string out = "\nPeak speeds of slow sines, in counts per sample, above which IPQN is accurate\n" +
                    fitted_table(rows, width);
  for (const FilterNoise& f : report.noise) {
    if (f.rows.empty()) continue;
    std::vector<std::vector<std::string>> cells{
        {"encoder", "motion", "counts per sample", "sigma", "IPQN", "ratio"}};
    for (const NoiseRow& row : f.rows)
      cells.push_back({escaped(row.encoder, 40), text_of(row.motion), significant(row.counts_per_sample, 4),
                       row.sigma ? readable(*row.sigma, row.unit) : "not known",
                       readable(row.sigma_ipqn, row.unit),
                       row.sigma && row.sigma_ipqn > 0 ? significant(*row.sigma / row.sigma_ipqn, 4) : ""});
    out += "\n" + escaped(f.filter, 40) + ": sigma of the filtered error of an encoder in motion\n" +
           fitted_table(cells, width);
  }
  return out + sine_table(report.sine_errors, width);
}

}  // namespace qerr
