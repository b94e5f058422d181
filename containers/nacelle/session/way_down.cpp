// SPDX-License-Identifier: Apache-2.0
// The end of a session: components and programs go, and the report is written.
#include <poll.h>

#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "nacelle/base/files.hpp"
#include "nacelle/base/json_text.hpp"
#include "nacelle/base/reversed.hpp"
#include "nacelle/host/standard_interfaces.hpp"
#include "nacelle/msgs/json.hpp"
#include "requests/topic_tap.hpp"
#include "session/session.hpp"

namespace nacelle::session {
namespace {

constexpr Duration kLastMessageLimit = 500ms;

}  // namespace

void Session::take_down() {
  // If its event is closed, the thread cannot be joined.
  if (lost_descriptors_) static_cast<void>(lookout_.release());
  lookout_.reset();
  const bool was_running = service_->phase() == Phase::Running;
  service_->set_phase(Phase::Stopping);
  if (was_running) report_.process = steady_.end(clock_.now());
  // Stops the wheels first, because hanging components may delay the base's turn. Its measurements continue meanwhile.
  container_->write_safe_stops();
  tell_service_manager("STOPPING=1\n", "stopping");
  if (was_running) fetch_last_messages();
  container_->give_up_transitions_after(kShutdownStepLimit);
  // Components that were loaded by hand are stopped first: those of the plan cannot depend on them.
  auto components = container_->list();
  for (const auto& info : reversed(components)) {
    if (plan_of(info.node) == nullptr && info.managed && info.state == StateId::Active) {
      if (container_->trigger(info.id, Transition::Deactivate).success)
        report_.shutdown_order.push_back(report::component_name(info.node));
    }
  }
  if (manager_ && was_running) {
    const auto at_rest = manager_->deactivate();
    // The first clean-up removes the endpoints, so figures are collected before it.
    take_final_figures();
    const auto clean = manager_->cleanup();
    for (const auto& outcome : {at_rest, clean}) {
      if (!outcome.success) say("nacelle: shutdown: " + outcome.problem.text());
    }
  }
  take_final_figures();
  components = container_->list();
  for (const auto& info : reversed(components)) {
    auto unloaded = container_->unload(info.id);
    if (!unloaded) say("nacelle: shutdown: " + unloaded.error().text());
  }
  for (auto& program : reversed(programs_)) {
    progress("stopping program " + program->spec().label);
    program->stop(clock_);
  }
  supervision_->publish();
  // After a failure of this kind `--resume` restores the composition.
  if (was_running && !lost_descriptors_ && supervision_->why_to_restart().empty()) {
    state_->remove();
    crashes_->remove();
  }
  service_->set_phase(Phase::Down);
  if (on_terminal_ && !options_.verbose) {
    std::fputs("\r\033[K", stderr);
    std::fflush(stderr);
  }
}

void Session::take_final_figures() {
  if (undoing_ || !report_.streams.empty()) return;
  container_->report_streams(report_.streams);
  container_->report_histograms(report_.histograms);
  // Only topics that had ends or messages; services are no streams.
  std::erase_if(report_.streams, [](const runtime::StreamReport& stream) {
    return stream.type.find("/msg/") == std::string::npos || is_standard_topic(stream.name) ||
           (stream.readers == 0 && stream.writers == 0 && stream.published == 0);
  });
}

void Session::fetch_last_messages() {
  nlohmann::ordered_json last = nlohmann::ordered_json::object();
  for (const auto& topic : options_.last_messages) {
    last[topic] = nullptr;
    const auto* const type = container_->topic_type(topic);
    if (type == nullptr) continue;
    requests::TopicTap tap{container_->transport(), topic, *type, 1};
    pollfd wait{tap.descriptor(), POLLIN, 0};
    if (::poll(&wait, 1, static_cast<int>(kLastMessageLimit / 1ms)) <= 0) continue;
    if (Block* const block = tap.take(); block != nullptr) {
      last[topic] = parse_json_or_discard<nlohmann::ordered_json>(msgs::to_json(*type, block->message));
      drop_reference(*block);
    }
  }
  last_messages_json_ = last.dump();
}

bool Session::write_report() {
  if (options_.report_file.empty()) return true;
  nlohmann::ordered_json figures = report::to_json(report_);
  if (!options_.last_messages.empty())
    figures["last_messages"] = parse_json_or_discard<nlohmann::ordered_json>(last_messages_json_);
  const auto written = write_whole_file(options_.report_file, figures.dump(2) + "\n");
  if (written) return true;
  say("nacelle: the report: " + written.error().text());
  return false;
}

}  // namespace nacelle::session
