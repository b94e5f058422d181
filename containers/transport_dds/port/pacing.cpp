// SPDX-License-Identifier: Apache-2.0
#include "transport_dds/port/pacing.hpp"

#include <linux/sockios.h>
#include <sys/ioctl.h>

#include <algorithm>
#include <chrono>
#include <thread>

#include "nacelle/base/time.hpp"
#include "transport_dds/port/cyclone_inside.hpp"

namespace nacelle::transport_dds {
namespace {

// The most that the kernel may have queued before the next datagram is sent, by its own count (about 1.5 times the
// bytes).
constexpr int kMostQueued = 16 << 10;
// A link of 1 Gbit/s sends a datagram within kFirstNap, one of 1 Mbit/s within twenty times kLongestNap.
constexpr Duration kFirstNap = 50us, kLongestNap = 5ms;
// After this time nothing is sent at all (no answer to ARP, the interface is down), and the kernel will drop the
// datagram.
constexpr Duration kPatience = 1s;

thread_local Pacing* pacing_of_thread = nullptr;

int queued_of(ddsi_domaingv& domain) noexcept {
  int most = 0;
  for (int i = 0; i < domain.n_interfaces; ++i) {
    int queued = 0;
    if (::ioctl(ddsi_conn_handle(domain.xmit_conns[i]), SIOCOUTQ, &queued) == 0) most = std::max(most, queued);
  }
  return most;
}

}  // namespace

Pacing::Pacing(const ddsi_sertype* type) noexcept
    : domain_(type == nullptr ? nullptr : static_cast<ddsi_domaingv*>(ddsrt_atomic_ldvoidp(&type->gv))) {
  if (domain_ != nullptr) pacing_of_thread = this;
}

Pacing::~Pacing() { pacing_of_thread = nullptr; }

void Pacing::after_datagram() noexcept {
  if (pacing_of_thread == nullptr) return;
  ddsi_domaingv& domain = *pacing_of_thread->domain_;
  Duration nap = kFirstNap, waited{};
  for (int before = 0; waited < kPatience; nap = std::min(2 * nap, kLongestNap)) {
    const int queued = queued_of(domain);
    // Muted: the participant is leaving, and nothing is sent any more.
    if (queued <= kMostQueued || domain.mute != 0) return;
    waited = queued < before ? Duration{} : waited + nap;
    before = queued;
    std::this_thread::sleep_for(nap);
  }
}

}  // namespace nacelle::transport_dds
