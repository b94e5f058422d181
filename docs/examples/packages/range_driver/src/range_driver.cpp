// SPDX-License-Identifier: Apache-2.0
#include <charconv>
#include <chrono>
#include <limits>
#include <memory>
#include <sensor_msgs/msg/range.hpp>
#include <string>
#include <system_error>
#include <utility>

#include "nacelle/io/reader_thread.hpp"
#include "nacelle/io/serial_port.hpp"
#include "nacelle/node/component.hpp"
#include "nacelle/node/device_watch.hpp"

namespace example {

using nacelle::CallbackReturn;
using nacelle::MonotonicTime;
using nacelle::State;
using sensor_msgs::msg::Range;

/// Reads lines of a distance in millimetres ("1234\n") and publishes each as a Range, in metres. A pulled cable is an open fault; the
/// driver reopens the line by itself.
class RangeDriver final : public nacelle::LifecycleNode, public nacelle::io::ByteSink {
 public:
  explicit RangeDriver(const nacelle::NodeOptions& options) : LifecycleNode("range_driver", options) {
    nacelle::declare_device_parameters(*this);
    declare_device_use(declare_parameter("port_name", "/dev/ttyUSB0"), "port_name");
    frame_ = declare_parameter("frame_id", "range_link", {.description = "frame of the sensor", .read_only = true});
    declare_frame_use(frame_, "frame_id");
    ranges_ = create_publisher<Range>("range", nacelle::QoS(5).best_effort());
  }
  ~RangeDriver() override { close(); }

 private:
  CallbackReturn on_configure(const State&) override {
    close();  // after a fault it may still be open
    const auto device = nacelle::read_device_parameters(*this);
    if (!device) return refuse(device.error());
    const std::string path = get<std::string>("port_name");
    const nacelle::io::SerialSettings settings{path, 9600};
    auto line = device->required ? nacelle::io::SerialPort::open(settings, steady_clock())
                                 : nacelle::io::SerialPort::open_or_await(settings, steady_clock());
    if (!line) return refuse(line.error());
    line_ = std::move(line).value();
    watch_ = std::make_unique<nacelle::DeviceWatch>(*this, *device, nacelle::DeviceWatch::Settings{path},
                                                    steady_clock().now());
    if (line_->is_away()) watch_->lose(std::string{nacelle::io::explain(nacelle::io::StreamFault::NotFound)});
    reader_ = std::make_unique<nacelle::io::ReaderThread>(*line_, steady_clock(), *this,
                                                          nacelle::io::ReaderThread::Options{.name = "range_rx"});
    return CallbackReturn::SUCCESS;
  }
  CallbackReturn on_cleanup(const State&) override {
    close();
    return CallbackReturn::SUCCESS;
  }
  void close() {
    reader_.reset();  // no call into the sink from here on
    watch_.reset();
    line_.reset();
    forget();
  }
  // The first bytes of a line that is opened may be the rest of a distance.
  void forget() {
    text_.clear();
    is_whole_ = false;
  }

  // On the reading thread.
  void on_bytes(nacelle::ByteView bytes, MonotonicTime received) override {
    for (const std::uint8_t byte : bytes) {
      if (byte == '\r') continue;
      if (byte != '\n') {
        is_whole_ = is_whole_ && text_.size() < kLongestLine;
        if (is_whole_) text_.push_back(static_cast<char>(byte));
        continue;
      }
      if (!std::exchange(is_whole_, true)) {
        text_.clear();
        continue;
      }
      unsigned millimetres = 0;
      const auto [end, fault] = std::from_chars(text_.data(), text_.data() + text_.size(), millimetres);
      if (fault == std::errc{} && end == text_.data() + text_.size()) {
        watch_->heard(received);
        publish(millimetres / 1000.0F, received);
      } else {
        get_logger().warn_throttle(std::chrono::seconds{5}, "not a distance: '{}'", text_);
      }
      text_.clear();
    }
  }
  void on_silence(MonotonicTime now) override {
    watch_->look(now, [] { return std::string{"no distance came"}; });
  }
  void on_break(nacelle::io::StreamFault fault, MonotonicTime) override {
    forget();
    watch_->lose(std::string{nacelle::io::explain(fault)});
  }
  void on_return(MonotonicTime) override {}

  // Before the node is active, publish() drops the message.
  void publish(float range_m, MonotonicTime received) {
    auto range = ranges_->borrow();
    if (!range) return;
    range->header.stamp = now() - (steady_clock().now() - received);
    range->header.frame_id = frame_;
    range->radiation_type = Range::ULTRASOUND;
    range->field_of_view = 0.26F;  // rad
    range->min_range = kNearest_m;
    range->max_range = kFarthest_m;
    // REP 117: -inf is nearer than the sensor can measure, +inf farther.
    constexpr float kInfinity = std::numeric_limits<float>::infinity();
    range->range = range_m < kNearest_m ? -kInfinity : range_m > kFarthest_m ? kInfinity : range_m;
    ranges_->publish(std::move(range));
  }

  static constexpr std::size_t kLongestLine = 16;
  static constexpr float kNearest_m = 0.02F, kFarthest_m = 4.0F;
  std::string frame_;
  std::shared_ptr<nacelle::Publisher<Range>> ranges_;
  std::unique_ptr<nacelle::io::SerialPort> line_;
  std::unique_ptr<nacelle::DeviceWatch> watch_;
  std::unique_ptr<nacelle::io::ReaderThread> reader_;
  std::string text_;       // of the line so far
  bool is_whole_ = false;  // ... since the end of the line before it
};

}  // namespace example

NACELLE_REGISTER_COMPONENT(example::RangeDriver)
