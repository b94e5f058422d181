// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <condition_variable>
#include <memory>
#include <mutex>
#include <sensor_msgs/msg/image.hpp>
#include <std_msgs/msg/string.hpp>
#include <string>
#include <vector>

#include "nacelle/msgs/message_type.hpp"
#include "nacelle/runtime/pool.hpp"
#include "nacelle/transport_local/carrier.hpp"

namespace nacelle::test {

/// A sink that keeps arriving messages until let_go(). Threads: the carrier's calls, and one test's.
class KeepingSink final : public CarrierSink {
 public:
  struct Arrival {
    Block* block;
    MessageInfo info;
  };

  explicit KeepingSink(const msgs::MessageType& type) : pool_(type) {}
  ~KeepingSink() override { let_go(); }

  Block* borrow() noexcept override {
    const std::lock_guard lock(mutex_);
    return refuses_ ? nullptr : pool_.borrow();
  }
  void deliver(Block& block, const MessageInfo& info) noexcept override {
    const std::lock_guard lock(mutex_);
    arrived_.push_back({&block, info});
    changed_.notify_all();
  }
  void note_broken(const char* why) noexcept override {
    const std::lock_guard lock(mutex_);
    broken_.emplace_back(why);
    changed_.notify_all();
  }
  bool may_lend() const noexcept override { return may_lend_; }

  void set_refuses(bool refuses) {
    const std::lock_guard lock(mutex_);
    refuses_ = refuses;
  }
  void set_may_lend(bool may_lend) { may_lend_ = may_lend; }
  /// Waits until that many have come; CTest's time limit is the only one.
  std::vector<Arrival> wait_for(std::size_t count) {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return arrived_.size() >= count; });
    return arrived_;
  }
  std::vector<std::string> wait_for_broken(std::size_t count) {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return broken_.size() >= count; });
    return broken_;
  }
  [[nodiscard]] std::size_t count() const {
    const std::lock_guard lock(mutex_);
    return arrived_.size();
  }
  /// Gives all messages back, as readers that are done with them do.
  void let_go() {
    std::vector<Arrival> gone;
    {
      const std::lock_guard lock(mutex_);
      gone.swap(arrived_);
    }
    for (const Arrival& one : gone) drop_reference(*one.block);
  }

 private:
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  runtime::MessagePool pool_;
  std::vector<Arrival> arrived_;
  std::vector<std::string> broken_;
  bool refuses_ = false;
  bool may_lend_ = true;
};

/// The broker's side of the sender: stamps and sends, and drops its reference as the link does.
template <typename T>
class Sender {
 public:
  explicit Sender(CarrierWriter& writer, std::uint64_t id = 7) : writer_(writer), id_(id) {}

  /// A message that borrow() gives, prepared.
  Block& borrow() {
    Block* const block = pool_.borrow();
    writer_.prepare(*block);
    return *block;
  }
  CarrierWriter::Sent send(Block& block) {
    block.info = {id_, ++sequence_, MonotonicTime{Duration{1000 + static_cast<std::int64_t>(sequence_)}}, {}};
    block.expires = MonotonicTime{Duration{9000 + static_cast<std::int64_t>(sequence_)}};
    const auto sent = writer_.send(block);
    drop_reference(block);
    return sent;
  }
  CarrierWriter::Sent send(const T& message) {
    Block* const block = pool_.borrow();
    *static_cast<T*>(block->message) = message;
    return send(*block);
  }

 private:
  CarrierWriter& writer_;
  std::uint64_t id_;
  std::uint64_t sequence_ = 0;
  runtime::MessagePool pool_{T::message_type()};
};

template <typename T>
const T& message_in(const KeepingSink::Arrival& arrival) {
  return *static_cast<const T*>(arrival.block->message);
}

inline sensor_msgs::msg::Image image_of(std::size_t bytes, std::uint8_t seed) {
  sensor_msgs::msg::Image image;
  image.header.frame_id = "camera";
  image.encoding = "mono8";
  image.height = 1;
  image.width = static_cast<std::uint32_t>(bytes);
  image.data.resize(bytes);
  for (std::size_t i = 0; i < bytes; ++i) image.data[i] = static_cast<std::uint8_t>(seed + i * 31);
  return image;
}

inline std_msgs::msg::String text_of(std::size_t number) {
  std_msgs::msg::String text;
  text.data = "message " + std::to_string(number);
  return text;
}

}  // namespace nacelle::test
