// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "nacelle/node/node.hpp"

namespace nacelle {

/// Lookups of transforms that wait without keeping a thread: tf2_ros's Buffer::waitForTransform.
///
///     waits_ = std::make_unique<TransformWaits<spatial::TransformBuffer>>(*this, buffer_);   // in the constructor
///     waits_->when("map", "laser", time, 200ms, [this](const auto& found) { ... });          // on the executor
///
/// `Buffer` is spatial::TransformBuffer, or what looks like it: this floor does not know it. An answer comes as soon as the
/// transform is there, or with the fault of the last look when the time is up (in steps of 10 ms, on the node's monotonic clock;
/// not while the node is inactive). What still waits when this goes is not answered.
/// Threads: callbacks of the node's own group. Allocates: for each wait.
template <typename Buffer>
class TransformWaits final : private Buffer::Listener {
 public:
  using Answer = decltype(std::declval<const Buffer&>().lookup(std::string_view{}, std::string_view{}, WallTime{}));
  using Callback = std::function<void(const Answer&)>;

  TransformWaits(Node& node, std::shared_ptr<Buffer> buffer)
      : clock_(node.steady_clock()),
        buffer_(std::move(buffer)),
        wake_up_(node.create_wake_up([this] { look(); })),
        timer_(node.create_wall_timer(10ms, [this] { look(); })) {
    timer_->cancel();
    buffer_->add_listener(*this);
  }
  TransformWaits(const TransformWaits&) = delete;
  TransformWaits& operator=(const TransformWaits&) = delete;
  ~TransformWaits() { buffer_->remove_listener(*this); }

  /// The transform at a time (0: the latest). The callback runs before this returns if there is nothing to wait for.
  /// Returns a number for cancel(); 0 if the answer was given.
  std::uint64_t when(const std::string& target, const std::string& source, WallTime at, Duration timeout,
                     Callback callback) {
    return add([=](const Buffer& buffer) { return buffer.lookup(target, source, at); }, timeout, std::move(callback));
  }
  /// Between two times, through a frame that stays where it is meanwhile.
  std::uint64_t when(const std::string& target, WallTime target_time, const std::string& source, WallTime source_time,
                     const std::string& fixed, Duration timeout, Callback callback) {
    return add([=](const Buffer& buffer) { return buffer.lookup(target, target_time, source, source_time, fixed); },
               timeout, std::move(callback));
  }
  /// Forgets a wait; its callback does not run any more.
  void cancel(std::uint64_t number) {
    std::erase_if(waits_, [number](const Wait& wait) { return wait.number == number; });
  }
  [[nodiscard]] std::size_t size() const { return waits_.size(); }

 private:
  using Look = std::function<Answer(const Buffer&)>;
  struct Wait {
    std::uint64_t number;
    Look look;
    MonotonicTime deadline;
    Callback callback;
  };

  void on_insert() noexcept override {
    if (pending_.load(std::memory_order_relaxed)) wake_up_->wake();
  }

  std::uint64_t add(Look look, Duration timeout, Callback callback) {
    // Before the look: an insert after it wakes us.
    pending_.store(true, std::memory_order_seq_cst);
    const Answer found = look(*buffer_);
    if (found || timeout <= 0ns) {
      pending_.store(!waits_.empty(), std::memory_order_seq_cst);
      callback(found);
      return 0;
    }
    if (waits_.empty()) timer_->reset();
    waits_.push_back({++last_, std::move(look), clock_.now() + timeout, std::move(callback)});
    return last_;
  }

  void look() {
    const MonotonicTime now = clock_.now();
    // A callback may add and cancel: each is taken out before it runs, and what it adds has had its look.
    for (std::size_t i = 0; i < waits_.size();) {
      const Answer found = waits_[i].look(*buffer_);
      if (!found && now < waits_[i].deadline) {
        ++i;
        continue;
      }
      const Callback callback = std::move(waits_[i].callback);
      waits_.erase(waits_.begin() + static_cast<std::ptrdiff_t>(i));
      callback(found);
      i = 0;
    }
    if (!waits_.empty()) return;
    pending_.store(false, std::memory_order_seq_cst);
    timer_->cancel();
  }

  const Clock& clock_;
  const std::shared_ptr<Buffer> buffer_;
  std::vector<Wait> waits_;
  std::uint64_t last_{0};
  std::atomic<bool> pending_{false};
  std::shared_ptr<WakeUp> wake_up_;
  std::shared_ptr<Timer> timer_;
};

}  // namespace nacelle
