// SPDX-License-Identifier: Apache-2.0
#include "container_services.hpp"

#include <cctype>
#include <exception>

#include "composition_answers.hpp"
#include "nacelle/base/lifecycle_fault.hpp"
#include "nacelle/base/log.hpp"
#include "nacelle/base/name_fault.hpp"
#include "nacelle/base/names.hpp"
#include "nacelle/runtime/container.hpp"

namespace nacelle::runtime {
namespace {

namespace ros = composition_interfaces::srv;
namespace own = nacelle_interfaces::srv;

constexpr const char* kBelow = "/_container/";

void log_fault(const std::string& code, const std::string& text, const std::string& callback) {
  Logger{"container"}.error("{}: {} (in {})", code, text, callback);
}

NodeIdentity identity_of(std::string name, const std::string& name_space) {
  for (char& c : name) {
    if (std::isalnum(static_cast<unsigned char>(c)) == 0) c = '_';
  }
  if (name.empty() || std::isdigit(static_cast<unsigned char>(name.front())) != 0) name.insert(0, "container_");
  return {std::move(name), name_space};
}

/// The host of a container without a launch file.
class Plain final : public CompositionHost {
 public:
  explicit Plain(Container& container) : container_(container) {}
  std::string name_space() const override { return "/"; }
  Result<Loaded, Problem> load_planned(const std::string& name) override {
    return err(Problem{"component " + name, "this container has no launch file",
                       "give the class of a plugin: pkg::Class", NameFault::Unknown, name});
  }
  Result<Loaded, Problem> load(const LoadRequest& request, bool activate) override {
    auto loaded = container_.load(request);
    if (!loaded) return err(loaded.error());
    for (const Transition step : {Transition::Configure, Transition::Activate}) {
      if (!activate || !loaded.value().managed) break;
      const auto outcome = container_.trigger(loaded.value().id, step);
      loaded.value().state = outcome.state;
      if (outcome.success) continue;
      static_cast<void>(container_.unload(loaded.value().id));
      return err(Problem{loaded.value().node, std::string{"could not "} + to_text(step) + ": " + outcome.reason,
                         "it was unloaded again", LifecycleFault::TransitionFailed, to_text(step)});
    }
    return Loaded{std::move(loaded).value(), {}};
  }
  Result<UnloadOutcome, Problem> unload(std::uint64_t id) override { return container_.unload(id); }

 private:
  Container& container_;
};

// Each service type's field for the error text.
template <typename Response>
void refuse(Response& response, const char* why) {
  if constexpr (requires { response.error_message; }) {
    response.error_message = why;
  } else if constexpr (requires { response.problem; }) {
    response.problem.what = why;
  }
}

}  // namespace

template <typename S>
bool ContainerServices::run(void* services, std::int64_t, const void* request, void* response) {
  auto& self = *static_cast<ContainerServices*>(services);
  auto& out = *static_cast<typename S::Response*>(response);
  out = {};
  auto host = self.host_.lock();
  Plain plain{self.container_};
  Composed composed{self.container_, *host != nullptr ? **host : plain};
  try {
    answer(composed, *static_cast<const typename S::Request*>(request), out);
  } catch (const std::exception& failure) { refuse(out, failure.what()); }
  return true;
}

bool ContainerServices::run_transition(void* services, std::int64_t call, const void* request, void* response) {
  auto& self = *static_cast<ContainerServices*>(services);
  auto& out = *static_cast<own::ChangeState::Response*>(response);
  out = {};
  const auto asked = *static_cast<const own::ChangeState::Request*>(request);
  const auto component = self.container_.find(asked.component);
  const auto change = [&self, call, asked] {
    own::ChangeState::Response changed;
    answer(self.container_, asked, changed);
    static_cast<void>(self.change_state_->send_response(call, &changed));
  };
  if (component && self.lanes_.push(component.value().id, change)) return false;
  if (component) {
    refuse(out, "too many transitions of it wait already");
  } else {
    answer(self.container_, asked, out);
  }
  return true;
}

std::string ContainerServices::node_of(const std::string& name, const std::string& name_space) {
  return identity_of(name, name_space).fully_qualified();
}

ContainerServices::ContainerServices(Container& container, Commons& commons, const std::string& name,
                                     const std::string& name_space, Executor* quick)
    : container_(container),
      executor_("container", commons.clock, {.own = true}),
      node_(commons, identity_of(name, name_space), executor_, log_fault, false),
      quick_node_(commons, node_.identity(), quick != nullptr ? *quick : executor_, log_fault, false) {
  const std::string prefix = node() + kBelow;
  const auto offer = [&]<typename S>(const char* what, std::in_place_type_t<S>) {
    services_.push_back(node_.create_service(prefix + what, S::Request::message_type(), S::Response::message_type(),
                                             {&ContainerServices::run<S>, this}, nullptr));
  };
  offer("load_node", std::in_place_type<ros::LoadNode>);
  offer("unload_node", std::in_place_type<ros::UnloadNode>);
  offer("list_nodes", std::in_place_type<ros::ListNodes>);
  offer("get_components", std::in_place_type<own::GetComponents>);
  offer("load_component", std::in_place_type<own::LoadComponent>);
  offer("unload_component", std::in_place_type<own::UnloadComponent>);
  using Change = own::ChangeState;
  change_state_ = node_.create_service(prefix + "change_state", Change::Request::message_type(),
                                       Change::Response::message_type(), {&run_transition, this}, nullptr);
  node_.open();
  quick_node_.open();
}

std::unique_ptr<ServiceHandle> ContainerServices::offer(const std::string& name, const msgs::MessageType& request,
                                                        const msgs::MessageType& response, ServiceCallback callback) {
  return quick_node_.create_service(node() + kBelow + name, request, response, callback, nullptr);
}

ContainerServices::~ContainerServices() = default;

}  // namespace nacelle::runtime
