// SPDX-License-Identifier: Apache-2.0
// A robot on the network beside an attacker: participants that announce anything and write anything, and datagrams
// that are anything. Meanwhile an honest laptop is served, and in the end no memory stays with what came.
//
// A few seconds each; NACELLE_HOSTILE_SECONDS sets how many. The seed is printed and can be given: NACELLE_HOSTILE_SEED.
#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <malloc.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cstdlib>
#include <example_interfaces/srv/add_two_ints.hpp>
#include <fstream>
#include <random>
#include <sstream>

#include "nacelle/base/bytes.hpp"
#include "unit/containers/transport_dds/mirrored_container.hpp"

namespace nacelle {
namespace {

using example_interfaces::srv::AddTwoInts;
using transport_dds::EndpointOptions;

long setting(const char* name, long otherwise) {
  const char* const text = std::getenv(name);
  return text != nullptr ? std::atol(text) : otherwise;
}

std::size_t resident_bytes() {
  ::malloc_trim(0);
  std::ifstream file("/proc/self/statm");
  std::size_t all = 0, resident = 0;
  file >> all >> resident;
  return resident * static_cast<std::size_t>(::sysconf(_SC_PAGESIZE));
}

/// Random choices of one seed.
class Dice {
 public:
  explicit Dice(unsigned seed) : random_(seed) {}
  [[nodiscard]] unsigned below(std::size_t n) { return static_cast<unsigned>(random_() % n); }
  template <typename T>
  [[nodiscard]] const T& one_of(const std::vector<T>& all) {
    return all[below(all.size())];
  }
  [[nodiscard]] Bytes bytes(std::size_t most) {
    Bytes out(below(most + 1));
    for (auto& byte : out) byte = static_cast<std::uint8_t>(random_());
    return out;
  }
  /// A few bytes other, sometimes shorter or longer, sometimes as it is.
  [[nodiscard]] Bytes spoilt(Bytes bytes) {
    const unsigned how = below(8);
    for (unsigned i = 0; i < how && !bytes.empty(); ++i) {
      const unsigned at = below(bytes.size());
      // The ends of ranges are where lengths and counts go wrong.
      bytes[at] = std::array<std::uint8_t, 4>{0, 0x7F, 0xFF, static_cast<std::uint8_t>(random_())}[below(4)];
    }
    if (how == 1) bytes.resize(below(bytes.size() + 1));
    if (how == 2) {
      const Bytes more = this->bytes(64);
      bytes.insert(bytes.end(), more.begin(), more.end());
    }
    return bytes;
  }
  [[nodiscard]] std::string spoilt_text(const std::string& text) {
    const Bytes bytes = spoilt({text.begin(), text.end()});
    std::string out(bytes.begin(), bytes.end());
    std::erase(out, '\0');  // DDS's names are texts of C
    return out;
  }

