// SPDX-License-Identifier: Apache-2.0
#include "transport_dds/port/this_machine.hpp"

#include <arpa/inet.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <net/if.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cstring>
#include <filesystem>
#include <set>

#include "support/dds.hpp"
#include "support/own_network.hpp"
#include "transport_dds/port/core.hpp"
#include "transport_dds/port/cyclone.hpp"

namespace nacelle::transport_dds {
namespace {

using ::testing::HasSubstr;

constexpr std::uint32_t kOurs = 0x0A090901, kForeign = 0x0A090902;  // 10.9.9.1, 10.9.9.2

/// A UDP socket that is bound to an address (in the host's order) and a port; 0: any.
class Udp {
 public:
  explicit Udp(std::uint32_t address, std::uint16_t port = 0)
      : socket_(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0)) {
    const sockaddr_in to = at(address, port);
    EXPECT_EQ(::bind(socket_, reinterpret_cast<const sockaddr*>(&to), sizeof to), 0) << std::strerror(errno);
  }
  Udp(const Udp&) = delete;
  Udp& operator=(const Udp&) = delete;
  ~Udp() { ::close(socket_); }

  [[nodiscard]] int get() const { return socket_; }
  [[nodiscard]] std::uint16_t port() const {
    sockaddr_in bound{};
    socklen_t size = sizeof bound;
    ::getsockname(socket_, reinterpret_cast<sockaddr*>(&bound), &size);
    return ntohs(bound.sin_port);
  }
  void send(char byte, std::uint32_t address, std::uint16_t port) const {
    const sockaddr_in to = at(address, port);
    EXPECT_EQ(::sendto(socket_, &byte, 1, 0, reinterpret_cast<const sockaddr*>(&to), sizeof to), 1)
        << std::strerror(errno);
  }
  /// The next byte, of those that wait; 0 if none does. On lo a datagram is there when sendto() returns.
  [[nodiscard]] char hear() const {
    char byte = 0;
    return ::recv(socket_, &byte, 1, MSG_DONTWAIT) == 1 ? byte : '\0';
  }

