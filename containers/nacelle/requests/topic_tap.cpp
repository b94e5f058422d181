// SPDX-License-Identifier: Apache-2.0
#include "requests/topic_tap.hpp"

namespace nacelle::requests {

TopicTap::TopicTap(Transport& transport, const std::string& topic, const msgs::MessageType& type, std::size_t depth)
    : topic_(topic), type_(type) {
  // No node name: the endpoint of a tool.
  EndpointSpec spec{topic, &type, QoS{KeepLast{depth}}.best_effort(), ""};
  reader_ = transport.create_reader(spec, Taking::Share, this);
  const std::size_t all = reader_->writer_count();
  spec.qos.transient_local();
  auto with_history = transport.create_reader(spec, Taking::Share, this);
  if (all != 0 && with_history->writer_count() == all) reader_ = std::move(with_history);
}

TopicTap::TopicTap(Transport& transport, const EndpointSpec& spec) : topic_(spec.topic), type_(*spec.type) {
  reader_ = transport.create_reader(spec, Taking::Share, this);
}

TopicTap::~TopicTap() = default;

Block* TopicTap::take() {
  Block* const block = reader_->take();
  if (block != nullptr) return block;
  event_.silence();
  // A message that came between the two lines above has found the event set, and would be slept through.
  return reader_->take();
}

void TopicTap::on_ready() noexcept { event_.ring(); }

}  // namespace nacelle::requests
