// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

#include "nacelle/base/bytes.hpp"

namespace nacelle::record {

/// How the records of a chunk are stored.
enum class Compression : std::uint8_t { None, Lz4, Zstd };
/// MCAP's name: "", "lz4", "zstd".
[[nodiscard]] const char* mcap_name(Compression compression);
[[nodiscard]] std::optional<Compression> compression_of(std::string_view mcap_name);

/// Compresses whole chunks. LZ4 writes frames, as MCAP demands; both use their library's fastest usual level (LZ4 0, zstd 1).
///
/// Threads: one. Allocates: its context when it is made, and where `out` grows.
class Compressor {
 public:
  explicit Compressor(Compression compression);
  Compressor(const Compressor&) = delete;
  Compressor& operator=(const Compressor&) = delete;
  ~Compressor();

  [[nodiscard]] Compression compression() const { return compression_; }
  /// Appends the compressed bytes to `out`. Errors: false if the library refuses; `out` is then as before.
  [[nodiscard]] bool append(ByteView bytes, Bytes& out);

 private:
  const Compression compression_;
  void* context_ = nullptr;
};

/// Replaces the content of `out` by the uncompressed bytes, exactly `size` of them. Errors: false for anything else than whole, valid
/// frames of that size; memory beyond `size` is never asked for.
[[nodiscard]] bool uncompress(Compression compression, ByteView bytes, std::size_t size, Bytes& out);

/// CRC-32 of zlib (reflected EDB88320), continued from `crc`; 0 begins.
[[nodiscard]] std::uint32_t crc32_of(ByteView bytes, std::uint32_t crc = 0);

}  // namespace nacelle::record
