// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "transport_dds/port/blob.hpp"

namespace nacelle::transport_dds {

/// A message type as Cyclone sees it: a name, and bytes that it does not look into.
///
/// Two are one if name and structure (the type's hash) are equal, whatever plugin they come from; so local delivery
/// between them is by reference. Keyless, XCDR1 only, no type information of XTypes. The operations live in this
/// library, never in one that can be unloaded.
/// Ownership: Cyclone counts its users; the last one frees it.
/// Source: ddsi_sertype.h and ddsi_serdata.h of Cyclone 0.10.
struct BlobType : ddsi_sertype {
  std::string structure;
  BlobPool* pool = nullptr;
};

/// Ends the filling: what Cyclone may send as padding is zero.
void finish_bytes(Blob& blob);
/// One reference, the caller's, to be given to dds_create_topic_sertype(). Throws std::bad_alloc.
[[nodiscard]] BlobType* make_blob_type(const std::string& name, std::string_view structure, const BlobLimits& limits);

}  // namespace nacelle::transport_dds
