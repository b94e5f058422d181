// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <vector>

#include "nacelle/msgs/message_type.hpp"
#include "nacelle/node/publisher.hpp"

namespace nacelle::camera {

/// A topic with one reader, the test, and a pool as the runtime's: messages come back recycled, with their capacity.
///
/// It keeps no message but those that the test takes, so that a camera's buffers return. Threads: one.
template <typename T>
class PooledWriter final : public Writer, public BlockHome {
 public:
  explicit PooledWriter(std::size_t most) : most_(most) { free_.reserve(most); }

  std::function<void(const T&)> on_message;
  std::vector<Block*> kept;  ///< With keep_next: still referenced, as by a slow reader.
  bool keep_next = false;
  std::size_t readers = 1;  ///< As the publisher sees it.

  Block* borrow() override {
    if (free_.empty()) {
      if (made_.size() == most_) return nullptr;
      made_.push_back(std::make_unique<Made>());
      made_.back()->block.home = this;
      made_.back()->block.message = &made_.back()->message;
      return &made_.back()->block;
    }
    Block* const block = free_.back();
    free_.pop_back();
    block->references.store(1);
    return block;
  }
  Block* adopt(void*) override { return nullptr; }
  PublishResult publish(Block& block) override {
    ++counters_.published;
    if (on_message) on_message(*static_cast<const T*>(block.message));
    if (keep_next) {
      kept.push_back(&block);
      keep_next = false;
    } else {
      drop_reference(block);
    }
    return PublishResult::Published;
  }
  std::size_t reader_count() const override { return readers; }
  void assert_liveliness() override {}
  WriterCounters counters() const override { return counters_; }
  EndpointStatus status() const override { return {}; }
  std::uint64_t id() const override { return 1; }
  void reclaim(Block& block) noexcept override {
    T::message_type().recycle(block.message);
    free_.push_back(&block);
  }
  [[nodiscard]] std::size_t out() const { return made_.size() - free_.size(); }

 private:
  struct Made {
    Block block;
    T message;
  };
  const std::size_t most_;
  std::vector<std::unique_ptr<Made>> made_;
  std::vector<Block*> free_;
  WriterCounters counters_;
};

/// A publisher over such a writer; the writer stays the test's to ask.
template <typename T>
struct PooledTopic {
  explicit PooledTopic(std::size_t most)
      : writer(new PooledWriter<T>(most)), publisher("/topic", QoS(1), std::unique_ptr<Writer>(writer)) {}
  PooledWriter<T>* writer;  ///< Owned by the publisher.
  Publisher<T> publisher;
};

}  // namespace nacelle::camera
