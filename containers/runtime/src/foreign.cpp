// SPDX-License-Identifier: Apache-2.0
// Components of this container in other processes, and their connection to it.
#include "container_impl.hpp"
#include "nacelle/base/name_fault.hpp"
#include "nacelle/node/base_wheels.hpp"

namespace nacelle::runtime {

Result<ComponentInfo, Problem> Container::adopt(std::shared_ptr<ForeignComponent> component) {
  ComponentInfo info = component->info();
  UniqueLock lock(impl_->mutex);
  bool taken = impl_->names.contains(info.node);
  for (const auto& [id, other] : impl_->foreign) taken = taken || other->info().node == info.node;
  if (taken) {
    return err(Problem{"component " + info.node, "a node of that name is loaded already", "give this one another name",
                       NameFault::Taken, info.node});
  }
  info.id = impl_->next_id++;
  impl_->foreign.emplace(info.id, std::move(component));
  lock.unlock();
  // Its own process offers the other services. These answer as long as it is listed, also when the process has ended.
  if (impl_->node_services && info.managed) {
    auto face = impl_->node_services->offer(info.id, info.node, NodeFace::Parts::Lifecycle);
    lock.lock();
    impl_->foreign_faces.emplace(info.id, std::move(face));
    lock.unlock();
  }
  impl_->note_change();
  return info;
}

void Container::tell_fault(const ComponentInfo& info, const std::string& callback) {
  impl_->history.lock()->add(
      {0, info.node, info.fault.code, info.fault.text, callback, impl_->commons.clock.wall_now()});
  impl_->log.error("{} is faulted: {}: {}", info.node, info.fault.code, info.fault.text);
  const std::function<void(const ComponentInfo&)> listener = *impl_->fault_listener.lock();
  if (listener) listener(info);
  impl_->note_change();
}

void Container::tell_open_fault(const FaultEvent& event) { impl_->tell_open_fault(event); }

void Container::tell_state(const StateChange& change) {
  const std::function<void(const StateChange&)> listener = *impl_->state_listener.lock();
  if (listener) listener(change);
}

void Container::tell_change() { impl_->note_change(); }

std::shared_ptr<ForeignComponent> Container::Impl::foreign_component(std::uint64_t id) const {
  const LockGuard lock(mutex);
  const auto found = foreign.find(id);
  return found == foreign.end() ? nullptr : found->second;
}

std::vector<std::string> Container::ties() const {
  std::vector<std::string> ties = impl_->commons.frames.claims();
  auto objects = impl_->commons.shared_objects.lock();
  for (const auto& [name, object] : *objects) {
    // Each process has its own MotionStops, and also counts those reported by the other process; and its own facts, of the
    // network, too. An isolated component has no information about other machines' clocks, so its messages name no cause.
    // It also has no information about a base in another process, and uses its own parameters.
    if (object != impl_->commons.motion_stops && object != impl_->commons.facts &&
        object != impl_->commons.clock_skews && name != kNetworkFactsName && name != kBaseWheelsName)
      ties.push_back("shares the object '" + name + "'");
  }
  return ties;
}

}  // namespace nacelle::runtime
