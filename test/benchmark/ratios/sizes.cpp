// SPDX-License-Identifier: Apache-2.0
#include <std_msgs/msg/u_int64.hpp>

#include "handover/reader.hpp"
#include "ratios/ratio.hpp"
#include "support/rig.hpp"

namespace nacelle::bench {
namespace {

constexpr std::uint64_t kMessages = 2000;  // per block

// A stream in one component whose reader publishes the next message.
class Loop final : public Recipe {
 public:
  Loop(std::string name, std::uint64_t bytes) : name_(std::move(name)), bytes_(bytes) {}

  std::shared_ptr<void> build(LifecycleNode& node) override {
    publisher_ = node.create_publisher<Large>(name_, QoS(10));
    auto start = node.create_subscription<std_msgs::msg::UInt64>(name_ + "/go", QoS(1),
                                                                 [this](const std_msgs::msg::UInt64& messages) {
                                                                   left_ = messages.data;
                                                                   begin_ = clock_.now();
                                                                   send();
                                                                 });
    auto heard = node.create_subscription<Large>(name_, QoS(10), [this](const Large&) { send(); });
    return keep(std::move(start), std::move(heard));
  }
  /// Nanoseconds per message of one block.
  double block(Writer& go) {
    Block* const order = go.borrow();
    static_cast<std_msgs::msg::UInt64*>(order->message)->data = kMessages;
    static_cast<void>(go.publish(*order));
    done_.wait();
    done_.clear();
    return to_seconds(took_) * 1e9 / kMessages;
  }
  void leave() { publisher_.reset(); }
  [[nodiscard]] const std::string& name() const { return name_; }

 private:
  void send() {
    if (left_-- == 0) {
      took_ = clock_.now() - begin_;
      return done_.set();
    }
    Loan<Large> message = publisher_->borrow();
    fill(*message, bytes_, left_);
    publisher_->publish(std::move(message));
  }

  const std::string name_;
  const std::uint64_t bytes_;
  const SystemClock clock_;
  std::shared_ptr<Publisher<Large>> publisher_;
  std::uint64_t left_ = 0;
  MonotonicTime begin_;
  Duration took_{};
  Event done_;
};

}  // namespace

Ratio compare_sizes(std::uint64_t small, std::uint64_t large, std::uint64_t blocks) {
  Loop large_loop("/large", large), small_loop("/small", small);
  Rig rig;
  rig.add("large", large_loop);
  rig.add("small", small_loop);
  const auto starter = [&](const Loop& loop) {
    return rig.container().transport().create_writer(
        {loop.name() + "/go", &std_msgs::msg::UInt64::message_type(), QoS(1), "/main"});
  };
  const auto large_go = starter(large_loop), small_go = starter(small_loop);
  const Ratio ratio = interleave(
      blocks, [&] { return large_loop.block(*large_go); }, [&] { return small_loop.block(*small_go); });
  large_loop.leave();
  small_loop.leave();
  return ratio;
}

}  // namespace nacelle::bench
