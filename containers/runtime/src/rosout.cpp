// SPDX-License-Identifier: Apache-2.0
#include "rosout.hpp"

#include <algorithm>
#include <rcl_interfaces/msg/log.hpp>

#include "nacelle/host/standard_interfaces.hpp"
#include "nacelle/qos/presets.hpp"
#include "nacelle/runtime/executor.hpp"

namespace nacelle::runtime {
namespace {

using rcl_interfaces::msg::Log;

// ROS names a node's logger with dots: "robot1.lidar".
std::string logger_of(const std::string& node) {
  std::string name = node.substr(1);
  std::ranges::replace(name, '/', '.');
  return name;
}

void publish(Writer& writer, const LogQueue::Line& line) {
  Block* const block = writer.borrow();
  if (block == nullptr) return;
  auto& log = *static_cast<Log*>(block->message);
  log.stamp = line.when;
  log.level = static_cast<std::uint8_t>(line.level);
  log.name.assign(line.name);
  log.msg.assign(line.text);
  log.file.assign(line.file);
  log.function.assign(line.function);
  log.line = line.number;
  static_cast<void>(writer.publish(*block));
}

}  // namespace

Rosout::Rosout(CallbackGroup& group, Transport& transport, const Clock& clock, const std::string& own_node)
    : Executable(group), transport_(transport), clock_(clock), own_name_(logger_of(own_node)) {
  describe_as("log", kRosoutTopic);
  writers_.lock()->emplace(own_name_, make_writer(own_node));
  add_log_listener(*this);
}

Rosout::~Rosout() {
  remove_log_listener(*this);
  group().executor().forget(*this);
  publish_all(*writers_.lock());
}

std::unique_ptr<Writer> Rosout::make_writer(const std::string& node) const {
  EndpointSpec spec{kRosoutTopic, &Log::message_type(), RosoutQoS{}, node};
  spec.reserves = false;  // reserving a thousand lines per node would waste memory
  return transport_.create_writer(spec);
}

void Rosout::add(const std::string& node) {
  if (logger_of(node) == own_name_) return;  // a component with the container's name: one writer for both
  auto writer = make_writer(node);
  writers_.lock()->insert_or_assign(logger_of(node), std::move(writer));
}

void Rosout::remove(const std::string& node) {
  auto writers = writers_.lock();
  publish_all(*writers);
  if (logger_of(node) != own_name_) writers->erase(logger_of(node));
}

void Rosout::on_line(LogLevel level, std::string_view name, std::string_view text, const LogPlace& place) noexcept {
  static_cast<void>(queue_.push(level, clock_.wall_now(), name, text, place));
  on_ready();
}

void Rosout::execute(MonotonicTime) {
  const std::uint64_t before = dropped_.load(std::memory_order_relaxed);
  publish_all(*writers_.lock());
  const std::uint64_t lost = dropped_.load(std::memory_order_relaxed) - before;
  if (lost == 0) return;
  Logger{own_name_}.warn("{} log lines were not published on {}: they came faster than they could be published", lost,
                         kRosoutTopic);
}

// Under the lock of the writers, so by one thread at a time.
void Rosout::publish_all(Writers& writers) {
  dropped_ += queue_.take([&](const LogQueue::Line& line) {
    // Lines of a child logger, "lidar.driver", belong to its parent.
    for (std::string_view name = line.name;;) {
      if (const auto found = writers.find(name); found != writers.end()) return publish(*found->second, line);
      const auto dot = name.rfind('.');
      if (dot == std::string_view::npos) return publish(*writers.find(own_name_)->second, line);
      name = name.substr(0, dot);
    }
  });
}

}  // namespace nacelle::runtime
