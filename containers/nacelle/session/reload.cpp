// SPDX-License-Identifier: Apache-2.0
#include "session/reload.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <rcl_interfaces/srv/set_parameters.hpp>

#include "nacelle/runtime/parameter_messages.hpp"

namespace nacelle::session {
namespace {

using rcl_interfaces::srv::SetParameters;

// A callback that runs so long is reported as hung by then.
constexpr Duration kLimit = 5s;

}  // namespace

Reload::Reload(answers::Robot& robot, Reread reread, const Clock& clock, Say say)
    : robot_(robot), reread_(std::move(reread)), clock_(clock), say_(std::move(say)) {}

bool Reload::begin() {
  if (due_) return false;
  set_ = refused_ = 0;
  failed_.clear();
  due_ = clock_.now() + kLimit;
  bell_->ring();  // also if there is nothing to wait for
  if (!reread_) {
    failed_ = "this container has no launch file";
    return true;
  }
  const auto plan = reread_();
  if (plan) {
    compare(plan.value());
    return true;
  }
  for (const auto& problem : plan.error()) say_("nacelle: reload: " + problem.text());
  failed_ = plan.error().empty() ? "the launch file cannot be read" : plan.error().front().text();
  return true;
}

void Reload::compare(const launch::Plan& plan) {
  for (const auto& component : plan.components) {
    const std::string node = component.full_name();
    const auto info = robot_.container().find(node);
    if (info && info.value().node == node && info.value().plugin == component.plugin) {
      change(component, info.value());
    } else if (robot_.plan().find(node) == nullptr) {
      say_(fmt::format("nacelle: reload: {} is new in the launch file; the next start loads it", node));
    }
  }
  for (const auto& component : robot_.plan().components) {
    if (plan.find(component.full_name()) == nullptr)
      say_(fmt::format("nacelle: reload: {} is no longer in the launch file; it runs until the next start",
                       component.full_name()));
  }
}

void Reload::change(const launch::ComponentPlan& component, const runtime::ComponentInfo& info) {
  const auto now = robot_.container().request_of(info.id);
  if (!now) return;
  SetParameters::Request request;
  Call call{info.node, {}, nullptr};
  for (const auto& parameter : component.parameters) {
    const auto found = now->parameters.find(parameter.name);
    if (found != now->parameters.end() && found->second == parameter.value) continue;
    request.parameters.push_back(runtime::message_of(Parameter{parameter.name, parameter.value}));
    call.names.push_back(parameter.name);
  }
  if (call.names.empty()) return;
  auto begun = robot_.container().call_service(info.node + "/set_parameters", SetParameters::service_type(), &request,
                                               [bell = bell_] { bell->ring(); });
  if (begun) {
    call.call = std::move(begun).value();
    calls_.push_back(std::move(call));
  } else {
    refused_ += call.names.size();
    say_(fmt::format("nacelle: reload: {}: {}", info.node, begun.error().text()));
  }
}

void Reload::take(const Call& done) {
  const auto* const response = static_cast<const SetParameters::Response*>(done.call->response());
  if (response == nullptr || response->results.size() != done.names.size()) {
    refused_ += done.names.size();
    const char* const why =
        done.call->state() == runtime::ServiceCall::State::Waiting ? "it does not answer" : "it ended, or failed";
    return say_(fmt::format("nacelle: reload: {}: parameters not set: {}", done.node, why));
  }
  for (std::size_t i = 0; i < done.names.size(); ++i) {
    const auto& result = response->results[i];
    ++(result.successful ? set_ : refused_);
    say_(fmt::format("nacelle: reload: {}: {} {}", done.node, done.names[i],
                     result.successful ? "is set" : "is not set: " + std::string{result.reason}));
  }
}

std::optional<std::string> Reload::work() {
  if (!due_) return std::nullopt;
  bell_->silence();
  const bool is_late = clock_.now() >= *due_;
  std::erase_if(calls_, [&](const Call& call) {
    if (!is_late && call.call->state() == runtime::ServiceCall::State::Waiting) return false;
    take(call);
    return true;
  });
  if (!calls_.empty()) return std::nullopt;
  due_.reset();
  if (set_ != 0) robot_.composition_changed();
  if (!failed_.empty()) return "reload failed: " + failed_;
  return fmt::format("reloaded: {} parameters set, {} refused", set_, refused_);
}

}  // namespace nacelle::session
