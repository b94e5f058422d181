// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <bit>
#include <functional>
#include <future>
#include <map>
#include <memory>
#include <string>

#include "benchmark/support/recipe.hpp"
#include "mirrored.hpp"
#include "nacelle/runtime/container.hpp"
#include "support/places.hpp"
#include "transport_dds/wire/service_call.hpp"
#include "transport_dds/wire/user_data.hpp"

namespace nacelle::test {

/// A container with its mirror: one of several on a network.
class MirroredContainer {
 public:
  /// `refused`: as MirrorOptions::refused. `network_clock`: the mirror's, if it is not the container's.
  using Refused = decltype(MirrorOptions::refused);
  explicit MirroredContainer(const std::string& name, Refused refused = {}, const Clock* network_clock = nullptr)
      : container_(with_plugins(name), clock) {
    static std::uint32_t next = 0;  // in this process; on the network they share test_domain()
    MirrorOptions options;
    options.domain_id = 2000000 + next++;
    options.config = loopback_config(test_domain());
    options.refused = std::move(refused);
    options.on_problem = [this](const Problem& problem) {
      problems.lock()->push_back(problem.text());
      bell.ring();
    };
    auto made = DdsMirror::start(container_.graph(), network_clock != nullptr ? *network_clock : clock, options,
                                 &container_.service_graph());
    if (!made) ADD_FAILURE() << name << ": " << made.error().text();
    if (made) mirror = std::move(*made);
  }

  /// Loads and configures a component that consists of `recipe`, which outlives this object.
  std::uint64_t load(bench::Recipe& recipe, const std::string& name, bool active = true) {
    runtime::LoadRequest request;
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
  [[nodiscard]] runtime::Container& container() { return container_; }
  [[nodiscard]] MirrorStats stats() const { return mirror->stats(); }

  const SystemClock clock;
  Bell bell;
  Guarded<Texts> problems;

 private:
  static runtime::ContainerOptions with_plugins(const std::string& name) {
    runtime::ContainerOptions options;
    options.name = name;
    options.component_path = {test::component_folder()};
    return options;
  }
  runtime::Container container_;

 public:
  std::unique_ptr<DdsMirror> mirror;
};

/// Offers a service that answers in place.
template <typename S>
class Offering final : public bench::Recipe {
 public:
  using Answer = std::function<void(const typename S::Request&, typename S::Response&)>;
  Offering(std::string name, Answer answer) : name_(std::move(name)), answer_(std::move(answer)) {}
  std::shared_ptr<void> build(LifecycleNode& node) override {
    return node.create_service<S>(name_, [this](const typename S::Request& request, typename S::Response& response) {
      ++asked;
      answer_(request, response);
    });
  }
  std::atomic<int> asked{0};

 private:
  const std::string name_;
  const Answer answer_;
};

/// Offers a service that answers when the test does.
template <typename S>
class Pondering final : public bench::Recipe {
 public:
  explicit Pondering(std::string name) : name_(std::move(name)) {}
  std::shared_ptr<void> build(LifecycleNode& node) override {
    auto made = node.create_service<S>(
        name_, [this](const RequestId& id, const typename S::Request&) { asked_.lock()->push_back(id); });
    service = made.get();
    return made;
  }
  [[nodiscard]] std::vector<RequestId> asked() const { return *asked_.lock(); }
  Service<S>* service = nullptr;

 private:
  const std::string name_;
  Guarded<std::vector<RequestId>> asked_;
};

/// Calls a service.
template <typename S>
class Calling final : public bench::Recipe {
 public:
  explicit Calling(std::string name) : name_(std::move(name)) {}
  std::shared_ptr<void> build(LifecycleNode& node) override {
    auto made = node.create_client<S>(name_);
    client = made.get();
    return made;
  }
  using Future = typename Client<S>::Future;
  using Answer = typename Client<S>::SharedResponse;
  /// The response; null if there is none, or no server.
  [[nodiscard]] Answer call(typename S::Request request) {
    return answer_to(client->async_send_request(std::move(request)));
  }
  [[nodiscard]] static Answer answer_to(Future future) {
    if (!future.valid()) return nullptr;
    EXPECT_EQ(future.wait_for(30s), std::future_status::ready);
    return future.wait_for(0s) == std::future_status::ready ? future.get() : nullptr;
  }
  Client<S>* client = nullptr;

 private:
  const std::string name_;
};

/// One end of a service by hand, as rmw_cyclonedds would make it: the two endpoints of a client or of a server.
class RawEnd {
 public:
  /// `id`, `type_hash`: as in the user data. Without: no id; the types' own hashes if there is an id, else none.
  RawEnd(transport_dds::Participant& participant, const msgs::MessageType& request, const msgs::MessageType& response,
         const std::string& service, bool is_server, std::string id = {}, std::optional<std::string> type_hash = {})
      : participant_(participant), id_(std::move(id)), type_hash_(std::move(type_hash)), is_server_(is_server) {
    const auto options = [&](bool is_request) {
      return options_for(service, is_request ? request : response, is_request);
    };
    reply_options = options(false);
    writer = participant.create_writer(options(!is_server), &told).value();
    if (is_server) reader = participant.create_reader(options(true), &told).value();
  }
  /// A client's second endpoint.
  void make_reply_reader() { reader = participant_.create_reader(reply_options, &told).value(); }
  [[nodiscard]] bool matched() {
    return told.until([&] { return writer->matched_count() != 0 && (!reader || reader->matched_count() != 0); });
  }
  [[nodiscard]] Bytes next() {
    std::optional<transport_dds::Sample> sample;
    if (!told.until([&] { return (sample = reader->take()).has_value(); })) return {};
    const ByteView bytes = sample->payload.bytes();
    return {bytes.begin(), bytes.end()};
  }
  void say(ByteView bytes) { EXPECT_EQ(say_bytes(*writer, bytes), transport_dds::Writer::Sent::Yes); }
  template <typename Message>
  void say(const transport_dds::CallHeader& header, const Message& message) {
    const msgs::MessageType& type = Message::message_type();
    Bytes bytes(transport_dds::call_size(type, &message));
    transport_dds::write_call(header, type, &message, bytes.data());
    say(bytes);
  }

  Told told;  // outlives the endpoints
  transport_dds::EndpointOptions reply_options;
  std::unique_ptr<transport_dds::Writer> writer;
  std::unique_ptr<transport_dds::Reader> reader;

 private:
  [[nodiscard]] transport_dds::EndpointOptions options_for(const std::string& service, const msgs::MessageType& type,
                                                           bool is_request) const {
    transport_dds::EndpointUserData data;
    data.type_hash = type_hash_.value_or(id_.empty() ? "" : type.hash);
    (is_server_ ? data.service_id : data.client_id) = id_;
    const std::string text = transport_dds::write_endpoint_user_data(data);
    const ByteView bytes = as_bytes(text);
    return {is_request ? "rq" + service + "Request" : "rr" + service + "Reply", type.dds_name, type.hash,
            transport_dds::to_dds(QoS(1000)), Bytes(bytes.begin(), bytes.end())};
  }
  transport_dds::Participant& participant_;
  const std::string id_;
  const std::optional<std::string> type_hash_;
  const bool is_server_;
};

}  // namespace nacelle::test
