// SPDX-License-Identifier: Apache-2.0
#include "topology/streams.hpp"

#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <geometry_msgs/msg/twist_stamped.hpp>
#include <nacelle_bench_msgs/msg/stamped9_float32.hpp>
#include <nacelle_bench_msgs/msg/stamped_bytes.hpp>
#include <nav_msgs/msg/odometry.hpp>
#include <sensor_msgs/msg/image.hpp>
#include <sensor_msgs/msg/imu.hpp>
#include <sensor_msgs/msg/laser_scan.hpp>
#include <tf2_msgs/msg/tf_message.hpp>

namespace nacelle::bench {
namespace {

// What a driver sets in every message; payloads are resized once, and written only where the graph says so.
template <typename T>
void set(T& message, std::size_t bytes, bool filled) {
  if constexpr (requires { message.stamp; }) {
    ++message.stamp.nanosec;
  } else if constexpr (requires { message.header; }) {
    ++message.header.stamp.nanosec;
  }
  if constexpr (requires { message.data.resize(bytes); }) {
    if (message.data.size() != bytes) message.data.resize(bytes);
    if (filled) std::memset(message.data.data(), static_cast<int>(bytes & 0x7F), bytes);
  } else if constexpr (requires { message.ranges; }) {
    if (message.ranges.size() != bytes / sizeof(float)) message.ranges.resize(bytes / sizeof(float));
  } else if constexpr (requires { message.transforms; }) {
    if (message.transforms.empty()) message.transforms.resize(1);
    ++message.transforms[0].header.stamp.nanosec;
  }
}

template <typename T>
class TypedStream final : public StreamType {
 public:
  std::shared_ptr<void> make_source(Node& node, const Source& source, Tally& tally) const override {
    auto publisher = node.create_publisher<T>(source.topic, QoS(10));
    return node.create_wall_timer(source.period, [publisher, bytes = source.bytes, filled = source.filled, &tally] {
      Loan<T> message = publisher->borrow();
      set(*message, bytes, filled);
      publisher->publish(std::move(message));
      tally.published();
    });
  }
  std::shared_ptr<void> make_sink(Node& node, const Sink& sink, ReaderState& state) const override {
    return node.create_subscription<T>(sink.topic, QoS(10), [&state](const T&, const MessageInfo& info) {
      state.on_message(info.source_time, info.sequence);
    });
  }
  const msgs::MessageType& type() const override { return T::message_type(); }
  std::unique_ptr<BareMessage> make_bare(const Source& source) const override {
    class Made final : public BareMessage {
     public:
      Made(std::size_t bytes, bool filled) : bytes_(bytes), filled_(filled) {}
      void fill() override { set(message_, bytes_, filled_); }

     private:
      const std::size_t bytes_;
      const bool filled_;
      T message_;
    };
    return std::make_unique<Made>(source.bytes, source.filled);
  }
};

template <typename T>
const StreamType& typed() {
  static const TypedStream<T> type;
  return type;
}

}  // namespace

const StreamType& stream_type(const std::string& name) {
  if (name == "stamped9_float32") return typed<nacelle_bench_msgs::msg::Stamped9Float32>();
  if (name == "bytes") return typed<nacelle_bench_msgs::msg::StampedBytes>();
  if (name == "sensor_msgs/msg/Image") return typed<sensor_msgs::msg::Image>();
  if (name == "sensor_msgs/msg/LaserScan") return typed<sensor_msgs::msg::LaserScan>();
  if (name == "sensor_msgs/msg/Imu") return typed<sensor_msgs::msg::Imu>();
  if (name == "nav_msgs/msg/Odometry") return typed<nav_msgs::msg::Odometry>();
  if (name == "tf2_msgs/msg/TFMessage") return typed<tf2_msgs::msg::TFMessage>();
  if (name == "geometry_msgs/msg/TwistStamped") return typed<geometry_msgs::msg::TwistStamped>();
  std::fprintf(stderr, "topology: no type '%s' here\n", name.c_str());
  std::exit(2);
}

}  // namespace nacelle::bench
