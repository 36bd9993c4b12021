#include "report/page/png.hpp"

#include <algorithm>

namespace qerr::page {

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

/// Bits, the lowest first, as deflate packs them.
class BitWriter {
 public:
  void number(std::uint32_t value, int bits) {
    for (int i = 0; i < bits; ++i) bit(value >> i & 1);
  }
  /// A Huffman code: its highest bit comes first.
  void code(std::uint32_t value, int bits) {
    for (int i = bits - 1; i >= 0; --i) bit(value >> i & 1);
  }
  /// Pads the last byte.
  std::string bytes() const { return used_ == 0 ? bytes_ : bytes_ + static_cast<char>(last_); }

 private:
  void bit(std::uint32_t value) {
    last_ |= value << used_;
    if (++used_ < 8) return;
    bytes_ += static_cast<char>(last_);
    last_ = 0, used_ = 0;
  }
  std::string bytes_;
  std::uint32_t last_ = 0;
  int used_ = 0;
};

/// RFC 1951, section 3.2.6.
void write_literal(BitWriter& out, unsigned value) {
  if (value < 144)
    out.code(0x30 + value, 8);
  else
    out.code(0x190 + value - 144, 9);
}

/// A repetition of the last byte, 3 to 258 times: section 3.2.5.
void write_run(BitWriter& out, unsigned length) {
  unsigned symbol = 285, extra_bits = 0, base = 258;
  if (length < 258) {
    // Symbols 257 to 264 stand for one length each; then every four have one more bit.
    base = 3, symbol = 257;
    for (unsigned step = 0; base + (1u << extra_bits) <= length; ++step) {
      base += 1u << extra_bits;
      ++symbol;
      if (step >= 7 && (step - 7) % 4 == 0) ++extra_bits;
    }
  }
  if (symbol < 280)
    out.code(symbol - 256, 7);
  else
    out.code(0xC0 + symbol - 280, 8);
  out.number(length - base, static_cast<int>(extra_bits));
  out.code(0, 5);  // distance 1
}

std::string deflated(std::string_view bytes) {
  constexpr std::size_t longest = 258, shortest_run = 3;
  BitWriter out;
  out.number(1, 1);  // the last block
  out.number(1, 2);  // with the fixed code
  for (std::size_t at = 0; at < bytes.size();) {
    std::size_t run = 0;
    while (at > 0 && run < longest && at + run < bytes.size() && bytes[at + run] == bytes[at - 1]) ++run;
    if (run >= shortest_run) {
      write_run(out, static_cast<unsigned>(run));
      at += run;
    } else {
      write_literal(out, static_cast<unsigned char>(bytes[at++]));
    }
  }
  out.code(0, 7);  // end of the block
  return out.bytes();
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
         chunk("IDAT", "\x78\x01" + deflated(rows) + big_endian(adler(rows))) + chunk("IEND", "");
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

}  // namespace qerr::page
