#include "bound/proven/kernels.hpp"
#include "lanes/select_kernels.hpp"

namespace qerr {

namespace {

[[gnu::always_inline]] inline float magnitude(float v) { return v < 0 ? -v : v; }

template <int count>
void raise_cone_row(const ConeSum& sum, float a, float* values) {
  const ConeSum s = sum;
  const int nodes = s.nodes, middle = (nodes - 1) / 2, center = middle * nodes + middle;
  const float cells = static_cast<float>(middle), step = 1 / cells, most = cells - 1;
  const float height_a = 1 - magnitude(a);
#pragma GCC ivdep
  for (int node = 0; node < nodes; ++node) {
    const float b = static_cast<float>(node - middle) * step;
    const float height_b = 1 - magnitude(b);
    const float height = height_a < height_b ? height_a : height_b;
    const float t = s.root * height;
    float total = s.value_a * a + s.value_b * b + s.value_s * height;
    for (int j = 0; j < count; ++j) {
      const float r = s.row_a[j] * a + s.row_b[j] * b + s.row_s[j] * height;
      const float c = s.column_a[j] * a + s.column_b[j] * b + s.column_s[j] * height;
      const float ar = magnitude(r), ac = magnitude(c);
      const float norm = (ar > ac ? ar : ac) + t + 1e-30f;
      const float scale = cells / norm;
      const float pr = ar * scale, pc = ac * scale;
      float ir = static_cast<float>(static_cast<int>(pr)), ic = static_cast<float>(static_cast<int>(pc));
      ir = ir > most ? most : ir;
      ic = ic > most ? most : ic;
      const float fr = pr - ir, fc = pc - ic;
      const int to_r = r < 0 ? -nodes : nodes, to_c = c < 0 ? -1 : 1;
      const int at = center + static_cast<int>(ir) * to_r + static_cast<int>(ic) * to_c;
      const int side = at + (fr < fc ? to_c : to_r);
      const float high = fr < fc ? fc : fr, low = fr < fc ? fr : fc;
      const float* table = s.table[j];
      const float value = table[at] * (1 - high) + table[side] * (high - low) + table[at + to_r + to_c] * low;
      total += s.weight[j] * norm * value;
    }
    values[node] = values[node] < total ? total : values[node];
  }
}

void raise_cone(const ConeSum& sum, int first, int last, float* values) {
  const int middle = (sum.nodes - 1) / 2;
  for (int node = first; node < last; ++node) {
    const float a = static_cast<float>(node - middle) * (1 / static_cast<float>(middle));
    float* row = values + node * sum.nodes;
    if (sum.count == 0)
      raise_cone_row<0>(sum, a, row);
    else if (sum.count == 1)
      raise_cone_row<1>(sum, a, row);
    else if (sum.count == 2)
      raise_cone_row<2>(sum, a, row);
    else
      raise_cone_row<3>(sum, a, row);
  }
}

}  // namespace

template <>
const ConeKernels& compiled_kernels<ConeKernels, lanes::compiled_set>() {
  static constexpr ConeKernels kernels{raise_cone};
  return kernels;
}

namespace {

template <int count>
void raise_row(const SliceSum& sum, float a, int begin, int end, float* values) {
  const SliceSum s = sum;
  float row[3], column[3];
  for (int j = 0; j < count; ++j) {
    row[j] = s.row_0[j] + a * s.row_a[j];
    column[j] = s.column_0[j] + a * s.column_a[j];
  }
  const float value = s.value_0 + a * s.value_a;
  const int nodes = s.table_nodes;
  const float most = static_cast<float>(nodes - 2);
#pragma GCC ivdep
  for (int b = begin; b < end; ++b) {
    const float at = static_cast<float>(b);
    float total = value + at * s.value_b;
    for (int j = 0; j < count; ++j) {
      float r = row[j] + at * s.row_b[j], c = column[j] + at * s.column_b[j];
      r = r < 0 ? 0 : r;
      c = c < 0 ? 0 : c;
      float ri = static_cast<float>(static_cast<int>(r)), ci = static_cast<float>(static_cast<int>(c));
      ri = ri > most ? most : ri;
      ci = ci > most ? most : ci;
      const float fr = r - ri, fc = c - ci;
      const int i = static_cast<int>(ri) * nodes + static_cast<int>(ci);
      const float* t = s.table[j];
      const float lower = t[i] + fc * (t[i + 1] - t[i]);
      const float upper = t[i + nodes] + fc * (t[i + nodes + 1] - t[i + nodes]);
      total += s.weight[j] * (lower + fr * (upper - lower));
    }
    values[b] = values[b] < total ? total : values[b];
  }
}

void raise(const SliceSum& sum, const SliceNodes& nodes, float* values) {
  for (int a = 0; a < nodes.nodes; ++a) {
    float* row = values + a * nodes.nodes;
    const float at = static_cast<float>(a);
    if (sum.count == 0)
      raise_row<0>(sum, at, nodes.begin[a], nodes.end[a], row);
    else if (sum.count == 2)
      raise_row<2>(sum, at, nodes.begin[a], nodes.end[a], row);
    else
      raise_row<3>(sum, at, nodes.begin[a], nodes.end[a], row);
  }
}

}  // namespace

template <>
const SliceKernels& compiled_kernels<SliceKernels, lanes::compiled_set>() {
  static constexpr SliceKernels kernels{raise};
  return kernels;
}

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
