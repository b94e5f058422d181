// SPDX-License-Identifier: Apache-2.0
#include "node_services.hpp"

#include <utility>

#include "container_impl.hpp"
#include "node_face.hpp"

namespace nacelle::runtime {

NodeServices::NodeServices(Container& container, Commons& commons, NodeInterfaces which, const std::string& own_node)
    : container_(container),
      commons_(commons),
      which_(which),
      executor_("services", commons.clock, {.own = true}),
      log_node_(executor_, own_node, [](const std::string&, const std::string&, const std::string&) {}),
      log_group_(log_node_),
      rosout_(log_group_, commons.broker, commons.clock, own_node),
      own_parameters_(own_node, {}) {
  ParameterDescriptor fixed;
  fixed.description = "The container's own node has no timers; its components have a parameter of this name each.";
  fixed.read_only = true;
  own_parameters_.declare("use_sim_time", false, ParameterType::Bool, std::move(fixed));
  executor_.open(log_node_);
  if (which == NodeInterfaces::All) own_face_ = offer(kOwnNode, own_node, NodeFace::Parts::Parameters);
}

NodeServices::~NodeServices() { withdraw(kOwnNode, own_face_); }

void NodeServices::begin(NodeRecord& node, bool has_lifecycle) {
  const std::string name = node.runtime->identity().fully_qualified();
  node.events = std::make_shared<ParameterEvents>(commons_.broker, commons_.clock, name);
  // The constructor's declarations were made before there was a publisher: publish them all at once.
  ParameterChange all;
  const auto declared = [&](const std::string& parameter, const ParameterValue& value, ParameterType,
                            const ParameterDescriptor&) { all.declared.emplace_back(parameter, value); };
  node.parameters->for_each(declared);
  node.events->on_change(all);
  node.parameters->set_listener(node.events);
  const bool is_managed_here = which_ == NodeInterfaces::All && has_lifecycle;
  node.face = offer(node.id, name, is_managed_here ? NodeFace::Parts::All : NodeFace::Parts::Parameters);
}

void NodeServices::end(NodeRecord& node, bool returned) {
  withdraw(node.id, node.face);
  node.face.reset();
  if (node.events) {
    if (returned) node.parameters->set_listener(nullptr);
    node.events->end();
  }
  rosout_.remove(node.runtime->identity().fully_qualified());
}

std::shared_ptr<NodeFace> NodeServices::offer(std::uint64_t id, const std::string& node, NodeFace::Parts parts) {
  return NodeFace::make(*this, commons_, executor_, id, node, parts);
}

void NodeServices::withdraw(std::uint64_t id, const std::shared_ptr<NodeFace>& face) {
  if (!face) return;
  lanes_.drop(id);
  face->withdraw();
}

void NodeServices::report_services(const NodeFace* face, std::vector<ServiceReport>& out) {
  if (face != nullptr) face->report_services(out);
}

Result<std::vector<ParameterReport>, Problem> NodeServices::parameters(std::uint64_t id) const {
  if (id == kOwnNode) return report_of(own_parameters_);
  return container_.impl_->parameters_of(id);
}

void NodeServices::set_parameters(std::uint64_t id, std::vector<Parameter> parameters, bool atomically,
                                  std::weak_ptr<void> asker, const Then& then) {
  if (id == kOwnNode) return then(set_in(own_parameters_, parameters, atomically, [](const auto&) {}));
  container_.impl_->change_parameters(id, std::move(parameters), atomically, std::move(asker), then);
}

StateId NodeServices::state(std::uint64_t id) const {
  if (const auto other = container_.impl_->foreign_component(id)) return other->info().state;
  const LockGuard lock(container_.impl_->mutex);  // a listed component is not destroyed meanwhile
  const auto found = container_.impl_->records.find(id);
  if (found == container_.impl_->records.end() || found->second->managed == nullptr) return StateId::Unknown;
  return found->second->managed->get_current_state().state();
}

TransitionOutcome NodeServices::trigger(std::uint64_t id, Transition transition) const {
  return container_.trigger(id, transition);
}

}  // namespace nacelle::runtime
