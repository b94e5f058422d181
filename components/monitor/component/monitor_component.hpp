// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <list>
#include <memory>
#include <string>
#include <vector>

#include "diagnostic_msgs/msg/diagnostic_array.hpp"
#include "monitor/component/stream_readers.hpp"
#include "monitor/model/stream_watch.hpp"
#include "nacelle/node/lifecycle_node.hpp"

namespace nacelle::monitor {

/// Reads the streams of the parameter `streams` and publishes rate, age and gaps of each on /diagnostics.
///
/// `streams` names topics ("/scan"), with a type behind those that are not the robot's own ("/front/scan
/// sensor_msgs/msg/LaserScan"). `share_as` is how messages are taken: reference or pointer; neither copies.
/// `expected_rates` (Hz, one per stream, 0 for any) make rates something to judge.
/// Threads: the component's executor. Allocates: nothing per message; text for each report.
class MonitorComponent final : public LifecycleNode {
 public:
  explicit MonitorComponent(const NodeOptions& options);

 protected:
  CallbackReturn on_activate(const State&) override;

 private:
  struct Stream {
    std::string topic;
    std::string type;
    StreamWatch watch;
    Expectation expected;
    std::vector<std::shared_ptr<SubscriptionBase>> subscriptions;
  };
  void declare_streams();
  void report();

  std::list<Stream> streams_;  ///< Their callbacks hold the addresses.
  std::shared_ptr<Publisher<diagnostic_msgs::msg::DiagnosticArray>> diagnostics_;
  std::shared_ptr<Timer> timer_;
};

}  // namespace nacelle::monitor
