// SPDX-License-Identifier: Apache-2.0
#include "transport_dds/port/endpoint_end.hpp"

#include <dds/ddsi/ddsi_serdata.h>
#include <dds/ddsi/ddsi_tkmap.h>

#include <algorithm>
#include <iterator>

#include "transport_dds/port/cyclone_inside.hpp"

namespace nacelle::transport_dds {
namespace {

// The one that Cyclone forgot, and the one of the search. With more, the instance is in use.
constexpr std::uint32_t kForgottenAndFound = 2;

void free_announcement(ddsi_domaingv& domain, const ddsi_sertype* announcements, const ddsi_keyhash& key) noexcept {
  if (announcements == nullptr) return;
  ddsi_serdata* const sample = ddsi_serdata_from_keyhash(announcements, &key);
  if (sample == nullptr) return;
  constexpr bool kCreate = false;
  if (ddsi_tkmap_instance* const found = ddsi_tkmap_find(domain.m_tkmap, sample, kCreate); found != nullptr) {
    const bool is_forgotten = ddsrt_atomic_ld32(&found->m_refc) == kForgottenAndFound;
    ddsi_tkmap_instance_unref(domain.m_tkmap, found);
    if (is_forgotten) ddsi_tkmap_instance_unref(domain.m_tkmap, found);
  }
  ddsi_serdata_unref(sample);
}

}  // namespace

void end_endpoint(Entity& endpoint, const Gid& gid, const ddsi_sertype& type) noexcept {
  if (!endpoint) return;
  auto& domain = *static_cast<ddsi_domaingv*>(ddsrt_atomic_ldvoidp(&type.gv));
  // Returns when Cyclone has announced the end: nothing of Cyclone's uses the key from here on.
  endpoint.reset();
  ddsi_keyhash key{};
  std::copy(gid.bytes.begin(), gid.bytes.end(), std::begin(key.value));
  auto* const thread = lookup_thread_state();
  thread_state_awake(thread, &domain);
  // Writers and readers are announced by different types, and by two more where DDS Security protects discovery.
  free_announcement(domain, domain.sedp_writer_type, key);
  free_announcement(domain, domain.sedp_reader_type, key);
#ifdef DDS_HAS_SECURITY
  free_announcement(domain, domain.sedp_writer_secure_type, key);
  free_announcement(domain, domain.sedp_reader_secure_type, key);
#endif
  thread_state_asleep(thread);
}

}  // namespace nacelle::transport_dds
