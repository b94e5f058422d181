// SPDX-License-Identifier: Apache-2.0
#include "replay/replay_output.hpp"

#include <algorithm>
#include <optional>
#include <utility>

#include "record/model/bag_metadata.hpp"

namespace nacelle::replay {
namespace {

/// A reader that fits all of these publishers.
QoS fitting(const std::vector<QoS>& offered) {
  const auto all = [&](auto holds) { return std::ranges::all_of(offered, holds); };
  std::size_t history = 1;
  for (const QoS& one : offered) history += one.resolved().queue_capacity();
  QoS qos{std::min<std::size_t>(history, 1000)};
  qos.best_effort();
  if (all([](const QoS& one) { return one.resolved().reliability() == Reliability::Reliable; })) qos.reliable();
  if (all([](const QoS& one) { return one.resolved().durability() == Durability::TransientLocal; }))
    qos.transient_local();
  return qos;
}

}  // namespace

struct ReplayOutput::Stream final : ReadyListener {
  explicit Stream(ReplayOutput& o) : owner(o) {}
  void on_ready() noexcept override {
    if (reader) owner.take(*this);
  }
  ReplayOutput& owner;
  const msgs::MessageType* type = nullptr;
  std::uint16_t channel = 0;
  std::uint64_t* count = nullptr;
  std::unique_ptr<Reader> reader;
};

ReplayOutput::ReplayOutput(record::ByteSink& sink, record::Compression compression, Transport& transport,
                           const Clock& clock, std::function<bool(std::uint64_t writer)> is_input)
    : writer_(sink, {.compression = compression}),
      transport_(transport),
      clock_(clock),
      is_input_(std::move(is_input)),
      has_failed_(!writer_.start()) {}

ReplayOutput::~ReplayOutput() = default;

void ReplayOutput::add(const std::string& topic, const msgs::MessageType& type, const std::vector<QoS>& offered) {
  auto& stream = streams_[topic];
  if (stream) return;
  stream = std::make_unique<Stream>(*this);
  stream->type = &type;
  stream->count = &messages_[topic];
  const auto schema = writer_.add_schema(type.name, "ros2msg", type.definition);
  const auto channel = schema ? writer_.add_channel(*schema, topic, "cdr",
                                                    {{"offered_qos_profiles", record::offered_qos_profiles(offered)},
                                                     {"topic_type_hash", type.hash}})
                              : std::nullopt;
  has_failed_ = has_failed_ || !channel;
  stream->channel = channel.value_or(0);
  EndpointSpec spec;
  spec.topic = topic;
  spec.type = &type;
  spec.qos = fitting(offered);
  stream->reader = transport_.create_reader(spec, Taking::Share, stream.get());
  take(*stream);  // what came while it was made
}

void ReplayOutput::take(Stream& stream) {
  const auto now = static_cast<std::uint64_t>(std::max<std::int64_t>(0, clock_.wall_now().nanoseconds()));
  while (Block* const block = stream.reader->take()) {
    if (!is_input_(block->info.writer_id) && !has_failed_) {
      const std::size_t size = stream.type->encoded_size(block->message);
      has_failed_ = !writer_.write({stream.channel, 0, now, now, {}}, size,
                                   [&](ByteSpan out) { stream.type->encode(block->message, out.data()); });
      ++*stream.count;
    }
    drop_reference(*block);
  }
}

void ReplayOutput::write(const record::OrderedMessages::Topic& topic, const record::OrderedMessages::Message& message) {
  if (has_failed_) return;
  auto known = channels_.find(message.topic);
  if (known == channels_.end()) {
    const auto schema = topic.type.empty() ? std::optional<std::uint16_t>{std::uint16_t{0}}
                                           : writer_.add_schema(topic.type, topic.schema_encoding, topic.definition);
    const auto channel =
        schema ? writer_.add_channel(*schema, topic.name, topic.message_encoding, topic.metadata) : std::nullopt;
    if (!channel) {
      has_failed_ = true;
      return;
    }
    known = channels_.emplace(message.topic, *channel).first;
  }
  has_failed_ = !writer_.write(
      {known->second, message.sequence, message.log_time, message.publish_time, record::McapRest{message.data}});
}

bool ReplayOutput::finish() {
  streams_.clear();
  if (has_failed_ || !writer_.finish()) has_failed_ = true;
  return !has_failed_;
}

}  // namespace nacelle::replay