 private:
  std::mt19937 random_;
};

template <typename Message>
Bytes encoded(const Message& message) {
  const msgs::MessageType& type = Message::message_type();
  Bytes out(type.encoded_size(&message));
  type.encode(&message, out.data());
  return out;
}

/// What stands on the wire between honest ones, to be spoilt.
struct Model {
  std::string topic, type, structure, user_data;
  Bytes payload;
  QoS qos = QoS(10);
};

std::vector<Model> models() {
  const auto& text = test::String::message_type();
  const auto &request = AddTwoInts::Request::message_type(), &response = AddTwoInts::Response::message_type();
  const std::string id = "serviceid= 1.2.3.4.5.6.7.8.9.a.b.c.d.e.f.10;typehash=";
  Bytes call(36);
  call[1] = 1;
  transport_dds::Snapshot snapshot;
  snapshot.node_entities_info_seq.resize(2);
  snapshot.node_entities_info_seq[0].node_name = "robot";
  snapshot.node_entities_info_seq[1].node_namespace = "/evil";
  snapshot.node_entities_info_seq[1].writer_gid_seq.resize(3);
  test::String hello;
  hello.data = "a text";
  return {
      {"rt/chatter", text.dds_name, text.hash, std::string("typehash=") + text.hash + ";", encoded(hello)},
      {"rq/addRequest", request.dds_name, request.hash, id + request.hash + ";", call},
      {"rr/addReply", response.dds_name, response.hash, id + response.hash + ";", call},
      {"ros_discovery_info", snapshot.message_type().dds_name, snapshot.message_type().hash,
       std::string("typehash=") + snapshot.message_type().hash + ";", encoded(snapshot), QoS(10).transient_local()},
  };
}

/// A participant that announces and writes what the dice say, and goes again.
void be_a_hostile_participant(Dice& dice, const std::vector<Model>& all) {
  transport_dds::ParticipantOptions options;
  const std::string enclave = dice.spoilt_text("enclave=/;");
  options.user_data = dice.below(2) == 0 ? dice.bytes(300) : Bytes(enclave.begin(), enclave.end());
  const auto participant = test::make_participant(options);
  test::Told told;
  std::vector<std::unique_ptr<transport_dds::Writer>> writers;
  std::vector<std::unique_ptr<transport_dds::Reader>> readers;
  for (unsigned i = dice.below(12); i > 0; --i) {
    const Model& model = dice.one_of(all);
    // One thing at a time, so that most of it is believed.
    EndpointOptions end{model.topic, model.type, model.structure, transport_dds::to_dds(model.qos), {}};
    std::string user_data = model.user_data;
    const unsigned what = dice.below(8);
    switch (what) {
      case 0: end.topic = dice.spoilt_text(model.topic); break;
      case 1: end.type = dice.spoilt_text(model.type); break;
      case 2:
      case 3: user_data = dice.spoilt_text(model.user_data); break;
      case 4: end.qos = transport_dds::to_dds(QoS(1).transient_local()); break;
      default: break;
    }
    if (end.topic.empty() || end.type.empty()) continue;
    end.user_data.assign(user_data.begin(), user_data.end());
    if (dice.below(4) == 0) {
      if (auto reader = participant->create_reader(end, nullptr)) readers.push_back(std::move(*reader));
      continue;
    }
    auto writer = participant->create_writer(end, &told);
    if (!writer) continue;  // a name that Cyclone itself refuses
    // The robot reads it, if it is announced like a valid one: replies are read by none of its clients.
    const bool is_read = what >= 2 && model.topic != "rr/addReply";
    if (is_read) {
      EXPECT_TRUE(told.until([&] { return (*writer)->matched_count() != 0; })) << end.topic;
    }
    for (unsigned n = dice.below(20); n > 0; --n) {
      Bytes payload = dice.below(4) == 0 ? dice.bytes(200) : dice.spoilt(model.payload);
      payload.resize(std::max<std::size_t>(payload.size(), 4));
      // Cyclone sends no other encapsulation than CDR, which is for the datagrams.
      std::copy_n(std::array<std::uint8_t, 4>{0, 1, 0, 0}.data(), 4, payload.data());
      static_cast<void>(test::say_bytes(**writer, payload));
    }
    writers.push_back(std::move(*writer));
  }
}

/// Hears all that passes the loopback interface of this process's own network, and sends it again, spoilt.
class Wiretap {
 public:
  Wiretap() {
    constexpr int kEveryProtocol = 3;  // ETH_P_ALL
    hears_ = ::socket(AF_PACKET, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, htons(kEveryProtocol));
    sends_ = ::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  }
  Wiretap(const Wiretap&) = delete;
  Wiretap& operator=(const Wiretap&) = delete;
  ~Wiretap() {
    ::close(hears_);
    ::close(sends_);
  }
  [[nodiscard]] bool is_open() const { return hears_ >= 0 && sends_ >= 0; }

  /// Keeps a sample of the packets that have passed.
  void listen(Dice& dice) {
    constexpr std::size_t kMost = 500, kIpHeader = 20, kHeaders = 28;
    Bytes packet(65536);
    for (;;) {
      const auto size = ::recv(hears_, packet.data(), packet.size(), 0);
      if (size < 0) return;
      const bool is_rtps = size > 48 && (packet[0] & 0x0FU) == 5 && packet[9] == IPPROTO_UDP &&
                           std::memcmp(packet.data() + kHeaders, "RTPS", 4) == 0;
      if (!is_rtps) continue;
      Datagram heard;
      std::memcpy(&heard.to.sin_addr, packet.data() + 16, 4);
      std::memcpy(&heard.to.sin_port, packet.data() + kIpHeader + 2, 2);
      heard.to.sin_family = AF_INET;
      heard.bytes.assign(packet.begin() + kHeaders, packet.begin() + size);
      if (heard_.size() < kMost) {
        heard_.push_back(std::move(heard));
      } else {
        heard_[dice.below(kMost)] = std::move(heard);
      }
    }
  }
  void speak(Dice& dice) {
    if (heard_.empty()) return;
    const Datagram& one = heard_[dice.below(heard_.size())];
    Bytes bytes = dice.spoilt(one.bytes);
    if (dice.below(16) == 0) bytes = dice.bytes(1000);
    // Sent to its receiver, or to another one.
    const auto& to = dice.below(4) == 0 ? heard_[dice.below(heard_.size())].to : one.to;
    static_cast<void>(
        ::sendto(sends_, bytes.data(), bytes.size(), MSG_DONTWAIT, reinterpret_cast<const sockaddr*>(&to), sizeof to));
  }

