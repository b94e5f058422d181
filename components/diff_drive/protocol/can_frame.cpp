// SPDX-License-Identifier: Apache-2.0
#include "diff_drive/protocol/can_frame.hpp"

#include <algorithm>
#include <cstring>

namespace nacelle::diff_drive {
namespace {

constexpr std::uint32_t kExtended = 0x80000000, kRequest = 0x40000000, kError = 0x20000000;
constexpr std::uint32_t kLongId = 0x1FFFFFFF, kShortId = 0x7FF;
constexpr std::size_t kLengthAt = 4, kDataAt = 8, kMostData = 8;
static_assert(kDataAt + kMostData == kCanRecordBytes);

}  // namespace

CanRecord to_record(const CanFrame& frame) {
  CanRecord record{};
  const std::uint32_t id = frame.id | (frame.is_extended ? kExtended : 0) | (frame.is_request ? kRequest : 0);
  std::memcpy(record.data(), &id, sizeof id);
  record[kLengthAt] = frame.length;
  std::copy_n(frame.data.begin(), std::min<std::size_t>(frame.length, kMostData), record.begin() + kDataAt);
  return record;
}

std::optional<CanFrame> from_record(ByteView record) {
  std::uint32_t id = 0;
  std::memcpy(&id, record.data(), sizeof id);
  CanFrame frame;
  frame.is_extended = (id & kExtended) != 0;
  frame.is_request = (id & kRequest) != 0;
  frame.id = id & kLongId;
  frame.length = record[kLengthAt];
  if ((id & kError) != 0 || frame.length > kMostData || (!frame.is_extended && frame.id > kShortId))
    return std::nullopt;
  if (!frame.is_request) std::copy_n(record.begin() + kDataAt, frame.length, frame.data.begin());
  return frame;
}

}  // namespace nacelle::diff_drive
