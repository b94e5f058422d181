// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <deque>
#include <memory>
#include <numeric>
#include <std_msgs/msg/float64.hpp>
#include <std_srvs/srv/trigger.hpp>
#include <string>

#include "nacelle/node/component.hpp"

namespace example {

using std_msgs::msg::Float64;
using std_srvs::srv::Trigger;

/// Subscribes to `raw` and publishes the mean of the last `window` values on `mean`. The service `~/reset` clears
/// them. Values that are no number are ignored. The callbacks take turns, so nothing is locked.
class MeanFilter final : public nacelle::LifecycleNode {
 public:
  explicit MeanFilter(const nacelle::NodeOptions& options)
      : LifecycleNode("mean_filter", options),
        window_(static_cast<std::size_t>(declare_parameter(
            "window", 10,
            {.description = "values", .read_only = true, .integer_range = nacelle::IntegerRange{1, 1000, 0}}))) {
    mean_ = create_publisher<Float64>("mean", nacelle::QoS(10));
    raw_ = create_subscription<Float64>("raw", nacelle::QoS(10), [this](const Float64& value) { add(value.data); });
    reset_ = create_service<Trigger>("~/reset", [this](const Trigger::Request&, Trigger::Response& response) {
      response.message = std::to_string(values_.size()) + " values cleared";
      response.success = true;
      values_.clear();
    });
  }

 private:
  void add(double value) {
    if (!std::isfinite(value)) return;
    values_.push_back(value);
    if (values_.size() > window_) values_.pop_front();
    Float64 mean;
    mean.data = std::accumulate(values_.begin(), values_.end(), 0.0) / static_cast<double>(values_.size());
    mean_->publish(mean);
  }

  const std::size_t window_;
  std::deque<double> values_;
  std::shared_ptr<nacelle::Publisher<Float64>> mean_;
  nacelle::Subscription<Float64>::SharedPtr raw_;
  nacelle::Service<Trigger>::SharedPtr reset_;
};

}  // namespace example

NACELLE_REGISTER_COMPONENT(example::MeanFilter)