 private:
  struct Datagram {
    sockaddr_in to{};
    Bytes bytes;
  };
  int hears_ = -1, sends_ = -1;
  std::vector<Datagram> heard_;
};

class Hostile : public ::testing::Test {
 public:
  Hostile() { robot.load(adding, "adder"); }

  /// A new participant is served: its calls are answered, its messages are received and it receives messages.
  void serve_an_honest_laptop() {
    test::MirroredContainer laptop{"laptop"};
    test::Calling<AddTwoInts> calling{"/add"};
    laptop.load(calling, "caller");
    ASSERT_TRUE(laptop.bell.until([&] { return calling.client->service_is_ready(); }));
    AddTwoInts::Request request;
    request.a = 40;
    request.b = 2;
    const auto answer = calling.call(request);
    ASSERT_TRUE(answer) << "no answer";
    EXPECT_EQ(answer->sum, 42);
    test::MirroredBroker visitor{"visitor"};
    const auto from = visitor.writer("/honest"), back = talker.writer("/honest_too");
    const auto to = talker.reader("/honest"), heard = visitor.reader("/honest_too");
    ASSERT_TRUE(talker.bell.until([&] { return from->reader_count() + to->writer_count() == 2; }));
    ASSERT_TRUE(visitor.bell.until([&] { return back->reader_count() + heard->writer_count() == 2; }));
    // Of a volatile writer's first messages Cyclone may take those for history that are lost while both find each other.
    EXPECT_TRUE(talker.bell.until([&] {
      test::say(*from, "here I am");
      return to->has_waiting();
    }));
    EXPECT_TRUE(visitor.bell.until([&] {
      test::say(*back, "and here");
      return heard->has_waiting();
    }));
    EXPECT_EQ(test::hear(*to).at(0), "here I am");
    EXPECT_EQ(test::hear(*heard).at(0), "and here");
  }
  /// As long as the test may take: rounds of harm, each followed by honest work.
  template <typename Harm>
  void endure(Harm harm) {
    const auto end = std::chrono::steady_clock::now() + std::chrono::seconds{setting("NACELLE_HOSTILE_SECONDS", 3)};
    RecordProperty("seed", static_cast<int>(seed));
    std::cout << "seed " << seed << std::endl;
    // What Cyclone and the allocator take once is taken before it counts.
    for (int round = 0; round < 3; ++round) {
      harm();
      ASSERT_NO_FATAL_FAILURE(serve_an_honest_laptop());
    }
    const std::size_t before = resident_bytes();
    std::size_t most = before;
    int rounds = 0;
    for (; std::chrono::steady_clock::now() < end; ++rounds) {
      harm();
      while (test::hear(*ear).size() == 100) {}
      ASSERT_NO_FATAL_FAILURE(serve_an_honest_laptop()) << "round " << rounds << ", seed " << seed;
      most = std::max(most, resident_bytes());
    }
    const MirrorStats stats = robot.stats(), heard = talker.stats();
    std::cout << rounds << " rounds; broken " << stats.broken + heard.broken << ", stray " << stats.stray + heard.stray
              << ", requests " << stats.requests << ", problems " << stats.problems + heard.problems
              << "; resident MB before " << before / 1e6 << ", at most " << most / 1e6 << std::endl;
#ifndef NACELLE_SANITIZED                            // whose heap keeps what was freed
    constexpr std::size_t kMostGrowth = 24'000'000;  // and not with the number of rounds
    EXPECT_LE(most, before + kMostGrowth);
#endif
  }

  const unsigned seed =
      static_cast<unsigned>(setting("NACELLE_HOSTILE_SEED", static_cast<long>(std::random_device{}())));
  Dice dice{seed};
  test::Offering<AddTwoInts> adding{"/add",
                                    [](const auto& request, auto& response) { response.sum = request.a + request.b; }};
  test::MirroredContainer robot{"robot"};
  test::MirroredBroker talker{"talker"};
  std::unique_ptr<Reader> ear = talker.reader("/chatter", QoS(100));
};

TEST_F(Hostile, arbitrary_announcements_and_samples_do_no_harm) {
  const auto all = models();
  endure([&] {
    for (int i = 0; i < 5; ++i) be_a_hostile_participant(dice, all);
  });
}

TEST_F(Hostile, arbitrary_datagrams_do_no_harm) {
  Wiretap tap;
  if (!tap.is_open()) GTEST_SKIP() << "raw sockets need root";
  const auto all = models();
  endure([&] {
    be_a_hostile_participant(dice, all);
    tap.listen(dice);
    for (int i = 0; i < 500; ++i) tap.speak(dice);
  });
}

}  // namespace
}  // namespace nacelle
