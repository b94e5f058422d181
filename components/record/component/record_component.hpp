// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "diagnostic_msgs/msg/diagnostic_array.hpp"
#include "nacelle/node/lifecycle_node.hpp"
#include "record/component/recorder.hpp"
#include "rosbag2_interfaces/srv/is_paused.hpp"
#include "rosbag2_interfaces/srv/pause.hpp"
#include "rosbag2_interfaces/srv/resume.hpp"
#include "rosbag2_interfaces/srv/split_bagfile.hpp"
#include "rosbag2_interfaces/srv/toggle_paused.hpp"

namespace nacelle::record {

/// Records topics of its container as long as it is active, each time into a new folder.
///
/// Parameters and services have the names of rosbag2's recorder. Once a second /diagnostics has the figures, with "lost" for each topic that
/// lost messages. A full disk, or one that fails, ends the recording and is the open fault RECORDING_ENDED; the robot goes on.
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
  void note(Problem problem);
  void stop();
  void report();

  std::optional<Problem> problem_;  // of the parameters, the first one
  std::optional<TopicChoice> choice_;
  RecordingOptions storage_;  // folder: the pattern
  bool starts_paused_ = false;
  std::unique_ptr<Recorder> recorder_;
  std::shared_ptr<Publisher<diagnostic_msgs::msg::DiagnosticArray>> diagnostics_;
  std::shared_ptr<Timer> timer_;
  std::vector<std::shared_ptr<void>> services_;
};

}  // namespace nacelle::record
