// SPDX-License-Identifier: Apache-2.0
// Any bytes as the line of a BNO08x in mode RVC and as the answers of a BNO055, in any chopping: nothing crashes, every byte is
// accounted for, and the output does not depend on the chopping.
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <vector>

#include "imu/model/rvc_reader.hpp"
#include "imu/protocol/bno055_uart.hpp"

namespace {

using namespace nacelle::imu;
using nacelle::Bytes;
using nacelle::ByteView;

void require(bool holds) {
  if (!holds) std::abort();
}

template <typename Feed>
void in_parts(ByteView bytes, bool chopped, Feed&& feed) {
  for (std::size_t at = 0; at < bytes.size();) {
    const std::size_t part = chopped ? std::min<std::size_t>(bytes.size() - at, 1 + bytes[at] % 17U) : bytes.size();
    feed(bytes.subspan(at, part));
    at += part;
  }
}

std::vector<RvcFrame> rvc(ByteView bytes, bool chopped) {
  RvcDecoder decoder;
  std::vector<RvcFrame> frames;
  in_parts(bytes, chopped, [&](ByteView part) {
    decoder.feed(part, [&](const RvcFrame& frame, std::size_t after) {
      require(after < part.size());
      frames.push_back(frame);
    });
  });
  const auto& s = decoder.stats();
  require(s.bytes == bytes.size() && s.frames == frames.size());
  require(s.bytes == 19 * s.frames + s.skipped_bytes + decoder.pending());
  return frames;
}

std::vector<Bytes> bno055(ByteView bytes, bool chopped) {
  Bno055AnswerDecoder decoder;
  std::vector<Bytes> answers;
  in_parts(bytes, chopped, [&](ByteView part) {
    decoder.feed(part, [&](const Bno055Answer& answer) {
      require(answer.data.size() <= bno055_layout::kMostData);
      require(explain_bno055_status(answer.status) != nullptr);
      answers.emplace_back(answer.data.begin(), answer.data.end());
      answers.back().push_back(answer.status);
    });
  });
  const auto& s = decoder.stats();
  require(s.bytes == bytes.size() && s.answers == answers.size());
  require(s.bytes == s.answer_bytes + s.skipped_bytes + decoder.pending());
  return answers;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const ByteView bytes{data, size};
  const auto frames = rvc(bytes, false);
  require(frames == rvc(bytes, true));
  for (const auto& frame : frames) {
    const Orientation q = sample_of(frame).orientation.value();
    require(std::abs(q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z - 1.0) < 1e-9);
  }
  require(bno055(bytes, false) == bno055(bytes, true));
  return 0;
}
