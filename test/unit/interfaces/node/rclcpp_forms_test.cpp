// SPDX-License-Identifier: Apache-2.0
// Code as it is written for rclcpp: what of it means the same here.
#include <gtest/gtest.h>

#include <example_interfaces/srv/add_two_ints.hpp>
#include <functional>

#include "nacelle/node/node.hpp"
#include "support/recording_host.hpp"

namespace nacelle {
namespace {

using example_interfaces::srv::AddTwoInts;

class Adder : public Node {
 public:
  explicit Adder(const NodeOptions& options) : Node("adder", options) {
    using namespace std::placeholders;
    service_ = create_service<AddTwoInts>("add", std::bind(&Adder::add, this, _1, _2));
  }
  void add(const std::shared_ptr<AddTwoInts::Request> request, std::shared_ptr<AddTwoInts::Response> response) {
    response->sum = request->a + request->b;
  }

 private:
  Service<AddTwoInts>::SharedPtr service_;
};

TEST(RclcppForms, a_service_takes_its_request_and_response_as_shared_pointers) {
  test::RecordingContext context;
  const Adder adder{NodeOptions{context}};
  AddTwoInts::Request request;
  request.a = 2;
  request.b = 3;
  AddTwoInts::Response response;
  ASSERT_TRUE(context.call<AddTwoInts>("/add", request, response));
  EXPECT_EQ(response.sum, 5);
}

struct RclcppFormsOfANode : ::testing::Test {
  test::RecordingContext context;
  Node node{"node", NodeOptions{context}};
};

TEST_F(RclcppFormsOfANode, are_read_into_variables) {
  node.declare_parameter("rate", 20);
  int rate = 0;
  EXPECT_TRUE(node.get_parameter("rate", rate));
  EXPECT_EQ(rate, 20);
  double speed = 0.5;
  EXPECT_FALSE(node.get_parameter("speed", speed));
  EXPECT_EQ(speed, 0.5) << "untouched";
  EXPECT_THROW(node.get_parameter("rate", speed), exceptions::InvalidParameterTypeException);
}

TEST_F(RclcppFormsOfANode, are_read_with_an_alternative) {
  node.declare_parameter("rate", 20);
  EXPECT_EQ(node.get_parameter_or("rate", 5), 20);
  EXPECT_EQ(node.get_parameter_or("speed", 0.5), 0.5);
  double speed = 0;
  EXPECT_FALSE(node.get_parameter_or("speed", speed, 0.25));
  EXPECT_EQ(speed, 0.25);
}

TEST_F(RclcppFormsOfANode, are_listed_by_prefix_and_depth) {
  for (const char* name : {"a", "b.c", "b.d.e"}) node.declare_parameter(name, 1);
  const auto all = node.list_parameters({}, 0);
  EXPECT_EQ(all.names, (std::vector<std::string>{"a", "b.c", "b.d.e", "use_sim_time"}));
  EXPECT_EQ(all.prefixes, (std::vector<std::string>{"b", "b.d"}));
  EXPECT_EQ(node.list_parameters({}, 1).names, (std::vector<std::string>{"a", "use_sim_time"}));
  EXPECT_EQ(node.list_parameters({"b"}, 1).names, (std::vector<std::string>{"b.c"}));
}

TEST_F(RclcppFormsOfANode, the_clock_of_a_node_is_the_clock_of_stamps) {
  EXPECT_EQ(node.get_clock()->now(), node.now());
  context.clock().step_wall(1h);
  EXPECT_EQ(node.get_clock()->now(), node.now());
  EXPECT_NE(node.now().since_origin, node.steady_clock().now().since_origin);
}

TEST_F(RclcppFormsOfANode, waiting_for_a_service_ends_when_the_time_is_up) {
  const auto client = node.create_client<AddTwoInts>("add");
  EXPECT_FALSE(client->wait_for_service(20ms));
}

}  // namespace
}  // namespace nacelle
