#include "bound/proven/tip_table.hpp"
#include "lanes/compiled_set.hpp"

namespace qerr {

namespace {

/// Index and fraction in a row of `count` >= 2 values; both ends are clamped.
[[gnu::always_inline]] inline int cell(double position, std::size_t count, double& fraction) {
  const double most = static_cast<double>(count) - 2;
  position = position < 0 ? 0 : position;
  double floor = static_cast<double>(static_cast<int>(position));
  floor = floor > most ? most : floor;
  fraction = position - floor;
  return static_cast<int>(floor);
}

[[gnu::always_inline]] inline double bilinear(const double* v, int at, int right, int up, double fr,
                                              double fz) {
  const double lower = v[at] * (1 - fr) + v[at + right] * fr;
  const double upper = v[at + up] * (1 - fr) + v[at + up + right] * fr;
  return lower * (1 - fz) + upper * fz;
}

[[gnu::always_inline]] inline double root_with_form(const TipTable& t, double m, double x, double y,
                                                    double z) {
  const double form = x * (t.q[0] * x + 2 * (t.q[3] * y + t.q[4] * z + t.b[0])) +
                      y * (t.q[1] * y + 2 * (t.q[5] * z + t.b[1])) + z * (t.q[2] * z + 2 * t.b[2]) + t.c;
  const double sum = m * m + (form < 0 ? 0 : form);
  return __builtin_sqrt(sum);
}

void of_form(const TipTable& t, const double* x, const double* y, const double* z, double* values,
             std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) values[i] = root_with_form(t, 0, x[i], y[i], z[i]);
}

void axisymmetric(const TipTable& table, const double* x, const double* y, const double* z, double* values,
                  std::size_t count) {
  const TipTable t = table;
  const int up = static_cast<int>(t.radii);
#pragma GCC ivdep
  for (std::size_t i = 0; i < count; ++i) {
    double fr, fz;
    const double r = __builtin_sqrt(x[i] * x[i] + y[i] * y[i]);
    const int ir = cell(r * t.radii_per_length, t.radii, fr);
    const int iz = cell((z[i] - t.lowest) * t.heights_per_length, t.heights, fz);
    values[i] = root_with_form(t, bilinear(t.values, iz * up + ir, 1, up, fr, fz), x[i], y[i], z[i]);
  }
}

void with_azimuth(const TipTable& table, const double* x, const double* y, const double* z, double* values,
                  std::size_t count) {
  const TipTable t = table;
  const int right = static_cast<int>(t.columns), up = static_cast<int>(t.radii) * right;
  const int last = right - 1;
  const double bins = static_cast<double>(t.bins) / 4;
#pragma GCC ivdep
  for (std::size_t i = 0; i < count; ++i) {
    const double ax = x[i] < 0 ? -x[i] : x[i], ay = y[i] < 0 ? -y[i] : y[i];
    // A monotonic function of the azimuth, 0 to 4: its bin holds a node that is not beyond the point, and at
    // most two nodes are between them (table_of_bins).
    const double part = ay / (ax + ay + 1e-300);
    const double half = x[i] < 0 ? 2 - part : part;
    const double place = y[i] < 0 ? 4 - half : half;
    int j = t.node_of_bin[static_cast<int>(place * bins)];
    for (int correction = 0; correction < 2; ++correction) {
      const double beyond = t.node_cos[j + 1] * y[i] - t.node_sin[j + 1] * x[i];
      j = beyond > 0 ? j + 1 : j;
      j = j == last ? 0 : j;
    }
    const double c0 = t.node_cos[j], s0 = t.node_sin[j], c1 = t.node_cos[j + 1], s1 = t.node_sin[j + 1];
    const double det = c0 * s1 - s0 * c1;
    double w0 = (x[i] * s1 - y[i] * c1) / det, w1 = (c0 * y[i] - s0 * x[i]) / det;
    w0 = w0 < 0 ? 0 : w0;
    w1 = w1 < 0 ? 0 : w1;
    const double r = w0 + w1, f = w1 / (r + 1e-300);
    double fr, fz;
    const int ir = cell(r * t.radii_per_length, t.radii, fr);
    const int iz = cell((z[i] - t.lowest) * t.heights_per_length, t.heights, fz);
    const int at = iz * up + ir * right + j;
    const double m = bilinear(t.values, at, right, up, fr, fz) * (1 - f) +
                     bilinear(t.values, at + 1, right, up, fr, fz) * f;
    values[i] = root_with_form(t, m, x[i], y[i], z[i]);
  }
}

void evaluate(const TipTable& t, const double* x, const double* y, const double* z, double* values,
              std::size_t count) {
  if (!t.values)
    of_form(t, x, y, z, values, count);
  else if (t.columns == 1)
    axisymmetric(t, x, y, z, values, count);
  else
    with_azimuth(t, x, y, z, values, count);
}

}  // namespace

template <>
const TipKernels& compiled_kernels<TipKernels, lanes::compiled_set>() {
  static constexpr TipKernels kernels{evaluate};
  return kernels;
}

}  // namespace qerr
