// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <condition_variable>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "fake_transport.hpp"
#include "manual_clock.hpp"
#include "nacelle/base/expect.hpp"
#include "nacelle/msgs/message_type.hpp"
#include "nacelle/node/lifecycle_node.hpp"

namespace nacelle::test {

class RecordingHost;

/// A container for one component under test: no executor, no thread, simulated time.
///
///     RecordingContext context;
///     LidarComponent lidar{NodeOptions{context}.append_parameter_override("port_name", path)};
///     lidar.trigger(Transition::Configure);
///     context.inject("/cmd_vel", twist);                      // as another node would publish it; runs the callbacks
///     context.advance(20ms);                                  // moves the clock, fires timers that are due
///     auto scans = context.published<LaserScan>("/scan");     // copies of everything so far, in order
/// Threads: one, but a component's own threads may publish; wait_for() waits for those.
class RecordingContext final : public Context {
 public:
  RecordingContext();
  /// Reads time from the given clock instead, for components whose own threads live in real time.
  explicit RecordingContext(const Clock& clock);
  ~RecordingContext() override;

  [[nodiscard]] std::unique_ptr<NodeHost> create_host(const NodeIdentity& identity) override;

  /// Does not record that topic: it has no reader but the subscriptions under test. Call it before the publisher is made.
  void leave_unread(const std::string& topic);

  ManualClock& clock() { return manual_; }
  /// Drops what was recorded of a topic; returns how many messages that were. published() and wait_for() count anew.
  std::size_t forget(const std::string& topic);
  /// Moves the clock in steps of at most 1 ms and fires the timers on the way.
  void advance(Duration by);
  /// Runs the callbacks of everything that waits.
  void spin();

  template <typename T>
  void inject(const std::string& topic, const T& message) {
    inject(topic, T::message_type(), &message);
  }
  template <typename T>
  [[nodiscard]] std::vector<T> published(const std::string& topic) {
    std::vector<T> all;
    collect(topic, [&](const void* message) { all.push_back(*static_cast<const T*>(message)); });
    return all;
  }
  /// Waits, by an event, until a topic has had that many messages. Returns false after the limit.
  [[nodiscard]] bool wait_for(const std::string& topic, std::size_t messages, Duration limit = 10s);
  /// Returns false without a server that is open, and if it did not answer within its callback (a later answer is lost).
  template <typename S>
  [[nodiscard]] bool call(const std::string& service, typename S::Request request, typename S::Response& response) {
    return call(service, &request, &response);
  }

  struct Claimed {
    std::string parent, child;
    FrameClaimKind kind;
  };
  [[nodiscard]] std::vector<FaultReason> faults() const;
  /// Those that are open now.
  [[nodiscard]] std::vector<FaultReason> open_faults() const;
  /// How many were closed so far.
  [[nodiscard]] std::size_t closed_faults() const;
  /// Waits until so many are open.
  void wait_for_open_faults(std::size_t count);
  /// Returns false after the limit.
  [[nodiscard]] bool wait_for_open_faults(std::size_t count, Duration limit);
  [[nodiscard]] std::vector<Claimed> frames() const;
  /// Type name and announcement of each subscription that was made of a topic, in their order.
  [[nodiscard]] std::vector<std::pair<std::string, Announced>> announced(const std::string& topic) const;
  /// Who owns a claimed frame: true (the default) for every claim until a test gives the frame another owner.
  void set_frame_owner(const std::string& child, const std::string& other_node);
  /// The registered stop frame; empty when there is none.
  [[nodiscard]] std::vector<std::uint8_t> safe_stop() const;
  /// Where it was registered to be written.
  [[nodiscard]] std::vector<int> safe_stop_descriptors() const;
  [[nodiscard]] DurationHistogram& histogram(const std::string& name);
  [[nodiscard]] std::shared_ptr<void> shared_object(const std::string& name, std::shared_ptr<void> (*make)());

 private:
  friend class RecordingHost;
  struct State;
  void inject(const std::string& topic, const msgs::MessageType& type, const void* message);
  void collect(const std::string& topic, const std::function<void(const void*)>& each);
  bool call(const std::string& service, void* request, void* response);

  ManualClock manual_;
  std::unique_ptr<State> state_;
};

}  // namespace nacelle::test
