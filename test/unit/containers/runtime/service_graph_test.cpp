// SPDX-License-Identifier: Apache-2.0
// The reports about services to a link to other processes, and its operations on them.
#include "nacelle/host/service_graph.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <bit>
#include <condition_variable>
#include <example_interfaces/srv/add_two_ints.hpp>
#include <mutex>

#include "benchmark/support/recipe.hpp"
#include "nacelle/runtime/container.hpp"
#include "support/places.hpp"

namespace nacelle::runtime {
namespace {

using example_interfaces::srv::AddTwoInts;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::IsEmpty;
using Texts = std::vector<std::string>;

/// Records its notifications.
class Diary final : public ServiceListener {
 public:
  void on_made(const ServiceEndInfo& end) noexcept override {
    const std::lock_guard lock(mutex_);
    ids_[end.id] = end;
    notes_.push_back(std::string(end.is_server ? "server " : "client ") + end.name + " of " + end.node);
  }
  void on_gone(std::uint64_t id) noexcept override {
    const std::lock_guard lock(mutex_);
    notes_.push_back("gone " + ids_[id].name);
  }
  void on_ready(std::uint64_t id, bool ready) noexcept override {
    const std::lock_guard lock(mutex_);
    changes_.push_back(std::string(ids_[id].is_server ? "server " : "client ") + (ready ? "ready" : "not ready"));
  }
  /// Since the last time.
  Texts notes() {
    const std::lock_guard lock(mutex_);
    return std::exchange(notes_, {});
  }
  /// Returns the changes that on_ready() has reported since the last call.
  Texts changes() {
    const std::lock_guard lock(mutex_);
    return std::exchange(changes_, {});
  }
  ServiceEndInfo end(const std::string& name, bool is_server) {
    const std::lock_guard lock(mutex_);
    for (const auto& [id, end] : ids_) {
      if (end.name == name && end.is_server == is_server) return end;
    }
    return {};
  }

 private:
  std::mutex mutex_;
  std::map<std::uint64_t, ServiceEndInfo> ids_;
  Texts notes_, changes_;
};

/// A server of another process, whose answers the test gives.
class Elsewhere final : public RemoteServer {
 public:
  [[nodiscard]] bool take(Call call) noexcept override {
    if (is_full) return false;
    calls.push_back(std::move(call));
    return true;
  }
  std::vector<Call> calls;
  bool is_full = false;
};

/// The answer to a call of the test's own.
class Waiting final : public AnswerTaker {
 public:
  ~Waiting() override { *self->lock() = nullptr; }
  void push(std::int64_t sequence, std::unique_ptr<msgs::AnyMessage> response) override {
    const std::lock_guard lock(mutex_);
    const std::string text =
        response ? std::to_string(static_cast<const AddTwoInts::Response*>(response->get())->sum) : "none";
    answers_.push_back(std::to_string(sequence) + ": " + text);
    pushed_.notify_all();
  }
  Texts next(std::size_t count) {
    std::unique_lock lock(mutex_);
    pushed_.wait_for(lock, 20s, [&] { return answers_.size() >= count; });
    return answers_;
  }
  std::shared_ptr<Guarded<AnswerTaker*>> self =
      std::make_shared<Guarded<AnswerTaker*>>(std::in_place, static_cast<AnswerTaker*>(this));

 private:
  std::mutex mutex_;
  std::condition_variable pushed_;
  Texts answers_;
};

/// Offers and calls /add.
class Both final : public bench::Recipe {
 public:
  Both(bool offers, bool calls) : offers_(offers), calls_(calls) {}
  std::shared_ptr<void> build(LifecycleNode& node) override {
    using Ends = std::pair<std::shared_ptr<Service<AddTwoInts>>, std::shared_ptr<Client<AddTwoInts>>>;
    auto ends = std::make_shared<Ends>();
    if (offers_) {
      ends->first = node.create_service<AddTwoInts>(
          "/add", [](const AddTwoInts::Request& request, AddTwoInts::Response& response) {
            response.sum = request.a + request.b;
          });
    }
    if (calls_) ends->second = node.create_client<AddTwoInts>("/add");
    client = ends->second.get();
    return ends;
  }
  Client<AddTwoInts>* client = nullptr;

