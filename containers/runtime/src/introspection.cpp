// SPDX-License-Identifier: Apache-2.0
// Queries of tools to a container: its services and streams, and service calls from outside any component.
#include "nacelle/runtime/introspection.hpp"

#include <algorithm>

#include "container_impl.hpp"

namespace nacelle::runtime {
namespace {

// The client of one call, without a node and without an executor.
class ToolCall final : public ServiceCall, private AnswerTaker {
 public:
  explicit ToolCall(std::function<void()> on_answer)
      : on_answer_(std::move(on_answer)),
        self_(std::make_shared<Guarded<AnswerTaker*>>(std::in_place, static_cast<AnswerTaker*>(this))) {}
  ~ToolCall() override { *self_->lock() = nullptr; }  // waits for a running push()

  [[nodiscard]] Asker asker() const { return {self_, 1}; }
  [[nodiscard]] State state() const override { return state_.load(std::memory_order_acquire); }
  [[nodiscard]] const void* response() const override {
    return state() == State::Answered ? response_->get() : nullptr;
  }

 private:
  void push(std::int64_t, std::unique_ptr<AnyMessage> response) override {
    response_ = std::move(response);
    state_.store(response_ ? State::Answered : State::Refused, std::memory_order_release);
    on_answer_();
  }

  const std::function<void()> on_answer_;
  const std::shared_ptr<Guarded<AnswerTaker*>> self_;
  std::unique_ptr<AnyMessage> response_;
  std::atomic<State> state_{State::Waiting};
};

}  // namespace

Result<std::unique_ptr<ServiceCall>, Problem> Container::call_service(const std::string& name,
                                                                      const msgs::ServiceType& type, void* request,
                                                                      std::function<void()> on_answer) {
  const msgs::MessageType& request_type = type.request();
  auto call = std::make_unique<ToolCall>(std::move(on_answer));
  AnyMessage sent{request_type};
  request_type.move_assign(sent.get(), request);
  if (!impl_->commons.services.send(name, request_type, {call->asker(), std::move(sent)}))
    return err(impl_->commons.services.why_not(name, request_type));
  return std::unique_ptr<ServiceCall>{std::move(call)};
}

std::vector<ServiceReport> Container::services() const {
  std::vector<ServiceReport> all;
  {
    const LockGuard lock(impl_->mutex);
    for (const auto& [id, record] : impl_->records) {
      record->for_each_node([&](const NodeRuntime& node) { node.report_services(all); });
      NodeServices::report_services(record->face.get(), all);
      auto others = record->others.lock();
      for (const auto& other : *others) NodeServices::report_services(other->face.get(), all);
    }
    for (const auto& [id, face] : impl_->foreign_faces) NodeServices::report_services(face.get(), all);
    if (impl_->services) impl_->services->report_services(all);
    if (impl_->node_services) impl_->node_services->report_own_services(all);
  }
  impl_->commons.services.report_stand_ins(all);
  std::ranges::stable_sort(all, {}, &ServiceReport::name);
  return all;
}

std::vector<EndpointReport> Container::endpoints() const { return impl_->commons.broker.endpoints(); }

}  // namespace nacelle::runtime
