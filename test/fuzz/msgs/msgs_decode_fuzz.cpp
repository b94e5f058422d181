// SPDX-License-Identifier: Apache-2.0
#include "nacelle/base/expect.hpp"
#include "nacelle/msgs/any_message.hpp"
#include "nacelle/msgs/json.hpp"

#include <composition_interfaces/srv/load_node.hpp>
#include <diagnostic_msgs/msg/diagnostic_array.hpp>
#include <nav2_msgs/action/follow_waypoints.hpp>
#include <rcl_interfaces/msg/parameter_event.hpp>
#include <rmw_dds_common/msg/participant_entities_info.hpp>
#include <sensor_msgs/msg/camera_info.hpp>
#include <sensor_msgs/msg/image.hpp>
#include <sensor_msgs/msg/imu.hpp>
#include <sensor_msgs/msg/joint_state.hpp>
#include <sensor_msgs/msg/point_cloud2.hpp>
#include <tf2_msgs/msg/tf_message.hpp>
#include <visualization_msgs/msg/marker_array.hpp>

namespace {

// Types that have every form of field between them. The order is part of the corpus: append only.
constexpr nacelle::msgs::MessageTypeFunction kTypes[] = {
    &tf2_msgs::msg::TFMessage::message_type,
    &sensor_msgs::msg::Image::message_type,
    &sensor_msgs::msg::PointCloud2::message_type,
    &sensor_msgs::msg::CameraInfo::message_type,
    &sensor_msgs::msg::JointState::message_type,
    &sensor_msgs::msg::Imu::message_type,
    &rcl_interfaces::msg::ParameterEvent::message_type,
    &diagnostic_msgs::msg::DiagnosticArray::message_type,
    &visualization_msgs::msg::MarkerArray::message_type,
    &rmw_dds_common::msg::ParticipantEntitiesInfo::message_type,
    &composition_interfaces::srv::LoadNode::Event::message_type,
    &nav2_msgs::action::FollowWaypoints::SendGoal::Request::message_type,
};

}  // namespace

/// The first byte picks the type, the others are the sample.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const auto& type = kTypes[data[0] % std::size(kTypes)]();
  nacelle::msgs::AnyMessage message{type};
  if (!type.decode({data + 1, size - 1}, message.get())) return 0;

  // What was accepted can be written, read again and shown.
  const nacelle::Bytes again = message.encoded();
  nacelle::msgs::AnyMessage second{type};
  NACELLE_EXPECT(type.decode(again, second.get()), "an encoded message decodes");
  NACELLE_EXPECT(second.encoded() == again, "and encodes to the same bytes");
  (void)nacelle::msgs::to_json(type, message.get());
  type.recycle(message.get());
  return 0;
}
