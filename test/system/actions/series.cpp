// SPDX-License-Identifier: Apache-2.0
// Offers ~/series: counts Fibonacci's numbers, one each `period_ms`. What a component with an action looks like.
//
//   order < 0     rejected
//   order 13      aborted half-way
//   order 170     does not let itself be canceled
#include <example_interfaces/action/fibonacci.hpp>

#include "nacelle/node/action_server.hpp"
#include "nacelle/node/component.hpp"

namespace nacelle::test {

using example_interfaces::action::Fibonacci;

class Series final : public LifecycleNode {
 public:
  explicit Series(const NodeOptions& options) : LifecycleNode("series", options) {
    const auto period_ms = declare_parameter("period_ms", 5);
    server_ = action::create_server<Fibonacci>(
        this, "~/series",
        [](const action::GoalUUID&, const std::shared_ptr<const Fibonacci::Goal>& goal) {
          return goal->order < 0 ? action::GoalResponse::REJECT : action::GoalResponse::ACCEPT_AND_EXECUTE;
        },
        [](const std::shared_ptr<Handle>& goal) {
          return goal->get_goal()->order == 170 ? action::CancelResponse::REJECT : action::CancelResponse::ACCEPT;
        },
        [this](std::shared_ptr<Handle> goal) {
          works_.push_back({std::move(goal), {}});
        });
    beat_ = create_wall_timer(std::chrono::milliseconds{period_ms}, [this] { step(); });
  }

 private:
  using Handle = action::ServerGoalHandle<Fibonacci>;
  struct Work {
    std::shared_ptr<Handle> goal;
    std::vector<std::int32_t> numbers;
  };

  // Of long series too: it wraps.
  static std::int32_t sum(std::int32_t a, std::int32_t b) {
    return static_cast<std::int32_t>(static_cast<std::uint32_t>(a) + static_cast<std::uint32_t>(b));
  }
  void step() {
    for (Work& work : works_) advance(work);
    std::erase_if(works_, [](const Work& work) { return !work.goal->is_active(); });
  }
  static void advance(Work& work) {
    auto& numbers = work.numbers;
    const std::size_t n = numbers.size();
    const auto order = static_cast<std::size_t>(work.goal->get_goal()->order);
    auto result = std::make_shared<Fibonacci::Result>();
    result->sequence.assign(numbers.begin(), numbers.end());
    if (work.goal->is_canceling()) {
      work.goal->canceled(std::move(result));
    } else if (order == 13 && n == 6) {
      work.goal->abort(std::move(result));
    } else if (n > order) {
      work.goal->succeed(std::move(result));
    } else {
      numbers.push_back(n < 2 ? static_cast<std::int32_t>(n) : sum(numbers[n - 1], numbers[n - 2]));
      Fibonacci::Feedback feedback;
      feedback.sequence.assign(numbers.begin(), numbers.end());
      work.goal->publish_feedback(feedback);
    }
  }

  std::vector<Work> works_;
  std::shared_ptr<action::Server<Fibonacci>> server_;
  Timer::SharedPtr beat_;
};

}  // namespace nacelle::test

NACELLE_REGISTER_COMPONENT(nacelle::test::Series)
