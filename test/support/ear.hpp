// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <condition_variable>
#include <cstdint>
#include <memory>
#include <mutex>
#include <stdexcept>
#include <string>

#include "nacelle/host/transport.hpp"

namespace nacelle::test {

/// Reads a topic without a node, and waits for its messages by event. Threads: one.
template <typename T>
class Ear : ReadyListener {
 public:
  Ear(Transport& transport, const std::string& topic, const QoS& qos)
      : topic_(topic),
        reader_(transport.create_reader({topic, &T::message_type(), qos, "/ear"}, Taking::Share, this)) {}
  ~Ear() override { reader_.reset(); }

  /// Returns whether a message waits, after `limit` at most.
  bool waits(Duration limit) {
    std::unique_lock lock(mutex_);
    return arrived_.wait_for(lock, limit, [&] { return count_ > 0; });
  }
  /// Returns the next message. Throws std::runtime_error, which fails the test, if none comes within 20 s.
  T next() {
    if (!waits(20s)) throw std::runtime_error{"no message on " + topic_};
    {
      const std::lock_guard lock(mutex_);
      --count_;
    }
    Block* const block = reader_->take();
    T message = *static_cast<const T*>(block->message);
    writer_ = block->info.writer_id;
    drop_reference(*block);
    return message;
  }
  /// Returns the id of the endpoint that wrote the last message that next() returned.
  [[nodiscard]] std::uint64_t writer() const { return writer_; }

 private:
  void on_ready() noexcept override {
    const std::lock_guard lock(mutex_);
    ++count_;
    arrived_.notify_all();
  }
  const std::string topic_;
  std::uint64_t writer_ = 0;
  std::mutex mutex_;
  std::condition_variable arrived_;
  int count_ = 0;
  std::unique_ptr<Reader> reader_;
};

}  // namespace nacelle::test
