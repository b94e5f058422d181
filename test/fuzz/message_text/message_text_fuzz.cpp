// SPDX-License-Identifier: Apache-2.0
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <geometry_msgs/msg/twist_stamped.hpp>
#include <sensor_msgs/msg/joint_state.hpp>
#include <string>
#include <string_view>

#include "nacelle/msgs/json.hpp"
#include "text/message_text.hpp"

namespace {

using namespace nacelle;

// The law: a problem that says something, or a message that can be shown; never a crash.
template <typename T>
void read(std::string_view text) {
  const auto json = text::read_message_text(text, T::message_type(), WallTime{});
  if (!json) {
    if (json.error().what.empty()) std::abort();
    return;
  }
  T message;
  const auto done = msgs::from_json(json.value().json, T::message_type(), &message);
  if (!done) {
    if (done.error().what.empty()) std::abort();
    return;
  }
  std::string shown;
  text::append_repr(shown, T::message_type(), &message);
  if (shown.empty()) std::abort();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view text{reinterpret_cast<const char*>(data), size};
  read<geometry_msgs::msg::TwistStamped>(text);
  read<sensor_msgs::msg::JointState>(text);
  return 0;
}
