// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "transport_dds/port/blob.hpp"

namespace nacelle::transport_dds {

/// A message type for Cyclone: a name, and opaque bytes.
///
/// Two types are equal if name and structure (the type's hash) are equal, even if they come from different plugins, so
/// local delivery between them is by reference. Keyless, XCDR1 only, without type information of XTypes. The operations
/// are part of this library, which is never unloaded.
/// Ownership: Cyclone counts its users; the last one frees it.
/// Source: ddsi_sertype.h and ddsi_serdata.h of Cyclone 0.10.
struct BlobType : ddsi_sertype {
  std::string structure;
  BlobPool* pool = nullptr;
};

/// Zeroes the bytes that Cyclone may send as padding. Call after the blob was filled.
void finish_bytes(Blob& blob);
/// Returns a type with one reference, the caller's, which dds_create_topic_sertype() takes over. Throws std::bad_alloc.
[[nodiscard]] BlobType* make_blob_type(const std::string& name, std::string_view structure, const BlobLimits& limits);

}  // namespace nacelle::transport_dds
