// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "nacelle/runtime/broker.hpp"
#include "nacelle/transport_local/link.hpp"

namespace nacelle::test {

/// Two brokers joined by links over a real socket in one process: writers are on one side, readers on the other.
///
/// No thread waits: after each call both links are pumped until nothing moves, so that the suites of test/conformance
/// see the same sequence of events each time. Threads: as Transport.
class LinkedBrokers : public Transport {
 public:
  /// `carrier`: of both links; must outlive this.
  explicit LinkedBrokers(const Clock& clock, Carrier* carrier = nullptr);
  ~LinkedBrokers() override;
  [[nodiscard]] std::unique_ptr<Writer> create_writer(const EndpointSpec& spec) override;
  [[nodiscard]] std::unique_ptr<Reader> create_reader(const EndpointSpec& spec, Taking taking,
                                                      ReadyListener* listener) override;
  MonotonicTime watch(MonotonicTime now) override;

  void settle() const;
  [[nodiscard]] runtime::Broker& writers() { return writers_; }
  [[nodiscard]] runtime::Broker& readers() { return readers_; }
  [[nodiscard]] Link& writers_link() { return *writers_link_; }
  [[nodiscard]] Link& readers_link() { return *readers_link_; }

 private:
  runtime::Broker writers_, readers_;
  std::unique_ptr<Link> writers_link_, readers_link_;
};

/// A connected pair of stream sockets.
struct SocketPair {
  SocketPair();
  int one = -1, two = -1;
};

/// Knows std_msgs' String and Header.
[[nodiscard]] const msgs::MessageType* find_test_type(const std::string& name);

}  // namespace nacelle::test
