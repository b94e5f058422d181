// SPDX-License-Identifier: Apache-2.0
#include "control/frame.hpp"

namespace nacelle::control {
namespace {

std::uint32_t load_length(const std::uint8_t* at) {
  return static_cast<std::uint32_t>(at[0]) | static_cast<std::uint32_t>(at[1]) << 8 |
         static_cast<std::uint32_t>(at[2]) << 16 | static_cast<std::uint32_t>(at[3]) << 24;
}

}  // namespace

bool is_known(FrameKind kind) {
  switch (kind) {
    case FrameKind::Request:
    case FrameKind::Reply:
    case FrameKind::Item:
    case FrameKind::OpenWriter:
    case FrameKind::Opened:
    case FrameKind::Publish:
    case FrameKind::Lookup:
    case FrameKind::Transform:
    case FrameKind::Stats:
    case FrameKind::Shutdown:
    case FrameKind::Fault: return true;
  }
  return false;
}

const char* to_text(FrameFault fault) {
  switch (fault) {
    case FrameFault::TooLong: return "the frame is longer than this side accepts";
    case FrameFault::UnknownKind: return "the frame's kind is unknown; is the other side of the same version?";
  }
  return "?";
}

Result<std::optional<Frame>, FrameFault> FrameReader::next() {
  if (pending() < kFrameHeaderBytes) return std::optional<Frame>{};
  const std::uint8_t* const at = buffer_.waiting().data();
  const std::size_t length = load_length(at);
  if (length > longest_payload_) return err(FrameFault::TooLong);
  const auto kind = static_cast<FrameKind>(at[4]);
  if (!is_known(kind)) return err(FrameFault::UnknownKind);
  if (pending() < kFrameHeaderBytes + length) return std::optional<Frame>{};
  buffer_.use(kFrameHeaderBytes + length);
  return std::optional<Frame>{Frame{kind, ByteView{at + kFrameHeaderBytes, length}}};
}

std::size_t begin_frame(std::string& out, FrameKind kind) {
  const std::size_t begin = out.size();
  out.append(4, '\0');
  out.push_back(static_cast<char>(kind));
  return begin;
}

void end_frame(std::string& out, std::size_t begin) {
  const std::size_t length = out.size() - begin - kFrameHeaderBytes;
  for (unsigned i = 0; i < 4; ++i) out[begin + i] = static_cast<char>(length >> (8 * i));
}

void append_frame(std::string& out, FrameKind kind, std::string_view payload) {
  const std::size_t begin = begin_frame(out, kind);
  out.append(payload);
  end_frame(out, begin);
}

}  // namespace nacelle::control
