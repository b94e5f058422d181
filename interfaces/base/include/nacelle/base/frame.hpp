// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>

#include "nacelle/base/bytes.hpp"
#include "nacelle/base/receive_buffer.hpp"
#include "nacelle/base/result.hpp"

// How a byte stream between two processes is cut into messages.
//
//   offset  bytes  a frame
//        0      4  length of the payload, little-endian
//        4      1  kind
//        5      n  payload
//
// A protocol has an enum of one byte as its Kind, with `bool is_known(Kind)` beside it, and an enum of faults that has TooLong and
// UnknownKind.
namespace nacelle {

inline constexpr std::size_t kFrameHeaderBytes = 5;

/// One frame; the payload lies in the reader's buffer and stays there until the reader is fed again.
template <typename Kind>
struct FrameView {
  Kind kind{};
  ByteView payload;
};

/// Cuts a stream of bytes into frames.
///
/// Threads: one at a time. Allocates: until its buffer has the size of the longest frame seen; never more than the limit.
template <typename Kind, typename Fault>
class FrameReader {
 public:
  explicit FrameReader(std::size_t longest_payload)
      : longest_payload_(longest_payload), buffer_(kFrameHeaderBytes + longest_payload) {}

  /// Where the next bytes go; never empty. Call filled() with how many came.
  [[nodiscard]] ByteSpan room() { return buffer_.room(); }
  void filled(std::size_t bytes) { buffer_.filled(bytes); }
  /// Drops what has come; the memory stays.
  void forget() { buffer_.clear(); }
  /// Bytes of a frame that has begun.
  [[nodiscard]] std::size_t pending() const { return buffer_.waiting().size(); }

  /// Returns the next whole frame, or nothing if more bytes are needed. After a fault nothing is readable any more.
  /// `refusal(kind)` is called for each header, before the payload has come: a fault, or nothing to accept the frame.
  template <typename Refusal>
  [[nodiscard]] Result<std::optional<FrameView<Kind>>, Fault> next(Refusal&& refusal) {
    const ByteView waiting = buffer_.waiting();
    if (waiting.size() < kFrameHeaderBytes) return std::optional<FrameView<Kind>>{};
    std::size_t length = 0;
    for (unsigned i = 0; i < 4; ++i) length |= static_cast<std::size_t>(waiting[i]) << (8 * i);
    const auto kind = static_cast<Kind>(waiting[4]);
    if (!is_known(kind)) return err(Fault::UnknownKind);
    if (const std::optional<Fault> fault = refusal(kind)) return err(*fault);
    if (length > longest_payload_) return err(Fault::TooLong);
    if (waiting.size() < kFrameHeaderBytes + length) return std::optional<FrameView<Kind>>{};
    buffer_.use(kFrameHeaderBytes + length);
    return std::optional{FrameView<Kind>{kind, waiting.subspan(kFrameHeaderBytes, length)}};
  }
  [[nodiscard]] Result<std::optional<FrameView<Kind>>, Fault> next() {
    return next([](Kind) { return std::optional<Fault>{}; });
  }

 private:
  std::size_t longest_payload_;
  ReceiveBuffer buffer_;
};

/// Begins a frame at the end of `out`, a string or Bytes: append the payload, then call end_frame() with what this returns.
template <typename Out, typename Kind>
[[nodiscard]] std::size_t begin_frame(Out& out, Kind kind) {
  const std::size_t begin = out.size();
  out.resize(begin + kFrameHeaderBytes);
  out.back() = static_cast<typename Out::value_type>(kind);
  return begin;
}
template <typename Out>
void end_frame(Out& out, std::size_t begin) {
  const std::size_t length = out.size() - begin - kFrameHeaderBytes;
  for (unsigned i = 0; i < 4; ++i) out[begin + i] = static_cast<typename Out::value_type>(length >> (8 * i));
}
/// Appends a whole frame. Allocates: if `out` must grow.
template <typename Out, typename Kind>
void append_frame(Out& out, Kind kind, std::string_view payload) {
  const std::size_t begin = begin_frame(out, kind);
  out.insert(out.end(), payload.begin(), payload.end());
  end_frame(out, begin);
}

}  // namespace nacelle
