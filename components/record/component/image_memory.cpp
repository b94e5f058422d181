// SPDX-License-Identifier: Apache-2.0
#include "record/component/image_memory.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "nacelle/base/buffer.hpp"

namespace nacelle::record {

bool is_image(const msgs::MessageType& type) {
  const std::string_view name = type.name;
  return name == "sensor_msgs/msg/Image" || name == "sensor_msgs/msg/CompressedImage";
}

bool is_lent(const msgs::MessageType& type, const void* message) {
  if (!type.holds_buffers) return false;
  return std::any_of(type.fields.begin(), type.fields.end(), [&](const msgs::Field& field) {
    // A sequence that can give its memory back is a Buffer.
    if (field.kind != msgs::Kind::Uint8 || field.sequence == nullptr || field.sequence->give_back == nullptr)
      return false;
    const void* const at = static_cast<const std::byte*>(message) + field.offset;
    return static_cast<const Buffer<std::uint8_t>*>(at)->is_foreign();
  });
}

}  // namespace nacelle::record
