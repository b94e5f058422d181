// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>
#include <utility>

#include "nacelle/host/message.hpp"
#include "nacelle/host/transport.hpp"
#include "nacelle/node/qos_event.hpp"

namespace nacelle {

/// What a publisher can be told beside topic and QoS; rclcpp's words.
struct PublisherOptions {
  CallbackGroup::SharedPtr callback_group;  ///< Of the event callbacks. Null: the node's own.
  PublisherEventCallbacks event_callbacks;
};

/// Sends messages of one type to one topic.
///
/// Three ways, cheapest first: borrow() a pooled message, set every field, publish(Loan) (no allocation, no copy);
/// publish(unique_ptr) adopts a heap message (no copy); publish(const T&) copies it, which is counted.
///
/// Threads:   belongs to one thread at a time (the component's executor, or the I/O thread it was handed to).
/// Allocates: nothing in steady state with borrow().
template <typename T>
class Publisher {
 public:
  using SharedPtr = std::shared_ptr<Publisher>;

  Publisher(std::string topic, QoS qos, std::unique_ptr<Writer> writer,
            std::unique_ptr<detail::PublisherEvents> events = nullptr)
      : topic_(std::move(topic)), qos_(std::move(qos)), events_(std::move(events)), writer_(std::move(writer)) {
    if (events_) events_->watch(*writer_);
  }

  /// A message of the topic's pool with an earlier message's values and capacity. Empty only if the pool is dry, must not grow
  /// (QoS::when_dry()), and an earlier one that was borrowed from the dry pool is still held.
  [[nodiscard]] Loan<T> borrow() {
    Block* const block = writer_->borrow();
    if (block == nullptr) return {};
    return Loan<T>{static_cast<T*>(block->message), ReturnToStore{block}};
  }
  /// Gives the message away. An empty loan is dropped silently: borrow() has counted it.
  PublishResult publish(Loan<T> message) {
    if (!message) return PublishResult::WouldBlock;
    Block* const block = message.get_deleter().block();
    static_cast<void>(message.release());
    return writer_->publish(*block);
  }
  PublishResult publish(std::unique_ptr<T> message) { return writer_->publish(*writer_->adopt(message.release())); }
  PublishResult publish(const T& message) {
    Loan<T> copy = borrow();
    if (!copy) return PublishResult::WouldBlock;
    *copy = message;
    return publish(std::move(copy));
  }

  [[nodiscard]] const std::string& get_topic_name() const { return topic_; }
  [[nodiscard]] const QoS& get_actual_qos() const { return qos_; }
  [[nodiscard]] std::size_t get_subscription_count() const { return writer_->reader_count(); }
  [[nodiscard]] WriterCounters counters() const { return writer_->counters(); }
  [[nodiscard]] EndpointStatus status() const { return writer_->status(); }
  /// Shows life without a message (liveliness manual_by_topic). Threads: any.
  void assert_liveliness() { writer_->assert_liveliness(); }

 private:
  std::string topic_;
  QoS qos_;
  std::unique_ptr<detail::PublisherEvents> events_;  // outlives the writer that calls it
  std::unique_ptr<Writer> writer_;
};

}  // namespace nacelle