 private:
  const bool offers_, calls_;
};

class ServiceGraphTest : public ::testing::Test {
 public:
  static ContainerOptions with_plugins() {
    ContainerOptions options;
    options.name = "test";
    options.component_path = {test::component_folder()};
    return options;
  }
  std::uint64_t load(bench::Recipe& recipe, const std::string& name, bool active = true) {
    LoadRequest request;
    request.plugin = "nacelle::bench::Part";
    request.name = name;
    request.parameters = {{"recipe", static_cast<std::int64_t>(std::bit_cast<std::intptr_t>(&recipe))}};
    const auto loaded = container_.load(request);
    EXPECT_TRUE(loaded) << (loaded ? "" : loaded.error().text());
    if (!loaded) return 0;
    EXPECT_EQ(container_.trigger(loaded.value().id, Transition::Configure).reason, "");
    if (active) { EXPECT_EQ(container_.trigger(loaded.value().id, Transition::Activate).reason, ""); }
    return loaded.value().id;
  }
  static AddTwoInts::Request request_of(std::int64_t a, std::int64_t b) {
    AddTwoInts::Request request;
    request.a = a;
    request.b = b;
    return request;
  }
  static msgs::AnyMessage sum_of(std::int64_t sum) {
    msgs::AnyMessage made{AddTwoInts::Response::message_type()};
    static_cast<AddTwoInts::Response*>(made.get())->sum = sum;
    return made;
  }
  static Call call_of(const Waiting& asker, std::int64_t sequence, std::int64_t a, std::int64_t b) {
    Call call{{asker.self, sequence}, msgs::AnyMessage{AddTwoInts::Request::message_type()}};
    *static_cast<AddTwoInts::Request*>(call.request.get()) = request_of(a, b);
    return call;
  }

