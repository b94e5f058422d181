// SPDX-License-Identifier: Apache-2.0
// bare_endpoints [endpoints=240]
// What plain Cyclone keeps in memory for a participant with so many endpoints, each with a topic of its own as the services of
// ROS 2's nodes have them, and nobody on the network.
#include <dds/dds.h>

#include <cstdio>
#include <cstdlib>
#include <string>

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

void make_endpoints(int participant, std::uint64_t count) {
  dds_qos_t* const qos = dds_create_qos();
  dds_qset_reliability(qos, DDS_RELIABILITY_RELIABLE, DDS_INFINITY);
  dds_qset_history(qos, DDS_HISTORY_KEEP_LAST, 10);
  for (std::uint64_t i = 0; i < count; ++i) {
    const std::string name = "rq/camera/endpoint_" + std::to_string(i) + "Request";
    const int topic =
        must(dds_create_topic(participant, &sensor_msgs_msg_dds__Image__desc, name.c_str(), nullptr, nullptr));
    must(i % 2 == 0 ? dds_create_writer(participant, topic, qos, nullptr)
                    : dds_create_reader(participant, topic, qos, nullptr));
  }
  dds_delete_qos(qos);
}

}  // namespace
}  // namespace nacelle::bench

int main(int count, char** words) {
  using namespace nacelle::bench;
  static_cast<void>(nacelle::test::enter_own_network());
  const std::uint64_t endpoints = Arguments(count, words).number("endpoints", 240);
  const Memory linked = Memory::now();
  must(dds_create_domain(
      7, R"(<General><Interfaces><NetworkInterface name="lo" multicast="true"/></Interfaces></General>)"));
  const int participant = must(dds_create_participant(7, nullptr, nullptr));
  const Memory alone = Memory::now();
  make_endpoints(participant, endpoints);
  const Memory all = Memory::now();
  print_figures({{"linked_rss", static_cast<double>(linked.resident)},
                 {"participant", static_cast<double>(alone.resident - linked.resident)},
                 {"endpoints", static_cast<double>(all.resident - alone.resident)}});
  must(dds_delete(participant));
  return 0;
}
