// SPDX-License-Identifier: Apache-2.0
#include "record/protocol/compression.hpp"

#include <libdeflate.h>
#include <lz4frame.h>
#include <zstd.h>

#include <cstring>
#include <memory>
#include <new>

namespace nacelle::record {

const char* mcap_name(Compression compression) {
  switch (compression) {
    case Compression::None: return "";
    case Compression::Lz4: return "lz4";
    case Compression::Zstd: return "zstd";
  }
  return "";
}

std::optional<Compression> compression_of(std::string_view name) {
  for (const auto compression : {Compression::None, Compression::Lz4, Compression::Zstd}) {
    if (name == mcap_name(compression)) return compression;
  }
  return std::nullopt;
}

Compressor::Compressor(Compression compression) : compression_(compression) {
  if (compression_ != Compression::Zstd) return;
  context_ = ::ZSTD_createCCtx();
  if (context_ == nullptr) throw std::bad_alloc{};
}

Compressor::~Compressor() {
  if (context_ != nullptr) ::ZSTD_freeCCtx(static_cast<ZSTD_CCtx*>(context_));
}

bool Compressor::append(ByteView bytes, Bytes& out) {
  const std::size_t before = out.size();
  if (compression_ == Compression::None) {
    out.insert(out.end(), bytes.begin(), bytes.end());
    return true;
  }
  const bool lz4 = compression_ == Compression::Lz4;
  out.resize(before + (lz4 ? ::LZ4F_compressFrameBound(bytes.size(), nullptr) : ::ZSTD_compressBound(bytes.size())));
  void* const to = out.data() + before;
  const std::size_t room = out.size() - before;
  const std::size_t used =
      lz4 ? ::LZ4F_compressFrame(to, room, bytes.data(), bytes.size(), nullptr)
          : ::ZSTD_compressCCtx(static_cast<ZSTD_CCtx*>(context_), to, room, bytes.data(), bytes.size(), 1);
  const bool failed = lz4 ? ::LZ4F_isError(used) != 0 : ::ZSTD_isError(used) != 0;
  out.resize(failed ? before : before + used);
  return !failed;
}

namespace {

bool uncompress_lz4(ByteView bytes, Bytes& out) {
  LZ4F_dctx* raw = nullptr;
  if (::LZ4F_isError(::LZ4F_createDecompressionContext(&raw, LZ4F_VERSION)) != 0) return false;
  const std::unique_ptr<LZ4F_dctx, decltype(&::LZ4F_freeDecompressionContext)> context{raw,
                                                                                       ::LZ4F_freeDecompressionContext};
  std::size_t written = 0, hint = 1;
  while (!bytes.empty()) {
    std::size_t taken = bytes.size(), made = out.size() - written;
    hint = ::LZ4F_decompress(raw, out.data() + written, &made, bytes.data(), &taken, nullptr);
    if (::LZ4F_isError(hint) != 0 || (taken == 0 && made == 0)) return false;
    bytes = bytes.subspan(taken);
    written += made;
  }
  return hint == 0 && written == out.size();  // 0: the frame ended
}

}  // namespace

bool uncompress(Compression compression, ByteView bytes, std::size_t size, Bytes& out) {
  // What a format can reach: LZ4 adds 255 bytes of a match for a byte, zstd has blocks of 128 KiB for four.
  const std::uint64_t most = compression == Compression::Lz4 ? 255 : compression == Compression::Zstd ? 32768 : 1;
  if (size > most * bytes.size()) return false;
  out.resize(size);
  switch (compression) {
    case Compression::None:
      if (bytes.size() != size) return false;
      if (size > 0) std::memcpy(out.data(), bytes.data(), size);
      return true;
    case Compression::Lz4: return uncompress_lz4(bytes, out);
    case Compression::Zstd: return ::ZSTD_decompress(out.data(), size, bytes.data(), bytes.size()) == size;
  }
  return false;
}

std::uint32_t crc32_of(ByteView bytes, std::uint32_t crc) {
  // Without bytes, a null pointer asks this library for its first value.
  return bytes.empty() ? crc : ::libdeflate_crc32(crc, bytes.data(), bytes.size());
}

}  // namespace nacelle::record
