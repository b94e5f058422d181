// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "diagnostic_msgs/msg/diagnostic_array.hpp"
#include "nacelle/node/container_facts.hpp"
#include "nacelle/node/lifecycle_node.hpp"
#include "nacelle/node/network_facts.hpp"
#include "record/component/black_box.hpp"
#include "record/component/recorder.hpp"
#include "record/component/recording.hpp"
#include "record/component/remote_topics.hpp"
#include "rosbag2_interfaces/msg/write_split_event.hpp"
#include "rosbag2_interfaces/srv/is_paused.hpp"
#include "rosbag2_interfaces/srv/pause.hpp"
#include "rosbag2_interfaces/srv/resume.hpp"
#include "rosbag2_interfaces/srv/snapshot.hpp"
#include "rosbag2_interfaces/srv/split_bagfile.hpp"
#include "rosbag2_interfaces/srv/toggle_paused.hpp"

namespace nacelle::record {

/// Records topics of its container as long as it is active, each time into a new folder; with storage.ring, the last seconds into memory, which it
/// writes when it is asked (~/snapshot), after an emergency stop, after a fault, and at the next start if its process was killed.
///
/// Parameters and services have the names of rosbag2's recorder. Once a second /diagnostics has the figures, with "lost" for each topic that
/// lost messages. A full disk, or one that fails, ends the recording and is the open fault RECORDING_ENDED; the robot goes on. A snapshot that
/// cannot be written is the open fault SNAPSHOT_FAILED until one is.
/// Threads: the component's executor; messages are taken and encoded on the recorder's thread, and written on a third one.
class RecordComponent final : public LifecycleNode {
 public:
  explicit RecordComponent(const NodeOptions& options);
  ~RecordComponent() override;

 protected:
  CallbackReturn on_configure(const State&) override;
  CallbackReturn on_activate(const State&) override;
  CallbackReturn on_deactivate(const State&) override;
  CallbackReturn on_error(const State&) override;

 private:
  [[nodiscard]] TopicWish declare_topics();
  void declare_storage();
  void offer_services();
  void offer_snapshot();
  [[nodiscard]] std::string next_folder() const;
  [[nodiscard]] Result<std::unique_ptr<MessageLog>, Problem> begin();
  [[nodiscard]] Result<std::unique_ptr<MessageLog>, Problem> begin_ring();
  [[nodiscard]] Recorder::Options recorder_options();
  void on_snapshot(const std::string& reason, const Result<Snapshot, Problem>& result);
  void note(Problem problem);
  void stop();
  void look_for_remote_topics();
  void report();

  std::optional<Problem> problem_;  // of the parameters, the first one
  std::optional<TopicChoice> choice_;
  RecordingOptions storage_;  // folder: the pattern
  RingOptions ring_;          // longest: zero without a ring
  bool starts_paused_ = false;
  const std::shared_ptr<ContainerFacts> facts_;
  const std::shared_ptr<NetworkFacts> network_facts_;
  std::unique_ptr<BlackBox> black_box_;
  Ring* open_ring_ = nullptr;      // the recorder's log, if it is one; for the recorder's thread
  std::optional<Problem> no_log_;  // why there is no recorder
  std::unique_ptr<Recorder> recorder_;
  std::unique_ptr<RemoteTopics> remote_;  // beside the recorder
  bool takes_all_remote_ = false;
  std::shared_ptr<Publisher<diagnostic_msgs::msg::DiagnosticArray>> diagnostics_;
  std::shared_ptr<Publisher<rosbag2_interfaces::msg::WriteSplitEvent>> split_events_;  // the recorder's thread's
  std::shared_ptr<Timer> timer_, remote_timer_;
  std::vector<std::shared_ptr<void>> services_;
  std::shared_ptr<Service<rosbag2_interfaces::srv::Snapshot>> snapshots_;
};

}  // namespace nacelle::record
