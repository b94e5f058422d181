// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstring>
#include <sensor_msgs/msg/image.hpp>
#include <sensor_msgs/msg/point_cloud2.hpp>
#include <tf2_msgs/msg/tf_message.hpp>
#include <vector>

#include "nacelle/base/expect.hpp"
#include "nacelle/msgs/any_message.hpp"
#include "transport_iceoryx/wire/chunk.hpp"

namespace {

constexpr nacelle::msgs::MessageTypeFunction kTypes[] = {&sensor_msgs::msg::Image::message_type,
                                                         &sensor_msgs::msg::PointCloud2::message_type,
                                                         &tf2_msgs::msg::TFMessage::message_type};

void count_back(void* context) noexcept { ++*static_cast<std::size_t*>(context); }

}  // namespace

/// The first byte picks the type and whether parts are lent, the others are the chunk, on an address as iceoryx gives it.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace nacelle;
  if (size == 0) return 0;
  const auto& type = kTypes[(data[0] & 0x7F) % std::size(kTypes)]();
  const bool lends = (data[0] & 0x80) != 0;
  std::vector<std::uint64_t> memory((size + 7) / 8);
  auto* const bytes = reinterpret_cast<std::uint8_t*>(memory.data());
  std::memcpy(bytes, data + 1, size - 1);
  const Bytes before(bytes, bytes + size - 1);

  const auto view = transport_iceoryx::read_chunk({bytes, size - 1});
  if (!view) return 0;
  std::size_t given_back = 0, kept = 0;
  std::array<msgs::LentPart, msgs::kMostParts> parts;
  for (std::size_t i = 0; i < view->parts; ++i) {
    parts[i] = {bytes + view->places[i].offset, view->places[i].bytes,
                lends ? ReleaseHook{&count_back, &given_back} : ReleaseHook{}};
  }
  {
    msgs::AnyMessage message{type};
    const auto read = msgs::decode_apart(type, view->small, {parts.data(), view->parts}, message.get());
    for (std::size_t i = 0; lends && i < view->parts; ++i) kept += parts[i].hook.release == nullptr ? 1 : 0;
    if (read) {
      // What was accepted can be written again.
      msgs::PartList list;
      Bytes again(msgs::encoded_size_apart(type, message.get(), list));
      msgs::encode_apart(type, message.get(), again.data());
      NACELLE_EXPECT(list.count >= view->parts, "what was apart is long enough to be apart again");
    }
  }
  NACELLE_EXPECT(given_back == kept, "what a message was lent it gives back once");
  NACELLE_EXPECT(std::equal(before.begin(), before.end(), bytes), "a chunk is not written to");
  return 0;
}
