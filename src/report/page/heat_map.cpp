#include <algorithm>
#include <array>
#include <cmath>

#include "qerr/core/quantity.hpp"
#include "report/page/page.hpp"

namespace qerr::page {
const std::array<Colour, 9> cividis{{{0, 34, 78},
                                     {26, 56, 111},
                                     {64, 77, 107},
                                     {95, 98, 109},
                                     {125, 124, 120},
                                     {155, 145, 119},
                                     {188, 173, 108},
                                     {221, 202, 89},
                                     {254, 232, 56}}};

namespace {

std::uint32_t crc(std::string_view bytes) {
  std::uint32_t c = ~0u;
  for (const char byte : bytes) {
    c ^= static_cast<unsigned char>(byte);
    for (int k = 0; k < 8; ++k) c = c & 1 ? 0xEDB88320u ^ (c >> 1) : c >> 1;
  }
  return ~c;
}

std::uint32_t adler(std::string_view bytes) {
  constexpr std::uint32_t modulus = 65521;
  std::uint32_t a = 1, b = 0;
  for (const char byte : bytes) {
    a = (a + static_cast<unsigned char>(byte)) % modulus;
    b = (b + a) % modulus;
  }
  return b << 16 | a;
}

std::string big_endian(std::uint32_t value) {
  std::string out;
  for (int shift = 24; shift >= 0; shift -= 8) out += static_cast<char>(value >> shift & 0xFF);
  return out;
}

std::string chunk(const std::string& type, const std::string& data) {
  const std::string body = type + data;
  return big_endian(static_cast<std::uint32_t>(data.size())) + body + big_endian(crc(body));
}

/// The bytes in blocks that are not compressed (RFC 1951, section 3.2.4): neighbouring cells are hardly ever
/// equal, so that runs and fixed codes take 1 % less of a page.
std::string stored(std::string_view bytes) {
  constexpr std::size_t longest = 0xFFFF;
  std::string out;
  do {
    const std::string_view block = bytes.substr(0, longest);
    bytes.remove_prefix(block.size());
    out += bytes.empty() ? '\1' : '\0';
    for (const std::size_t length : {block.size(), ~block.size()})
      for (const int shift : {0, 8}) out += static_cast<char>(length >> shift & 0xFF);
    out += block;
  } while (!bytes.empty());
  return out;
}

constexpr double bar_left = 328, bar_right = 342, top_edge = top_margin,
                 bottom_edge = picture_height - bottom_margin;

std::vector<Colour> palette() {
  std::vector<Colour> colours{{0, 0, 0}};
  for (int i = 0; i < heat_steps; ++i) {
    const double at = static_cast<double>(i) / (heat_steps - 1) * (cividis.size() - 1);
    const std::size_t k = std::min(static_cast<std::size_t>(at), cividis.size() - 2);
    Colour& c = colours.emplace_back();
    for (std::size_t part = 0; part < 3; ++part)
      c[part] = static_cast<std::uint8_t>(
          std::lround(std::lerp(cividis[k][part], cividis[k + 1][part], at - static_cast<double>(k))));
  }
  return colours;
}

std::uint8_t index_of(double value, double from, double to) {
  if (!std::isfinite(value)) return 0;
  return static_cast<std::uint8_t>(1 + std::lround((value - from) / (to - from) * (heat_steps - 1)));
}

std::string image(const std::string& style, double left, double top, double right, double bottom,
                  const std::string& attributes, const std::string& file) {
  return "<image class=\"" + style + "\" preserveAspectRatio=\"none\" x=\"" + drawn(left) + "\" y=\"" +
         drawn(top) + "\" width=\"" + drawn(right - left) + "\" height=\"" + drawn(bottom - top) + '"' +
         attributes + " href=\"data:image/png;base64," + base64(file) + "\"/>";
}

/// The area of the map: it ends before the colour bar. With equal scales the longer span fills its axis.
PictureFrame frame_of(const HeatMap& m) {
  constexpr double end = bar_left - 16;
  auto [x0, x1] = m.x_span;
  auto [y0, y1] = m.y_span;
  if (!m.equal_scales) return framed(unrounded(m.x, x0, x1), unrounded(m.y, y0, y1), end);
  const double tall = bottom_edge - top_edge;
  PictureFrame f = framed({}, unrounded(m.y, y0, y1), end);
  const double scale = std::max((x1 - x0) / (f.right - f.left), (y1 - y0) / tall);
  const double more_x = 0.5 * (scale * (f.right - f.left) - (x1 - x0)),
               more_y = 0.5 * (scale * tall - (y1 - y0));
  f = framed({}, unrounded(m.y, y0 - more_y, y1 + more_y), end);
  f.x = unrounded(m.x, x0 - more_x, x1 + more_x);
  return f;
}

PictureFrame beside_bar(PictureFrame f) {
  f.title_room = 0.4 * picture_width;
  return f;
}

/// The scale of the values, with its title above.
std::string colour_bar(const Axis& a) {
  std::vector<std::uint8_t> column;
  for (int i = heat_steps; i > 0; --i) column.push_back(static_cast<std::uint8_t>(i));
  std::string out = image("cells scale", bar_left, top_edge, bar_right, bottom_edge, "",
                          png(1, column.size(), column, palette())) +
                    "<path class=\"edge\" d=\"M" + drawn(bar_left) + ' ' + drawn(top_edge) + 'H' +
                    drawn(bar_right) + 'V' + drawn(bottom_edge) + 'H' + drawn(bar_left) + "Z\"/>";
  for (const Tick& t : a.ticks)
    out += drawn_text(bar_right + 4, bottom_edge - a.part(t.value) * (bottom_edge - top_edge) + 3.5, "tick",
                      t.label);
  return out + drawn_text(picture_width - 4, 11, "label end", fitted(a.title, 0.55 * picture_width, 11));
}

std::string span_attribute(const HeatMap& m) {
  return " data-span=\"" + shortest(m.x_span.first) + ' ' + shortest(m.x_span.second) + ' ' +
         shortest(m.y_span.first) + ' ' + shortest(m.y_span.second) + '"';
}

}  // namespace

std::string png(std::size_t width, std::size_t height, const std::vector<std::uint8_t>& pixels,
                const std::vector<Colour>& palette) {
  std::string rows, colours;
  for (std::size_t r = 0; r < height; ++r) {
    rows += '\0';  // without a row filter: indices are no intensities
    for (std::size_t c = 0; c < width; ++c) rows += static_cast<char>(pixels[r * width + c]);
  }
  for (const Colour& colour : palette)
    for (const std::uint8_t part : colour) colours += static_cast<char>(part);
  const std::string header = big_endian(static_cast<std::uint32_t>(width)) +
                             big_endian(static_cast<std::uint32_t>(height)) +
                             std::string{8, 3, 0, 0, 0};  // bits, palette, deflate, filters, not interlaced
  return "\x89PNG\r\n\x1a\n" + chunk("IHDR", header) + chunk("PLTE", colours) +
         chunk("tRNS", std::string(1, '\0')) +
         chunk("IDAT", "\x78\x01" + stored(rows) + big_endian(adler(rows))) + chunk("IEND", "");
}

std::string base64(std::string_view bytes) {
  constexpr std::string_view digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  for (std::size_t at = 0; at < bytes.size(); at += 3) {
    const std::size_t count = std::min<std::size_t>(3, bytes.size() - at);
    std::uint32_t group = 0;
    for (std::size_t i = 0; i < 3; ++i)
      group = group << 8 | (i < count ? static_cast<unsigned char>(bytes[at + i]) : 0u);
    for (std::size_t i = 0; i < 4; ++i) out += i <= count ? digits[group >> (18 - 6 * i) & 63] : '=';
  }
  return out;
}

std::string figure(const HeatMap& m) {
  double low = INFINITY, high = -INFINITY;
  for (const double v : m.cells)
    if (std::isfinite(v)) low = std::min(low, v), high = std::max(high, v);
  if (!(low <= high)) low = 0, high = 1;
  const Axis scale = axis(m.value, low, high, 6);
  std::vector<std::uint8_t> pixels;
  for (std::size_t r = m.rows; r-- > 0;)
    for (std::size_t c = 0; c < m.columns; ++c)
      pixels.push_back(index_of(m.cells[r * m.columns + c], scale.from, scale.to));
  const PictureFrame f = beside_bar(frame_of(m));
  const auto [x0, x1] = m.x_span;
  const auto [y0, y1] = m.y_span;
  return figure_begin(m.title, m.description, m.x, m.y) + drawn_axes(f) +
         image("cells", f.at_x(x0), f.at_y(y1), f.at_x(x1), f.at_y(y0),
               data_attribute("data-from", scale.from) + data_attribute("data-to", scale.to) +
                   span_attribute(m) + " data-unit=\"" + escaped_markup(m.value.unit) + '"',
               png(m.columns, m.rows, pixels, palette())) +
         colour_bar(scale) + "</svg></figure>\n";
}

}  // namespace qerr::page
