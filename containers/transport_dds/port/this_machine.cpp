// SPDX-License-Identifier: Apache-2.0
#include "transport_dds/port/this_machine.hpp"

#include <ifaddrs.h>
#include <linux/filter.h>
#include <linux/sockios.h>
#include <net/if.h>
#include <netinet/in.h>
#include <sys/ioctl.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <thread>

#include "nacelle/base/time.hpp"
#include "transport_dds/port/blob_type.hpp"
#include "transport_dds/port/cyclone.hpp"
#include "transport_dds/port/cyclone_inside.hpp"

namespace nacelle::transport_dds {
namespace {

// A filter of more is refused by the kernel; one address takes two instructions of 4096.
constexpr std::size_t kMostAddresses = 1000;
// What was in the sockets when they got their filter is thrown away by Cyclone's thread meanwhile.
constexpr Duration kDraining = 200ms, kDrainStep = 200us;

std::vector<std::uint32_t> own_addresses() {
  ifaddrs* list = nullptr;
  if (::getifaddrs(&list) != 0) return {};
  std::vector<std::uint32_t> own;
  for (const ifaddrs* at = list; at != nullptr; at = at->ifa_next) {
    if (at->ifa_addr == nullptr || at->ifa_addr->sa_family != AF_INET) continue;
    own.push_back(ntohl(reinterpret_cast<const sockaddr_in*>(at->ifa_addr)->sin_addr.s_addr));
  }
  ::freeifaddrs(list);
  return own;
}

Problem refused(const char* what) {
  return {"this machine's kernel", std::string(what) + " on a socket of Cyclone DDS: " + std::strerror(errno),
          "network:=off, or network:=export if the LAN may see the robot"};
}

// Seen by the filter: the datagram, put together if it came in pieces, with its IPv4 header before it.
std::vector<sock_filter> from_this_machine(const std::vector<std::uint32_t>& own) {
  constexpr std::uint16_t kLoad = BPF_LD | BPF_W | BPF_ABS, kIfEqual = BPF_JMP | BPF_JEQ | BPF_K,
                          kAnd = BPF_ALU | BPF_AND | BPF_K, kReturn = BPF_RET | BPF_K;
  constexpr std::uint32_t kSource = static_cast<std::uint32_t>(SKF_NET_OFF) + 12, kWhole = 0xFFFFFFFFU, kNothing = 0;
  std::vector<sock_filter> program{{kLoad, 0, 0, kSource}};
  const auto let_pass = [&](std::uint32_t address) {
    program.push_back({kIfEqual, 0, 1, address});
    program.push_back({kReturn, 0, 0, kWhole});
  };
  for (std::size_t i = 0; i < std::min(own.size(), kMostAddresses); ++i) let_pass(own[i]);
  program.push_back({kAnd, 0, 0, 0xFF000000U});
  let_pass(INADDR_LOOPBACK & 0xFF000000U);
  program.push_back({kReturn, 0, 0, kNothing});
  return program;
}

Result<ddsi_domaingv*, Problem> inside_of(dds_entity_t participant) {
  // Only a type knows its domain.
  ddsi_sertype* type = make_blob_type("nacelle::home", "", {});
  const Entity topic{dds_create_topic_sertype(participant, "nacelle/home", &type, nullptr, nullptr, nullptr)};
  if (!topic) {
    ddsi_sertype_unref(type);
    return err(Problem{"DDS domain", error_name(topic.get()), ""});
  }
  return static_cast<ddsi_domaingv*>(ddsrt_atomic_ldvoidp(&type->gv));
}

std::vector<int> sockets_of(const ddsi_domaingv& domain) {
  std::vector<ddsi_tran_conn_t> all{domain.disc_conn_mc, domain.data_conn_mc, domain.disc_conn_uc, domain.data_conn_uc};
  for (int i = 0; i < domain.n_interfaces; ++i) all.push_back(domain.xmit_conns[i]);
  std::vector<int> sockets;
  for (auto* const one : all) {
    if (one != nullptr) sockets.push_back(ddsi_conn_handle(one));
  }
  return sockets;
}

Result<void, Problem> keep_sockets(const ddsi_domaingv& domain) {
  if (domain.config.transport_selector != DDSI_TRANS_UDP || domain.config.many_sockets_mode == DDSI_MSM_MANY_UNICAST) {
    return err(Problem{"CYCLONEDDS_URI", "with this transport a robot cannot be kept to this machine",
                       "take Transport udp and one socket for all participants, or network:=export"});
  }
  const auto own = own_addresses();
  for (const int socket : sockets_of(domain)) {
    if (auto kept = keep_to_this_machine(socket, own); !kept) return kept;
  }
  return {};
}

/// True once `holds` does; false after kDraining.
template <typename Condition>
bool await(const Condition& holds) {
  for (Duration waited{}; waited < kDraining; waited += kDrainStep) {
    if (holds()) return true;
    std::this_thread::sleep_for(kDrainStep);
  }
  return holds();
}

void drain(const ddsi_domaingv& domain) {
  const auto is_empty = [](int socket) {
    int waiting = 0;
    return ::ioctl(socket, SIOCINQ, &waiting) != 0 || waiting == 0;
  };
  const auto sockets = sockets_of(domain);
  await([&] { return std::all_of(sockets.begin(), sockets.end(), is_empty); });
}

/// Blocks until other threads of Cyclone's have ended the participants and sent their last messages. Returns false if a participant
/// is left.
bool await_end_of_participants(ddsi_domaingv& domain) {
  const bool none_is_left = await([&] {
    ddsrt_mutex_lock(&domain.participant_set_lock);
    const bool none = domain.nparticipants == 0;
    ddsrt_mutex_unlock(&domain.participant_set_lock);
    return none;
  });
  // The sending thread handles queued events in order, this call included, collects the messages in a datagram, sends that
  // last, and then sleeps. It runs as long as its domain, so the call is certain to happen.
  using Thread = decltype(::lookup_thread_state());
  std::atomic<Thread> sends{nullptr};
  qxev_nt_callback(
      domain.xevents, [](void* to) { static_cast<std::atomic<Thread>*>(to)->store(::lookup_thread_state()); }, &sends);
  while (sends.load() == nullptr) std::this_thread::sleep_for(kDrainStep);
  return await([&] { return vtime_asleep_p(ddsrt_atomic_ld32(&sends.load()->vtime)); }) && none_is_left;
}

bool has_met_others(dds_entity_t participant) {
  const Entity known{dds_create_reader(participant, DDS_BUILTIN_TOPIC_DCPSPARTICIPANT, nullptr, nullptr)};
  std::array<void*, 2> samples{};  // null: Cyclone lends its own
  std::array<dds_sample_info_t, 2> infos{};
  const dds_return_t count = dds_read(known.get(), samples.data(), infos.data(), samples.size(), samples.size());
  if (count > 0) dds_return_loan(known.get(), samples.data(), count);
  return count > 1;  // besides itself
}

}  // namespace

Result<void, Problem> keep_to_this_machine(int socket, const std::vector<std::uint32_t>& own) {
  const int nowhere = 0, all = 1;
  const unsigned lo = ::if_nametoindex("lo");
  if (lo == 0) return err(refused("no lo"));  // which the options below would take for "any"
  ip_mreqn by_lo{};
  by_lo.imr_address.s_addr = htonl(INADDR_LOOPBACK);  // of a socket without an address of its own
  by_lo.imr_ifindex = static_cast<int>(lo);
  if (::setsockopt(socket, IPPROTO_IP, IP_MULTICAST_IF, &by_lo, sizeof by_lo) != 0)
    return err(refused("no way but lo for multicasts"));
  // A time to live of 0 alone would not do: the kernel obeys it only where the group has been joined on the interface.
  if (::setsockopt(socket, IPPROTO_IP, IP_MULTICAST_TTL, &nowhere, sizeof nowhere) != 0)
    return err(refused("no time to live for multicasts"));
  const std::uint32_t network_order = htonl(lo);  // unlike other indices
  if (::setsockopt(socket, IPPROTO_IP, IP_UNICAST_IF, &network_order, sizeof network_order) != 0)
    return err(refused("no way but lo for unicasts"));
  // Groups are joined on lo alone, since the kernel announces any other membership on the LAN. Messages that a program of this
  // machine sends to a group on the LAN's interface arrive nevertheless, as that program has joined the group there.
  if (::setsockopt(socket, IPPROTO_IP, IP_MULTICAST_ALL, &all, sizeof all) != 0)
    return err(refused("no multicasts that others have joined"));
  auto program = from_this_machine(own);
  const sock_fprog filter{static_cast<unsigned short>(program.size()), program.data()};
  if (::setsockopt(socket, SOL_SOCKET, SO_ATTACH_FILTER, &filter, sizeof filter) != 0)
    return err(refused("no filter of senders"));
  return {};
}

Result<Home, Problem> keep_domain_to_this_machine(dds_entity_t domain, std::uint32_t id) {
  // Its sockets have been open for a moment.
  if (const dds_return_t shut = dds_domain_set_deafmute(domain, true, true, DDS_INFINITY); shut != DDS_RETCODE_OK)
    return err(Problem{"DDS domain " + std::to_string(id), error_name(shut), ""});
  ddsi_domaingv* gv = nullptr;
  {
    // It is never announced: it is destroyed before its domain may send.
    const Entity scout{dds_create_participant(id, nullptr, nullptr)};
    if (!scout) return err(Problem{"DDS domain " + std::to_string(id), error_name(scout.get()), ""});
    const auto inside = inside_of(scout.get());
    if (!inside) return err(inside.error());
    gv = inside.value();
    if (auto kept = keep_sockets(*gv); !kept) return err(kept.error());
    drain(*gv);
    if (has_met_others(scout.get())) return Home::Visited;
  }
  if (!await_end_of_participants(*gv)) return Home::Visited;  // must be made anew, on such a busy machine
  dds_domain_set_deafmute(domain, false, false, DDS_INFINITY);
  return Home::Alone;
}

}  // namespace nacelle::transport_dds
