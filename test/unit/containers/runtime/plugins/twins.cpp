// SPDX-License-Identifier: Apache-2.0
// A component with nodes beside itself: one that its constructor makes, and others on order.
#include <map>
#include <std_msgs/msg/string.hpp>
#include <std_srvs/srv/set_bool.hpp>

#include "nacelle/node/component.hpp"

namespace nacelle::test {

using std_msgs::msg::String;
using std_srvs::srv::SetBool;

/// Answers "NAME: TEXT" on ~/out to each text on ~/in.
class Twin final : public Node {
 public:
  Twin(const std::string& name, const NodeOptions& options) : Node(name, options) {
    declare_parameter<std::string>("greeting", "hello");
    out_ = create_publisher<String>("~/out", QoS(100).transient_local());
    in_ = create_subscription<String>("~/in", QoS(100).transient_local(), [this](const String& text) {
      if (text.data == "throw") throw std::runtime_error("a twin does not like that word");
      auto answer = out_->borrow();
      answer->data = get_parameter("greeting").as_string() + " " + std::string(text.data);
      out_->publish(std::move(answer));
    });
    service_ = create_service<SetBool>("~/ask", [this](const SetBool::Request&, SetBool::Response& response) {
      response.message = get_fully_qualified_name();
    });
  }

 private:
  Publisher<String>::SharedPtr out_;
  Subscription<String>::SharedPtr in_;
  Service<SetBool>::SharedPtr service_;
};

class Twins final : public LifecycleNode {
 public:
  explicit Twins(const NodeOptions& options)
      : LifecycleNode("twins", options), options_(options.another_node()), first_("twin", options_) {
    if (declare_parameter<bool>("fails", false)) throw std::runtime_error("its parameter says so");
    done_ = create_publisher<String>("done", QoS(100).transient_local());
    orders_ = create_subscription<String>("orders", QoS(100).transient_local(),
                                          [this](const String& order) { obey(std::string(order.data)); });
  }

 private:
  // "make NAME", "destroy NAME", "keep NAME": for longer than the component lives, "let go".
  void obey(const std::string& order) {
    static std::map<std::string, std::unique_ptr<Twin>> kept;
    const auto space = order.find(' ');
    const std::string verb = order.substr(0, space), name = space == std::string::npos ? "" : order.substr(space + 1);
    std::string answer = order;
    try {
      if (verb == "make") made_[name] = std::make_unique<Twin>(name, options_);
      if (verb == "destroy") made_.erase(name);
      if (verb == "keep") kept[name] = std::make_unique<Twin>(name, options_);
      if (verb == "let") kept.clear();
    } catch (const std::exception& e) { answer = e.what(); }
    auto done = done_->borrow();
    done->data = answer;
    done_->publish(std::move(done));
  }

  const NodeOptions options_;
  Twin first_;
  std::map<std::string, std::unique_ptr<Twin>> made_;
  Publisher<String>::SharedPtr done_;
  Subscription<String>::SharedPtr orders_;
};

}  // namespace nacelle::test

NACELLE_REGISTER_COMPONENT(nacelle::test::Twins)
