// SPDX-License-Identifier: Apache-2.0
// bare_endpoints [endpoints=240] [cycles=1000]
//
// What plain Cyclone keeps in memory for a participant with so many endpoints, each with a topic of its own as the
// services of ROS 2's nodes have them, without other participants; and how much heap stays of each endpoint that is
// made and deleted.
#include <dds/dds.h>
#include <malloc.h>

#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include "ros_types.h"
#include "support/arguments.hpp"
#include "support/own_network.hpp"
#include "support/usage.hpp"

namespace nacelle::bench {
namespace {

int must(int made) {
  if (made < 0) std::fprintf(stderr, "%s\n", dds_strretcode(made)), std::exit(1);
  return made;
}

/// Returns the entities. `count` topics, each with a writer or a reader.
std::vector<int> make_endpoints(int participant, std::uint64_t count) {
  std::vector<int> made;
  dds_qos_t* const qos = dds_create_qos();
  dds_qset_reliability(qos, DDS_RELIABILITY_RELIABLE, DDS_INFINITY);
  dds_qset_history(qos, DDS_HISTORY_KEEP_LAST, 10);
  for (std::uint64_t i = 0; i < count; ++i) {
    const std::string name = "rq/camera/endpoint_" + std::to_string(i) + "Request";
    const int topic =
        must(dds_create_topic(participant, &sensor_msgs_msg_dds__Image__desc, name.c_str(), nullptr, nullptr));
    made.push_back(must(i % 2 == 0 ? dds_create_writer(participant, topic, qos, nullptr)
                                   : dds_create_reader(participant, topic, qos, nullptr)));
    made.push_back(topic);
  }
  dds_delete_qos(qos);
  return made;
}

/// Returns the bytes of heap that stay of each endpoint.
double kept_of_each(int participant, std::uint64_t cycles) {
  constexpr std::uint64_t kAtOnce = 30;
  const auto cycle = [&] {
    for (const int entity : make_endpoints(participant, kAtOnce)) must(dds_delete(entity));
  };
  for (int i = 0; i < 100; ++i) cycle();
  const std::size_t before = ::mallinfo2().uordblks;
  for (std::uint64_t i = 0; i < cycles; ++i) cycle();
  const double grown = static_cast<double>(::mallinfo2().uordblks) - static_cast<double>(before);
  return grown / static_cast<double>(cycles * kAtOnce);
}

}  // namespace
}  // namespace nacelle::bench

int main(int count, char** words) {
  using namespace nacelle::bench;
  static_cast<void>(nacelle::test::enter_own_network());
  const Arguments arguments(count, words);
  const std::uint64_t endpoints = arguments.number("endpoints", 240), cycles = arguments.number("cycles", 1000);
  const Memory linked = Memory::now();
  must(dds_create_domain(
      7, R"(<General><Interfaces><NetworkInterface name="lo" multicast="true"/></Interfaces></General>)"));
  const int participant = must(dds_create_participant(7, nullptr, nullptr));
  const Memory alone = Memory::now();
  make_endpoints(participant, endpoints);
  const Memory all = Memory::now();
  print_figures({{"linked_rss", static_cast<double>(linked.resident)},
                 {"participant", static_cast<double>(alone.resident - linked.resident)},
                 {"endpoints", static_cast<double>(all.resident - alone.resident)},
                 {"kept_of_each", kept_of_each(participant, cycles)}});
  must(dds_delete(participant));
  return 0;
}
