// SPDX-License-Identifier: Apache-2.0
// Calls the container's own services: "load CLASS NAME", "badly CLASS NAME", "unload ID", "list".
#include <composition_interfaces/srv/list_nodes.hpp>
#include <composition_interfaces/srv/load_node.hpp>
#include <composition_interfaces/srv/unload_node.hpp>
#include <sstream>
#include <std_msgs/msg/string.hpp>

#include "nacelle/node/component.hpp"

namespace nacelle::test {

using composition_interfaces::srv::ListNodes;
using composition_interfaces::srv::LoadNode;
using composition_interfaces::srv::UnloadNode;

class Caller final : public Node {
 public:
  explicit Caller(const NodeOptions& options) : Node("caller", options) {
    answers_ = create_publisher<std_msgs::msg::String>("answers", QoS(100).transient_local());
    load_ = create_client<LoadNode>("/test/_container/load_node");
    unload_ = create_client<UnloadNode>("/test/_container/unload_node");
    list_ = create_client<ListNodes>("/test/_container/list_nodes");
    calls_ = create_subscription<std_msgs::msg::String>("calls", QoS(100).transient_local(),
                                                        [this](const std_msgs::msg::String& call) { run(call.data); });
  }

 private:
  void run(const std::string& call) {
    std::istringstream words(call);
    std::string verb;
    words >> verb;
    bool sent = false;
    if (verb == "list") {
      sent = list_->async_send_request({}, [this](const ListNodes::Response* response) {
        std::string text;
        for (std::size_t i = 0; i < response->unique_ids.size(); ++i)
          text += (i == 0 ? "" : " ") + std::to_string(response->unique_ids[i]) + response->full_node_names[i];
        say(text);
      });
    } else if (verb == "unload") {
      UnloadNode::Request request;
      words >> request.unique_id;
      sent = unload_->async_send_request(request, [this](const UnloadNode::Response* response) {
        say(response->success ? "unloaded" : response->error_message);
      });
    } else {
      LoadNode::Request request;
      request.package_name = "any_package";
      words >> request.plugin_name >> request.node_name;
      request.node_namespace = "/robot1";
      request.remap_rules.push_back("words:=speech");
      request.parameters.emplace_back();
      request.parameters.back().name = "word";
      request.parameters.back().value.type = 4;  // ParameterType.PARAMETER_STRING
      request.parameters.back().value.string_value = "ahoy";
      request.extra_arguments.emplace_back();
      request.extra_arguments.back().name = "use_intra_process_comms";
      request.extra_arguments.back().value.type = verb == "badly" ? 4 : 1;
      sent = load_->async_send_request(request, [this](const LoadNode::Response* response) {
        say(response->success ? std::to_string(response->unique_id) + " " + response->full_node_name
                              : response->error_message);
      });
    }
    if (!sent) say("no such service");
  }
  void say(const std::string& text) {
    auto message = answers_->borrow();
    message->data = text;
    answers_->publish(std::move(message));
  }
  Publisher<std_msgs::msg::String>::SharedPtr answers_;
  Subscription<std_msgs::msg::String>::SharedPtr calls_;
  Client<LoadNode>::SharedPtr load_;
  Client<UnloadNode>::SharedPtr unload_;
  Client<ListNodes>::SharedPtr list_;
};

}  // namespace nacelle::test

NACELLE_REGISTER_COMPONENT(nacelle::test::Caller)
