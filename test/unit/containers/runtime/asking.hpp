// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <future>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "nacelle/runtime/container.hpp"

namespace nacelle::runtime {

/// A call of a service by a tool, and its answer.
template <typename S>
class Call {
 public:
  Call(Container& container, const std::string& service, typename S::Request request) {
    auto sent = container.call_service(service, S::service_type(), &request, [this] { answered_.set_value(); });
    if (sent) {
      call_ = std::move(sent).value();
    } else {
      problem_ = sent.error().text();
    }
  }
  [[nodiscard]] bool is_answered() const { return call_ != nullptr && call_->state() == ServiceCall::State::Answered; }
  /// Waits until it is answered or refused; false if neither comes.
  bool ends() { return call_ != nullptr && has_come_.wait_for(std::chrono::seconds{20}) == std::future_status::ready; }
  /// The answer; none if the call was refused, or nothing comes.
  std::optional<typename S::Response> wait() {
    if (!ends() || call_->response() == nullptr) return std::nullopt;
    return *static_cast<const typename S::Response*>(call_->response());
  }
  /// Why it could not be sent.
  [[nodiscard]] const std::string& problem() const { return problem_; }

 private:
  std::promise<void> answered_;
  std::shared_future<void> has_come_{answered_.get_future()};
  std::string problem_;
  std::unique_ptr<ServiceCall> call_;  // its end waits for an answer that is just coming
};

}  // namespace nacelle::runtime
