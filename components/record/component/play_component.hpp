// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "diagnostic_msgs/msg/diagnostic_array.hpp"
#include "nacelle/msgs/type_library.hpp"
#include "nacelle/node/lifecycle_node.hpp"
#include "record/component/player.hpp"
#include "record/model/topic_choice.hpp"
#include "rosgraph_msgs/msg/clock.hpp"

namespace nacelle::record {

/// Publishes a recording into its container, from its beginning each time that it is activated.
///
/// The constructor reads which topics there are, so that a check of the launch file knows them. Parameters and services have the names of
/// rosbag2's player. Topics have the QoS with which they were recorded, and the node's remaps apply
/// to them. Once a second /diagnostics has the figures.
/// Threads: the component's executor; messages are decoded and published on the player's thread.
class PlayComponent final : public LifecycleNode {
 public:
  explicit PlayComponent(const NodeOptions& options);
  ~PlayComponent() override;

 protected:
  CallbackReturn on_configure(const State&) override;
  CallbackReturn on_activate(const State&) override;
  CallbackReturn on_deactivate(const State&) override;
  CallbackReturn on_error(const State&) override;

 private:
  void note(Problem problem);
  void declare_play();
  void offer_services();
  void make_writers();
  [[nodiscard]] std::unique_ptr<Writer> make_writer(const OrderedMessages::Topic& topic, Player::Topic& out);
  void report();

  std::optional<Problem> problem_;  // of the parameters, the first one
  std::string path_;
  std::optional<TopicChoice> choice_;
  std::vector<std::string> named_;  // topics, in full
  Player::Options options_;
  double start_offset_s_ = 0.0, duration_s_ = 0.0;
  msgs::TypeLibrary types_;
  std::vector<OrderedMessages::Topic> recorded_;  // topics, when the writers were made
  std::vector<std::unique_ptr<Writer>> writers_;
  std::vector<Player::Topic> topics_;
  std::vector<std::string> left_out_;  // topics, with the reason
  std::unique_ptr<Player> player_;
  std::shared_ptr<Publisher<rosgraph_msgs::msg::Clock>> clock_;
  std::shared_ptr<Publisher<diagnostic_msgs::msg::DiagnosticArray>> diagnostics_;
  std::shared_ptr<Timer> timer_;
  std::vector<std::shared_ptr<void>> services_;
};

}  // namespace nacelle::record
