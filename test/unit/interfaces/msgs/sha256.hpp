// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <string>

#include "nacelle/base/bytes.hpp"

namespace nacelle::test {

/// Source: FIPS 180-4. The round constants are the first 32 bits of the fractional parts of the cube roots of the first
/// 64 primes, and are computed here with whole numbers.
class Sha256 {
 public:
  static std::string hex(std::string_view text) {
    std::string padded(text);
    padded += '\x80';
    while (padded.size() % 64 != 56) padded += '\0';
    for (int shift = 56; shift >= 0; shift -= 8) padded += static_cast<char>((8 * text.size()) >> shift);
    Sha256 sha;
    for (std::size_t at = 0; at < padded.size(); at += 64) sha.take(as_bytes(padded).subspan(at, 64));
    Bytes bytes;
    for (const std::uint32_t word : sha.state_) {
      for (const int shift : {24, 16, 8, 0}) bytes.push_back(static_cast<std::uint8_t>(word >> shift));
    }
    return to_hex(bytes);
  }

 private:
  Sha256() {
    int prime = 2;
    for (std::size_t i = 0; i < 64; ++i, ++prime) {
      while (!is_prime(prime)) ++prime;
      constants_[i] = fraction_of_root(prime, 3);
      if (i < 8) state_[i] = fraction_of_root(prime, 2);
    }
  }
  static bool is_prime(int n) {
    for (int d = 2; d * d <= n; ++d) {
      if (n % d == 0) return false;
    }
    return true;
  }
  // The largest r with r^power <= n * 2^(32 power) is the root with 32 bits behind the point.
  static std::uint32_t fraction_of_root(int n, int power) {
    std::uint64_t root = 0;
    for (int bit = 38; bit >= 0; --bit) {
      const std::uint64_t tried = root | std::uint64_t{1} << bit;
      __extension__ using Wide = unsigned __int128;
      // 39 bits at most: three of them are 117.
      const Wide power_of_it = power == 2 ? Wide{tried} * tried : Wide{tried} * tried * tried;
      if (power_of_it <= Wide{static_cast<unsigned>(n)} << (32 * power)) root = tried;
    }
    return static_cast<std::uint32_t>(root);
  }
  void take(ByteView block) {
    std::array<std::uint32_t, 64> w{};
    for (std::size_t i = 0; i < 16; ++i) {
      for (std::size_t k = 0; k < 4; ++k) w[i] = w[i] << 8 | block[4 * i + k];
    }
    for (std::size_t i = 16; i < 64; ++i) {
      const std::uint32_t a = w[i - 15], b = w[i - 2];
      w[i] = w[i - 16] + w[i - 7] + (std::rotr(a, 7) ^ std::rotr(a, 18) ^ a >> 3) +
             (std::rotr(b, 17) ^ std::rotr(b, 19) ^ b >> 10);
    }
    auto s = state_;
    for (std::size_t i = 0; i < 64; ++i) {
      const std::uint32_t sum1 = std::rotr(s[4], 6) ^ std::rotr(s[4], 11) ^ std::rotr(s[4], 25);
      const std::uint32_t choice = (s[4] & s[5]) ^ (~s[4] & s[6]);
      const std::uint32_t t1 = s[7] + sum1 + choice + constants_[i] + w[i];
      const std::uint32_t sum0 = std::rotr(s[0], 2) ^ std::rotr(s[0], 13) ^ std::rotr(s[0], 22);
      const std::uint32_t majority = (s[0] & s[1]) ^ (s[0] & s[2]) ^ (s[1] & s[2]);
      s = {t1 + sum0 + majority, s[0], s[1], s[2], s[3] + t1, s[4], s[5], s[6]};
    }
    for (std::size_t i = 0; i < 8; ++i) state_[i] += s[i];
  }
  std::array<std::uint32_t, 64> constants_{};
  std::array<std::uint32_t, 8> state_{};
};

}  // namespace nacelle::test
