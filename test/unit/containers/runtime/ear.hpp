// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <condition_variable>
#include <memory>
#include <mutex>
#include <std_msgs/msg/string.hpp>
#include <string>

#include "nacelle/runtime/container.hpp"

namespace nacelle::runtime {

/// Waits for texts on a topic, by event.
class Ear final : ReadyListener {
 public:
  Ear(Container& container, const std::string& topic, const QoS& qos = QoS(1000).transient_local())
      : reader_(container.transport().create_reader({topic, &std_msgs::msg::String::message_type(), qos, "/ear"},
                                                    Taking::Share, this)) {}
  ~Ear() override { reader_.reset(); }
  std::string next() {
    std::unique_lock lock(mutex_);
    if (!arrived_.wait_for(lock, 20s, [&] { return count_ > 0; })) return "(silence)";
    --count_;
    lock.unlock();
    Block* const block = reader_->take();
    std::string text = static_cast<const std_msgs::msg::String*>(block->message)->data;
    drop_reference(*block);
    return text;
  }

 private:
  void on_ready() noexcept override {
    const std::lock_guard lock(mutex_);
    ++count_;
    arrived_.notify_all();
  }
  std::mutex mutex_;
  std::condition_variable arrived_;
  int count_ = 0;
  std::unique_ptr<Reader> reader_;
};

}  // namespace nacelle::runtime
