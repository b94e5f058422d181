// SPDX-License-Identifier: Apache-2.0
#include <example_interfaces/action/fibonacci.hpp>

#include "nacelle/node/action_server.hpp"
#include "nacelle/node/component.hpp"

namespace nacelle::examples {

using example_interfaces::action::Fibonacci;

/// Offers the action ~/series, which counts the first Fibonacci numbers up to the goal's order, one each `period`; `share` may be
/// set while it runs, and `note` deleted. Try the commands of docs/cli.md on it.
class Series final : public LifecycleNode {
 public:
  explicit Series(const NodeOptions& options) : LifecycleNode("series", options) {
    declare_parameter("share", 0.5,
                      {.description = "a number that may be set, to try `param set` on",
                       .floating_point_range = FloatingPointRange{0.0, 1.0, 0.0}});
    declare_parameter("note", "as launched",
                      {.description = "any value, or none: to try `param delete` on", .dynamic_typing = true});
    const double period_s = declare_parameter("period", 0.05,
                                              {.description = "s between two numbers",
                                               .read_only = true,
                                               .floating_point_range = FloatingPointRange{0.001, 10.0, 0.0}});
    server_ = action::create_server<Fibonacci>(
        this, "~/series",
        [](const action::GoalUUID&, const std::shared_ptr<const Fibonacci::Goal>& goal) {
          return goal->order < 0 || goal->order > kLastOrder ? action::GoalResponse::REJECT
                                                             : action::GoalResponse::ACCEPT_AND_EXECUTE;
        },
        [](const std::shared_ptr<Handle>&) { return action::CancelResponse::ACCEPT; },
        [this](std::shared_ptr<Handle> goal) {
          works_.push_back({std::move(goal), {}});
        });
    beat_ = create_wall_timer(from_seconds(period_s), [this] { step(); });
  }

 private:
  using Handle = action::ServerGoalHandle<Fibonacci>;
  static constexpr int kLastOrder = 46;  // the last number that 32 bits hold
  struct Work {
    std::shared_ptr<Handle> goal;
    std::vector<std::int32_t> numbers;
  };

  void step() {
    for (Work& work : works_) advance(work);
    std::erase_if(works_, [](const Work& work) { return !work.goal->is_active(); });
  }
  static void advance(Work& work) {
    auto& numbers = work.numbers;
    const std::size_t n = numbers.size();
    const bool is_done = n > static_cast<std::size_t>(work.goal->get_goal()->order);
    if (is_done || work.goal->is_canceling()) {
      auto result = std::make_shared<Fibonacci::Result>();
      result->sequence.assign(numbers.begin(), numbers.end());
      if (is_done) {
        work.goal->succeed(std::move(result));
      } else {
        work.goal->canceled(std::move(result));
      }
      return;
    }
    numbers.push_back(n < 2 ? static_cast<std::int32_t>(n) : numbers[n - 1] + numbers[n - 2]);
    Fibonacci::Feedback feedback;
    feedback.sequence.assign(numbers.begin(), numbers.end());
    work.goal->publish_feedback(feedback);
  }

  std::vector<Work> works_;
  std::shared_ptr<action::Server<Fibonacci>> server_;
  Timer::SharedPtr beat_;
};

}  // namespace nacelle::examples

template <>
inline constexpr nacelle::ComponentAbout nacelle::kComponentAbout<nacelle::examples::Series>{
    .purpose = "Counts Fibonacci numbers as an action: something to try commands on."};

NACELLE_REGISTER_COMPONENT(nacelle::examples::Series)
