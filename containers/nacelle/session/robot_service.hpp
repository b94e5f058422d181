// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <pthread.h>

#include <array>
#include <atomic>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "answers/robot.hpp"
#include "control/server.hpp"
#include "nacelle/base/bell.hpp"
#include "nacelle/base/guarded.hpp"
#include "nacelle/host/transport.hpp"
#include "nacelle/msgs/type_library.hpp"
#include "nacelle/runtime/container.hpp"

namespace nacelle::spatial {
class TransformBuffer;
}

namespace nacelle::session {

using answers::Phase;

inline constexpr std::string_view kEmergencyStopTopic = "emergency_stop", kEmergencyStopType = "std_msgs/msg/Bool";
/// Returns whether a topic is an emergency stop, in any namespace. Such a topic is latched, and accepted in every
/// phase.
[[nodiscard]] bool is_emergency_stop(std::string_view topic, std::string_view type);

/// Answers the requests on the control thread from the container: publishing, transforms, live figures.
///
/// Threads: the main thread creates it; FastService's members on the control thread; set_phase() and set_nodes() from
/// any.
/// Allocates: open_writer(); the first answers, until the buffers have their size.
class RobotService final : public control::FastService {
 public:
  /// `on_shutdown` is called on the control thread when a client requests a shutdown; it may only set a flag. `bell`
  /// rings when a client publishes an emergency stop, and when descriptors run out or are available again. It must
  /// outlive this object.
  RobotService(runtime::Container& container, const std::vector<std::filesystem::path>& message_folders,
               void (*on_shutdown)(void*), void* context, Bell& bell);

  [[nodiscard]] Result<std::uint16_t, std::string> open_writer(control::NamePair topic_and_type) override;
  void close_writer(std::uint16_t handle) override;
  [[nodiscard]] const char* publish(const control::Publication& publication) override;
  [[nodiscard]] control::TransformAnswer lookup(control::NamePair target_and_source) override;
  void append_stats(std::string& out) override;
  /// Sets an emergency stop as a client does. Call it before clients are accepted. Errors: the refusal.
  [[nodiscard]] Result<void, std::string> set_emergency_stop(const std::string& topic);
  void request_shutdown() override { on_shutdown_(context_); }
  [[nodiscard]] bool is_emergency_stop(control::NamePair topic_and_type) const override;
  void descriptors_ran_out(bool ran_out) override;
  void descriptor_was_lost() override;

  /// Returns whether the control thread fails to open descriptors. A change rings the bell. Threads: any.
  [[nodiscard]] bool has_no_descriptors() const { return has_no_descriptors_; }
  /// Returns whether other code has closed a descriptor of the control thread. The main thread then gets a SIGTERM.
  /// Threads: any.
  [[nodiscard]] bool has_lost_a_descriptor() const { return has_lost_a_descriptor_; }

  void set_phase(Phase phase) { phase_ = phase; }
  [[nodiscard]] Phase phase() const { return phase_; }
  /// Sets the present names and states. Call it after one of them has changed.
  void set_nodes(const std::vector<runtime::ComponentInfo>& nodes);

 private:
  struct OpenWriter {
    std::unique_ptr<Writer> writer;
    const msgs::MessageType* type = nullptr;
    std::string
        latched_topic;  ///< For an emergency stop: the writer outlives the client that opened it, as its message does.
  };

  runtime::Container& container_;
  msgs::TypeLibrary types_;
  void (*on_shutdown_)(void*);
  void* context_;
  Bell& bell_;
  const pthread_t main_thread_;
  std::atomic<bool> has_no_descriptors_{false}, has_lost_a_descriptor_{false};
  std::atomic<Phase> phase_{Phase::Starting};
  Guarded<std::string> nodes_json_{std::in_place, "[]"};
  std::array<OpenWriter, 64> writers_;
  const std::string buffer_name_;
  std::shared_ptr<spatial::TransformBuffer> transforms_;
  std::vector<runtime::StreamReport> streams_;
};

}  // namespace nacelle::session
