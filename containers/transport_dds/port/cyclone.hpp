// SPDX-License-Identifier: Apache-2.0
// Cyclone's headers, and helpers for them. Included in port/ only, and not by its public headers.
#pragma once

#include <dds/dds.h>
#include <dds/ddsi/ddsi_serdata.h>
#include <dds/ddsi/ddsi_sertype.h>

#include <string>
#include <utility>

#include "nacelle/base/problem.hpp"
#include "transport_dds/wire/gid.hpp"

namespace nacelle::transport_dds {

/// Owns an entity of Cyclone's. Destroying it waits for its running listeners, so it must not be destroyed by one of
/// them.
class Entity {
 public:
  Entity() = default;
  explicit Entity(dds_entity_t handle) : handle_(handle) {}
  Entity(Entity&& other) noexcept : handle_(std::exchange(other.handle_, 0)) {}
  Entity& operator=(Entity&& other) noexcept {
    std::swap(handle_, other.handle_);
    return *this;
  }
  ~Entity() { reset(); }

  void reset() {
    if (handle_ > 0) dds_delete(handle_);
    handle_ = 0;
  }
  [[nodiscard]] dds_entity_t get() const { return handle_; }
  /// Returns false if the entity could not be made; get() is then Cyclone's error code.
  explicit operator bool() const { return handle_ > 0; }

 private:
  dds_entity_t handle_ = 0;
};

[[nodiscard]] inline Gid to_gid(const dds_guid_t& guid) {
  Gid gid;
  std::copy(std::begin(guid.v), std::end(guid.v), gid.bytes.begin());
  return gid;
}

[[nodiscard]] inline Gid gid_of(dds_entity_t entity) {
  dds_guid_t guid{};
  return dds_get_guid(entity, &guid) == DDS_RETCODE_OK ? to_gid(guid) : Gid{};
}

/// Returns Cyclone's name of an error: "Out of Resources".
[[nodiscard]] inline std::string error_name(dds_return_t error) { return dds_strretcode(error); }

}  // namespace nacelle::transport_dds
