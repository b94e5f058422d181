// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <string>

#include "transport_dds/port/discovery.hpp"
#include "transport_dds/port/endpoint.hpp"
#include "transport_dds/port/participant.hpp"
#include "transport_dds/port/reader.hpp"
#include "transport_dds/port/writer.hpp"

namespace nacelle::test {

/// A domain that no other test process on this machine uses while it is not alone in its network.
[[nodiscard]] std::uint32_t test_domain();

/// Cyclone's XML: the loopback interface only. Several participants of one process meet on the network in `domain`,
/// since Cyclone knows them by another number in the process.
[[nodiscard]] std::string loopback_config(std::uint32_t domain);

/// The same on another interface, with datagrams that fit a frame of Ethernet.
[[nodiscard]] std::string lan_config(std::uint32_t domain, const std::string& interface);

/// A participant in test_domain(), on the loopback interface if `more` has no configuration. Fails the test if there is none to
/// be had.
[[nodiscard]] std::unique_ptr<transport_dds::Participant> make_participant(
    const transport_dds::ParticipantOptions& more = {});

/// Options of a ROS 2 topic "rt/..." of std_msgs/String.
[[nodiscard]] transport_dds::EndpointOptions string_topic(const std::string& topic, const QoS& qos = QoS(10));

/// Lets a test wait for notifications of listeners. Threads: any.
class Told final : public transport_dds::EndpointListener, public transport_dds::DiscoveryListener {
 public:
  void on_status() noexcept override { note(); }
  void on_data() noexcept override { note(); }
  void on_discovery() noexcept override { note(); }
  /// True once `holds` does; asked anew after each call of a listener. False after `limit`.
  [[nodiscard]] bool until(const std::function<bool()>& holds, Duration limit = 60s);

 private:
  void note() noexcept;
  std::mutex mutex_;
  std::condition_variable condition_;
  std::uint64_t calls_ = 0;
};

/// Sends a std_msgs/String.
transport_dds::Writer::Sent say(transport_dds::Writer& writer, const std::string& text, WallTime source_time = {});
/// Sends bytes as they are.
transport_dds::Writer::Sent say_bytes(transport_dds::Writer& writer, ByteView bytes);
/// The text of the next message; "nothing" if none waits, "broken" if it is no std_msgs/String.
[[nodiscard]] std::string hear(transport_dds::Reader& reader);

}  // namespace nacelle::test
