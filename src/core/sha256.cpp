#include "core/sha256.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

namespace qerr {

namespace {

using Words = std::array<std::uint32_t, 64>;

/// The first 32 bits of the fractional parts of the cube roots of the first 64 primes (FIPS 180-4, 4.2.2).
const Words& round_constants() {
  static const Words constants = [] {
    Words k{};
    std::size_t found = 0;
    for (std::uint32_t n = 2; found < k.size(); ++n) {
      bool prime = true;
      for (std::uint32_t d = 2; d * d <= n; ++d) prime = prime && n % d != 0;
      if (!prime) continue;
      // 35 bits suffice, since no root is close to a multiple of 2^-32.
      const long double root = std::cbrt(static_cast<long double>(n));
      k[found++] = static_cast<std::uint32_t>((root - std::floor(root)) * 0x1p32L);
    }
    return k;
  }();
  return constants;
}

void absorb(std::array<std::uint32_t, 8>& state, const unsigned char* block) {
  Words w{};
  for (std::size_t i = 0; i < 16; ++i)
    w[i] = std::uint32_t(block[4 * i]) << 24 | std::uint32_t(block[4 * i + 1]) << 16 |
           std::uint32_t(block[4 * i + 2]) << 8 | std::uint32_t(block[4 * i + 3]);
  for (std::size_t i = 16; i < 64; ++i) {
    const std::uint32_t s0 = std::rotr(w[i - 15], 7) ^ std::rotr(w[i - 15], 18) ^ (w[i - 15] >> 3);
    const std::uint32_t s1 = std::rotr(w[i - 2], 17) ^ std::rotr(w[i - 2], 19) ^ (w[i - 2] >> 10);
    w[i] = w[i - 16] + s0 + w[i - 7] + s1;
  }
  auto [a, b, c, d, e, f, g, h] = state;
  for (std::size_t i = 0; i < 64; ++i) {
    const std::uint32_t s1 = std::rotr(e, 6) ^ std::rotr(e, 11) ^ std::rotr(e, 25);
    const std::uint32_t t1 = h + s1 + ((e & f) ^ (~e & g)) + round_constants()[i] + w[i];
    const std::uint32_t s0 = std::rotr(a, 2) ^ std::rotr(a, 13) ^ std::rotr(a, 22);
    const std::uint32_t t2 = s0 + ((a & b) ^ (a & c) ^ (b & c));
    h = g, g = f, f = e, e = d + t1, d = c, c = b, b = a, a = t1 + t2;
  }
  const std::array<std::uint32_t, 8> change{a, b, c, d, e, f, g, h};
  for (std::size_t i = 0; i < 8; ++i) state[i] += change[i];
}

}  // namespace

void Sha256::add(std::string_view bytes) {
  size_ += bytes.size();
  constexpr std::size_t block = 64;
  const auto take = [&](std::string_view whole) {
    for (std::size_t at = 0; at + block <= whole.size(); at += block)
      absorb(state_, reinterpret_cast<const unsigned char*>(whole.data()) + at);
  };
  if (!rest_.empty()) {
    const std::size_t missing = std::min(block - rest_.size(), bytes.size());
    rest_.append(bytes.substr(0, missing));
    bytes.remove_prefix(missing);
    if (rest_.size() < block) return;
    take(rest_);
  }
  take(bytes);
  rest_ = bytes.substr(bytes.size() / block * block);
}

std::string Sha256::digest() const {
  Sha256 padded = *this;
  std::string end(1, '\x80');
  while ((rest_.size() + end.size()) % 64 != 56) end += '\0';
  for (int shift = 56; shift >= 0; shift -= 8) end += static_cast<char>(size_ * 8 >> shift & 0xFF);
  padded.add(end);
  std::string hex;
  for (const std::uint32_t word : padded.state_)
    for (int shift = 28; shift >= 0; shift -= 4) hex += "0123456789abcdef"[word >> shift & 0xF];
  return hex;
}

std::string sha256(std::string_view bytes) {
  Sha256 sum;
  sum.add(bytes);
  return sum.digest();
}

}  // namespace qerr
