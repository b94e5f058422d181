// SPDX-License-Identifier: Apache-2.0
#include "support/dds.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <atomic>
#include <std_msgs/msg/string.hpp>

#include "nacelle/base/bytes.hpp"
#include "nacelle/msgs/message_type.hpp"
#include "support/own_network.hpp"

namespace nacelle::test {
namespace {

class OwnNetwork final : public ::testing::Environment {
 public:
  void SetUp() override { static_cast<void>(enter_own_network()); }
};
[[maybe_unused]] const auto* const kOwnNetwork = ::testing::AddGlobalTestEnvironment(new OwnNetwork);

std::string config_of(std::uint32_t domain, const std::string& interface, const std::string& sizes) {
  return "<General><Interfaces><NetworkInterface name=\"" + interface + "\" multicast=\"true\"/></Interfaces>" + sizes +
         "</General><Discovery><ExternalDomainId>" + std::to_string(domain) + "</ExternalDomainId></Discovery>";
}

}  // namespace

// Domains above 232 have no ports.
std::uint32_t test_domain() { return 100 + static_cast<std::uint32_t>(::getpid()) % 100; }

std::string loopback_config(std::uint32_t domain) {
  return config_of(domain, "lo", "<MaxMessageSize>65500B</MaxMessageSize><FragmentSize>65000B</FragmentSize>");
}

std::string lan_config(std::uint32_t domain, const std::string& interface) {
  return config_of(domain, interface, "<MaxMessageSize>1452B</MaxMessageSize>");
}

std::unique_ptr<transport_dds::Participant> make_participant(const transport_dds::ParticipantOptions& more) {
  static std::atomic<std::uint32_t> next{0};
  transport_dds::ParticipantOptions options = more;
  options.domain_id = next++;
  if (options.config.empty()) options.config = loopback_config(test_domain());
  auto made = transport_dds::Participant::create(options);
  if (!made) {
    ADD_FAILURE() << made.error().text();
    std::abort();
  }
  return std::move(*made);
}

transport_dds::EndpointOptions string_topic(const std::string& topic, const QoS& qos) {
  const msgs::MessageType& type = std_msgs::msg::String::message_type();
  const std::string user_data = std::string("typehash=") + type.hash + ";";
  const ByteView bytes = as_bytes(user_data);
  return {"rt/" + topic, type.dds_name, type.hash, transport_dds::to_dds(qos), Bytes(bytes.begin(), bytes.end())};
}

void Told::note() noexcept {
  const std::lock_guard lock(mutex_);
  ++calls_;
  condition_.notify_all();
}

bool Told::until(const std::function<bool()>& holds, Duration limit) {
  const auto end = std::chrono::steady_clock::now() + limit;
  for (;;) {
    std::unique_lock lock(mutex_);
    const std::uint64_t seen = calls_;
    lock.unlock();
    if (holds()) return true;
    lock.lock();
    if (!condition_.wait_until(lock, end, [&] { return calls_ != seen; })) return false;
  }
}

transport_dds::Writer::Sent say(transport_dds::Writer& writer, const std::string& text, WallTime source_time) {
  std_msgs::msg::String message;
  message.data = text;
  const msgs::MessageType& type = std_msgs::msg::String::message_type();
  auto payload = writer.borrow(type.encoded_size(&message));
  if (!payload) return transport_dds::Writer::Sent::Refused;
  type.encode(&message, payload.bytes().data());
  if (source_time == WallTime{}) source_time = SystemClock{}.wall_now();
  return writer.write(std::move(payload), source_time);
}

transport_dds::Writer::Sent say_bytes(transport_dds::Writer& writer, ByteView bytes) {
  auto payload = writer.borrow(bytes.size());
  if (!payload) return transport_dds::Writer::Sent::Refused;
  std::copy(bytes.begin(), bytes.end(), payload.bytes().begin());
  return writer.write(std::move(payload), SystemClock{}.wall_now());
}

std::string hear(transport_dds::Reader& reader) {
  const auto sample = reader.take();
  if (!sample) return "nothing";
  std_msgs::msg::String message;
  if (!std_msgs::msg::String::message_type().decode(sample->payload.bytes(), &message)) return "broken";
  return message.data;
}

}  // namespace nacelle::test