 private:
  static sockaddr_in at(std::uint32_t address, std::uint16_t port) {
    sockaddr_in out{};
    out.sin_family = AF_INET;
    out.sin_addr.s_addr = htonl(address);
    out.sin_port = htons(port);
    return out;
  }
  int socket_;
};

/// Receives the announcements of a domain on lo.
class Announced {
 public:
  explicit Announced(std::uint32_t domain) : socket_(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0)) {
    const int yes = 1;
    ::setsockopt(socket_, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
    sockaddr_in to{};
    to.sin_family = AF_INET;
    to.sin_port = htons(static_cast<std::uint16_t>(7400 + 250 * domain));  // DDSI-RTPS 2.5, 9.6.2.3
    ip_mreqn group{};
    group.imr_multiaddr.s_addr = to.sin_addr.s_addr = ::inet_addr("239.255.0.1");
    group.imr_ifindex = static_cast<int>(::if_nametoindex("lo"));
    const timeval limit{10, 0};
    EXPECT_EQ(::setsockopt(socket_, SOL_SOCKET, SO_RCVTIMEO, &limit, sizeof limit), 0);
    EXPECT_EQ(::bind(socket_, reinterpret_cast<const sockaddr*>(&to), sizeof to), 0) << std::strerror(errno);
    EXPECT_EQ(::setsockopt(socket_, IPPROTO_IP, IP_ADD_MEMBERSHIP, &group, sizeof group), 0) << std::strerror(errno);
  }
  Announced(const Announced&) = delete;
  Announced& operator=(const Announced&) = delete;
  ~Announced() { ::close(socket_); }

  /// Returns the sender of the next datagram: the GUID's prefix. Empty: none for ten seconds.
  [[nodiscard]] std::string next() const {
    std::array<char, 20> header{};  // "RTPS", version, vendor, prefix
    const auto size = ::recv(socket_, header.data(), header.size(), MSG_TRUNC);
    return size < static_cast<ssize_t>(header.size()) ? std::string() : std::string(header.data() + 8, 12);
  }

 private:
  int socket_;
};

int option_of(int socket, int level, int name) {
  int value = -1;
  socklen_t size = sizeof value;
  return ::getsockopt(socket, level, name, &value, &size) == 0 ? value : -1;
}

/// The UDP sockets of this process.
std::set<int> udp_sockets() {
  std::set<int> found;
  for (const auto& entry : std::filesystem::directory_iterator("/proc/self/fd")) {
    const int fd = std::stoi(entry.path().filename());
    if (option_of(fd, SOL_SOCKET, SO_DOMAIN) == AF_INET && option_of(fd, SOL_SOCKET, SO_TYPE) == SOCK_DGRAM)
      found.insert(fd);
  }
  return found;
}

/// Instructions of its filter; 0 without one.
int filter_of(int socket) {
  socklen_t count = 0;
  return ::getsockopt(socket, SOL_SOCKET, SO_GET_FILTER, nullptr, &count) == 0 ? static_cast<int>(count) : -1;
}

TEST(ThisMachine, is_127_and_its_own_addresses) {
  if (!test::add_to_loopback("10.9.9.1") || !test::add_to_loopback("10.9.9.2")) GTEST_SKIP() << "no own network";
  const Udp kept(INADDR_ANY), from_home(INADDR_LOOPBACK), from_elsewhere_in_127(0x7F010203), from_ours(kOurs),
      from_foreign(kForeign);
  const auto done = keep_to_this_machine(kept.get(), {kOurs});
  ASSERT_TRUE(done) << done.error().text();
  from_foreign.send('f', INADDR_LOOPBACK, kept.port());
  from_home.send('h', INADDR_LOOPBACK, kept.port());
  from_elsewhere_in_127.send('e', INADDR_LOOPBACK, kept.port());
  from_ours.send('o', kOurs, kept.port());
  EXPECT_EQ(kept.hear(), 'h');
  EXPECT_EQ(kept.hear(), 'e');
  EXPECT_EQ(kept.hear(), 'o');
  EXPECT_EQ(kept.hear(), '\0') << "the foreign one was dropped";
}

TEST(ThisMachine, may_have_many_addresses_and_get_others) {
  if (!test::add_to_loopback("10.9.9.1") || !test::add_to_loopback("10.9.9.2")) GTEST_SKIP() << "no own network";
  const Udp kept(INADDR_ANY), from_ours(kOurs), from_foreign(kForeign);
  std::vector<std::uint32_t> own;
  for (std::uint32_t i = 0; i < 300; ++i) own.push_back(0xC0A80000 + i);
  own.push_back(kOurs);
  ASSERT_TRUE(keep_to_this_machine(kept.get(), own));
  from_ours.send('o', kOurs, kept.port());
  EXPECT_EQ(kept.hear(), 'o');
  ASSERT_TRUE(keep_to_this_machine(kept.get(), {kForeign}));
  from_ours.send('o', kOurs, kept.port());
  from_foreign.send('f', kForeign, kept.port());
  EXPECT_EQ(kept.hear(), 'f') << "the filter is a new one, not one more";
  EXPECT_EQ(kept.hear(), '\0');
}

TEST(ThisMachine, says_what_the_kernel_refuses) {
  const auto done = keep_to_this_machine(-1, {});
  ASSERT_FALSE(done);
  EXPECT_THAT(done.error().text(), HasSubstr("Bad file descriptor"));
}

TEST(ThisMachine, reports_packets_from_before_its_restriction) {
  const std::string config = test::loopback_config(test::test_domain());
  {
    const Entity domain{dds_create_domain(96, config.c_str())};
    EXPECT_EQ(keep_domain_to_this_machine(domain.get(), 96).value(), Home::Alone);
  }
  const auto other = test::make_participant();
  const Entity domain{dds_create_domain(96, config.c_str())};
  test::Told told;
  const CycloneListener listener{dds_create_listener(&told)};
  dds_lset_data_available(listener.get(), [](dds_entity_t, void* to) { static_cast<test::Told*>(to)->on_data(); });
  {
    const Entity participant{dds_create_participant(96, nullptr, nullptr)};
    const Entity known{
        dds_create_reader(participant.get(), DDS_BUILTIN_TOPIC_DCPSPARTICIPANT, nullptr, listener.get())};
    ASSERT_TRUE(told.until([&] {
      std::array<void*, 2> samples{};
      std::array<dds_sample_info_t, 2> infos{};
      const dds_return_t count = dds_read(known.get(), samples.data(), infos.data(), 2, 2);
      if (count > 0) dds_return_loan(known.get(), samples.data(), count);
      return count == 2;
    })) << "itself, and the other one";
  }
  EXPECT_EQ(keep_domain_to_this_machine(domain.get(), 96).value(), Home::Visited);
}

TEST(ThisMachine, hears_nothing_of_how_a_domain_was_kept) {
  const std::uint32_t number = test::test_domain();
  const std::string config = test::loopback_config(number);
  const Announced announced{number};
  // Depending on threads, the farewell of the previous participant may still be unsent.
  std::string last;
  for (int i = 0; i < 50; ++i) {
    const Entity domain{dds_create_domain(97, config.c_str())};
    ASSERT_EQ(keep_domain_to_this_machine(domain.get(), 97).value(), Home::Alone);
    const Entity participant{dds_create_participant(97, nullptr, nullptr)};
    const Gid gid = gid_of(participant.get());
    const std::string its_prefix(gid.bytes.begin(), gid.bytes.begin() + 12);
    std::string speaker = announced.next();
    while (speaker == last) speaker = announced.next();
    ASSERT_EQ(speaker, its_prefix) << "in round " << i;
    last = its_prefix;
  }
}

TEST(Participant, stays_on_this_machine_with_all_its_sockets) {
  const auto before = udp_sockets();
  const auto participant = test::make_participant({.stays_on_this_machine = true});
  std::set<int> its = udp_sockets();
  for (const int other : before) its.erase(other);
  ASSERT_GE(its.size(), 3U) << "to send, and to receive by multicast and unicast";
  const auto lo = static_cast<int>(htonl(::if_nametoindex("lo")));
  for (const int socket : its) {
    EXPECT_EQ(option_of(socket, IPPROTO_IP, IP_MULTICAST_TTL), 0);
    EXPECT_EQ(option_of(socket, IPPROTO_IP, IP_UNICAST_IF), lo);
    EXPECT_EQ(option_of(socket, IPPROTO_IP, IP_MULTICAST_IF), static_cast<int>(htonl(INADDR_LOOPBACK)));
    EXPECT_GT(filter_of(socket), 3);
  }
  const auto free = test::make_participant();
  std::set<int> others = udp_sockets();
  for (const int known : its) others.erase(known);
  for (const int known : before) others.erase(known);
  for (const int socket : others) EXPECT_EQ(filter_of(socket), 0);
}

TEST(Participant, that_stays_on_this_machine_meets_others_there) {
  test::Told told;
  const auto one = test::make_participant({.stays_on_this_machine = true}), other = test::make_participant(),
             third = test::make_participant({.stays_on_this_machine = true});
  const auto writer = one->create_writer(test::string_topic("at_home"), &told).value();
  const auto reader = other->create_reader(test::string_topic("at_home"), &told).value(),
             second = third->create_reader(test::string_topic("at_home"), &told).value();
  ASSERT_TRUE(told.until(
      [&] { return writer->matched_count() == 2 && reader->matched_count() == 1 && second->matched_count() == 1; }));
  test::say(*writer, "hello");
  ASSERT_TRUE(told.until([&] { return reader->has_waiting() && second->has_waiting(); }));
  EXPECT_EQ(test::hear(*reader), "hello");
  EXPECT_EQ(test::hear(*second), "hello");
}

TEST(Participant, cannot_stay_on_this_machine_with_sockets_that_come_later) {
  const auto made =
      Participant::create({.domain_id = 95,
                           .config = test::loopback_config(test::test_domain()) +
                                     "<Compatibility><ManySocketsMode>many</ManySocketsMode></Compatibility>",
                           .stays_on_this_machine = true});
  ASSERT_FALSE(made);
  EXPECT_THAT(made.error().text(), HasSubstr("cannot be kept to this machine"));
}

}  // namespace
}  // namespace nacelle::transport_dds
