// SPDX-License-Identifier: Apache-2.0
#include "parameter_events.hpp"

#include <rcl_interfaces/msg/parameter_event.hpp>

#include "nacelle/host/standard_interfaces.hpp"
#include "nacelle/qos/presets.hpp"
#include "nacelle/runtime/parameter_messages.hpp"

namespace nacelle::runtime {
namespace {

using rcl_interfaces::msg::ParameterEvent;

template <typename Sequence>
void fill(Sequence& to, const std::vector<Parameter>& from) {
  to.clear();
  for (const auto& parameter : from) to.push_back(message_of(parameter));
}

}  // namespace

ParameterEvents::ParameterEvents(Transport& transport, const Clock& clock, std::string node)
    : clock_(clock), node_(std::move(node)) {
  EndpointSpec spec{kParameterEventsTopic, &ParameterEvent::message_type(), ParameterEventsQoS{}, node_};
  spec.reserves = false;
  *writer_.lock() = transport.create_writer(spec);
}

void ParameterEvents::on_change(const ParameterChange& change) noexcept {
  auto writer = writer_.lock();
  if (!*writer || (*writer)->reader_count() == 0) return;
  Block* const block = (*writer)->borrow();
  if (block == nullptr) return;
  auto& event = *static_cast<ParameterEvent*>(block->message);
  event.stamp = clock_.wall_now();
  event.node = node_;
  fill(event.new_parameters, change.declared);
  fill(event.changed_parameters, change.set);
  fill(event.deleted_parameters, change.undeclared);
  static_cast<void>((*writer)->publish(*block));
}

}  // namespace nacelle::runtime