  SystemClock clock_;
  Both offering_{true, false}, calling_{false, true};  // outlive their components
  Container container_{with_plugins(), clock_};
  ServiceHub& graph_ = container_.service_graph();
  Diary diary_;
};

TEST_F(ServiceGraphTest, a_client_waits_until_a_server_is_there_or_the_time_is_up) {
  load(calling_, "caller");
  EXPECT_FALSE(calling_.client->wait_for_service(20ms));
  load(offering_, "adder");
  EXPECT_TRUE(calling_.client->wait_for_service(20s));
}

TEST_F(ServiceGraphTest, reports_present_new_and_removed_endpoints) {
  const auto id = load(offering_, "adder");
  graph_.join(diary_);
  const Texts at_first = diary_.notes();
  EXPECT_THAT(at_first, Contains("server /add of /adder"));
  EXPECT_THAT(at_first, Contains("server /test/_container/list_nodes of /test"));
  const ServiceEndInfo end = diary_.end("/add", true);
  EXPECT_EQ(end.request, &AddTwoInts::Request::message_type());
  EXPECT_EQ(end.response, &AddTwoInts::Response::message_type());

  const auto caller = load(calling_, "caller");
  EXPECT_THAT(diary_.notes(), ElementsAre("client /add of /caller"));
  EXPECT_EQ(diary_.end("/add", false).response, &AddTwoInts::Response::message_type());
  ASSERT_TRUE(container_.unload(id) && container_.unload(caller));
  EXPECT_THAT(diary_.notes(), ElementsAre("gone /add", "gone /add"));
  graph_.leave(diary_);
  ASSERT_TRUE(container_.unload(load(offering_, "adder")));
  EXPECT_THAT(diary_.notes(), IsEmpty());
}

TEST_F(ServiceGraphTest, hands_a_call_from_outside_to_one_server_if_it_is_open) {
  graph_.join(diary_);
  const auto id = load(offering_, "adder", false);
  const std::uint64_t server = diary_.end("/add", true).id;
  Waiting asker;
  EXPECT_EQ(graph_.send(server, call_of(asker, 1, 1, 2)), ServiceGraph::Sent::Closed);
  EXPECT_EQ(container_.trigger(id, Transition::Activate).reason, "");
  EXPECT_EQ(graph_.send(server, call_of(asker, 2, 3, 4)), ServiceGraph::Sent::Yes);
  EXPECT_THAT(asker.next(1), ElementsAre("2: 7"));
  ASSERT_TRUE(container_.unload(id));
  EXPECT_EQ(graph_.send(server, call_of(asker, 3, 5, 6)), ServiceGraph::Sent::Gone);
  graph_.leave(diary_);
}

TEST_F(ServiceGraphTest, sends_calls_elsewhere_only_without_an_open_server_here) {
  Elsewhere elsewhere;
  graph_.join(diary_);
  load(calling_, "caller");
  EXPECT_FALSE(calling_.client->service_is_ready());
  const std::uint64_t id = diary_.end("/add", false).id;
  graph_.set_remote(id, &elsewhere);
  EXPECT_TRUE(calling_.client->service_is_ready());
  EXPECT_FALSE(container_.service_is_ready("/add")) << "of this process";
  auto pending = calling_.client->async_send_request(request_of(1, 2));
  ASSERT_EQ(elsewhere.calls.size(), 1U);
  EXPECT_EQ(*static_cast<const AddTwoInts::Request*>(elsewhere.calls[0].request.get()), request_of(1, 2));
  EXPECT_TRUE(elsewhere.calls[0].asker.answer(std::make_unique<msgs::AnyMessage>(sum_of(33))));
  ASSERT_EQ(pending.wait_for(20s), std::future_status::ready);
  EXPECT_EQ(pending.get()->sum, 33);

  auto lost = calling_.client->async_send_request(request_of(1, 2));
  EXPECT_TRUE(elsewhere.calls[1].asker.answer(nullptr));
  ASSERT_EQ(lost.wait_for(20s), std::future_status::ready);
  EXPECT_EQ(lost.get(), nullptr);

  elsewhere.is_full = true;
  EXPECT_FALSE(calling_.client->async_send_request(request_of(1, 2)).valid());

  const auto here = load(offering_, "adder");
  auto near = calling_.client->async_send_request(request_of(1, 2));
  ASSERT_EQ(near.wait_for(20s), std::future_status::ready);
  EXPECT_EQ(near.get()->sum, 3);
  EXPECT_EQ(elsewhere.calls.size(), 2U);
  ASSERT_TRUE(container_.unload(here));

  EXPECT_TRUE(calling_.client->service_is_ready());
  graph_.set_remote(id, nullptr);
  EXPECT_FALSE(calling_.client->service_is_ready());
  EXPECT_FALSE(calling_.client->async_send_request(request_of(1, 2)).valid());
  graph_.leave(diary_);
}

TEST_F(ServiceGraphTest, a_stand_in_client_learns_when_its_service_is_ready_and_calls_it) {
  const auto id = load(offering_, "adder", false);
  graph_.join(diary_);
  const ServiceEndInfo far{
      0, false, "/add", "/far", &AddTwoInts::Request::message_type(), &AddTwoInts::Response::message_type()};
  const std::uint64_t client = graph_.add_stand_in(far, nullptr);
  EXPECT_EQ(diary_.end("/add", false).node, "/far");
  Waiting asker;
  EXPECT_FALSE(graph_.call(client, call_of(asker, 1, 1, 2)));
  EXPECT_THAT(diary_.changes(), IsEmpty());

  EXPECT_EQ(container_.trigger(id, Transition::Activate).reason, "");
  EXPECT_THAT(diary_.changes(), ElementsAre("server ready", "client ready"));
  EXPECT_TRUE(graph_.call(client, call_of(asker, 2, 3, 4)));
  EXPECT_THAT(asker.next(1), ElementsAre("2: 7"));
  ASSERT_TRUE(container_.unload(id));
  EXPECT_THAT(diary_.changes(), ElementsAre("server not ready", "client not ready"));

  Elsewhere elsewhere;
  graph_.set_remote(client, &elsewhere);
  EXPECT_THAT(diary_.changes(), ElementsAre("client ready"));
  graph_.remove_stand_in(client);
  EXPECT_FALSE(graph_.call(client, call_of(asker, 3, 5, 6)));
  graph_.leave(diary_);
}

TEST_F(ServiceGraphTest, the_stand_in_of_a_server_is_called_as_any_server) {
  Elsewhere elsewhere;
  load(calling_, "caller");
  const ServiceEndInfo far{
      0, true, "/add", "/far", &AddTwoInts::Request::message_type(), &AddTwoInts::Response::message_type(), false};
  const std::uint64_t server = graph_.add_stand_in(far, &elsewhere);
  EXPECT_FALSE(calling_.client->service_is_ready());
  graph_.open_stand_in(server, true);
  EXPECT_TRUE(calling_.client->service_is_ready() && container_.service_is_ready("/add"));
  auto pending = calling_.client->async_send_request(request_of(1, 2));
  ASSERT_EQ(elsewhere.calls.size(), 1U);
  EXPECT_TRUE(elsewhere.calls[0].asker.answer(std::make_unique<msgs::AnyMessage>(sum_of(33))));
  ASSERT_EQ(pending.wait_for(20s), std::future_status::ready);
  EXPECT_EQ(pending.get()->sum, 33);

  Waiting asker;
  EXPECT_EQ(graph_.send(server, call_of(asker, 1, 1, 2)), ServiceGraph::Sent::Yes);
  elsewhere.is_full = true;
  EXPECT_EQ(graph_.send(server, call_of(asker, 2, 1, 2)), ServiceGraph::Sent::Full);
  EXPECT_FALSE(calling_.client->async_send_request(request_of(1, 2)).valid());
  graph_.remove_stand_in(server);
  EXPECT_FALSE(calling_.client->service_is_ready());
}

TEST_F(ServiceGraphTest, does_not_wait_for_removed_endpoints) {
  Elsewhere elsewhere;
  graph_.join(diary_);
  const auto caller = load(calling_, "caller");
  const std::uint64_t id = diary_.end("/add", false).id;
  graph_.set_remote(id, &elsewhere);
  ASSERT_TRUE(calling_.client->async_send_request(request_of(1, 2)).valid());
  ASSERT_TRUE(container_.unload(caller));
  EXPECT_FALSE(elsewhere.calls[0].asker.answer(std::make_unique<msgs::AnyMessage>(sum_of(3))));
  graph_.set_remote(id, &elsewhere);
  graph_.set_remote(id, nullptr);
  graph_.leave(diary_);
}

}  // namespace
}  // namespace nacelle::runtime
