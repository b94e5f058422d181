// SPDX-License-Identifier: Apache-2.0
#include "transport_dds/port/blob_type.hpp"

#include <dds/ddsi/q_radmin.h>

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <functional>
#include <memory>
#include <new>

#include "transport_dds/port/pacing.hpp"

// All of these are called by Cyclone, some on its receiving thread: none may throw or trust received bytes, and none may
// block but end_lending() on a thread that asked for it.
namespace nacelle::transport_dds {
namespace {

Blob& blob_of(ddsi_serdata* data) { return *static_cast<Blob*>(data); }
const Blob& blob_of(const ddsi_serdata* data) { return *static_cast<const Blob*>(data); }
const BlobType& type_of(const ddsi_sertype* type) { return *static_cast<const BlobType*>(type); }
const ddsi_serdata_ops& data_operations();

// --- a message -------------------------------------------------------------------------------------------------------

bool same_key(const ddsi_serdata* /*a*/, const ddsi_serdata* /*b*/) noexcept { return true; }
std::uint32_t size_of(const ddsi_serdata* data) noexcept { return blob_of(data).size; }

ddsi_serdata* from_network(const ddsi_sertype* type, ddsi_serdata_kind kind, const nn_rdata* fragment,
                           std::size_t size) noexcept {
  if (kind != SDK_DATA) return make_key(type, data_operations());
  Blob* const blob = type_of(type).pool->borrow(*type, size);
  if (blob == nullptr) return nullptr;
  // Fragments come in order, and may overlap: each gives what lies beyond the last byte so far.
  std::size_t filled = 0;
  for (; fragment != nullptr; fragment = fragment->nextfrag) {
    const std::size_t begin = fragment->min, end = std::min<std::size_t>(fragment->maxp1, size);
    if (begin > filled) break;  // a hole: Cyclone does not hand these out
    if (end <= filled) continue;
    const unsigned char* const payload = NN_RMSG_PAYLOADOFF(fragment->rmsg, NN_RDATA_PAYLOAD_OFF(fragment));
    std::memcpy(blob->data() + filled, payload + (filled - begin), end - filled);
    filled = end;
  }
  if (filled != size) {
    ddsi_serdata_unref(blob);
    return nullptr;
  }
  finish_bytes(*blob);
  return blob;
}

ddsi_serdata* from_pieces(const ddsi_sertype* type, ddsi_serdata_kind kind, ddsrt_msg_iovlen_t count,
                          const ddsrt_iovec_t* pieces, std::size_t size) noexcept {
  if (kind != SDK_DATA) return make_key(type, data_operations());
  Blob* const blob = type_of(type).pool->borrow(*type, size);
  if (blob == nullptr) return nullptr;
  std::size_t filled = 0;
  for (ddsrt_msg_iovlen_t i = 0; i < count && filled < size; ++i) {
    const std::size_t more = std::min<std::size_t>(pieces[i].iov_len, size - filled);
    std::memcpy(blob->data() + filled, pieces[i].iov_base, more);
    filled += more;
  }
  if (filled != size) {
    ddsi_serdata_unref(blob);
    return nullptr;
  }
  finish_bytes(*blob);
  return blob;
}

ddsi_serdata* from_key_hash(const ddsi_sertype* type, const ddsi_keyhash* /*hash*/) noexcept {
  return make_key(type, data_operations());
}

/// Only for disposing and unregistering: messages are never given as samples.
ddsi_serdata* from_sample(const ddsi_sertype* type, ddsi_serdata_kind kind, const void* /*sample*/) noexcept {
  return kind == SDK_KEY ? make_key(type, data_operations()) : nullptr;
}

void copy_out(const ddsi_serdata* data, std::size_t offset, std::size_t size, void* out) noexcept {
  std::memcpy(out, const_cast<Blob&>(blob_of(data)).data() + offset, size);
}

ddsi_serdata* lend(const ddsi_serdata* data, std::size_t offset, std::size_t size, ddsrt_iovec_t* piece) noexcept {
  piece->iov_base = const_cast<Blob&>(blob_of(data)).data() + offset;
  piece->iov_len = static_cast<ddsrt_iov_len_t>(size);
  return ddsi_serdata_ref(data);
}
// The datagram with this piece was sent.
void end_lending(ddsi_serdata* data, const ddsrt_iovec_t* /*piece*/) noexcept {
  ddsi_serdata_unref(data);
  Pacing::after_datagram();
}

/// Messages are not converted to samples here: the code that takes them decodes the bytes.
bool to_sample(const ddsi_serdata* /*data*/, void* /*sample*/, void** /*memory*/, void* /*limit*/) noexcept {
  return false;
}
bool key_to_sample(const ddsi_sertype* /*type*/, const ddsi_serdata* /*data*/, void* /*sample*/, void** /*memory*/,
                   void* /*limit*/) noexcept {
  return true;  // it has no key fields
}
ddsi_serdata* to_key(const ddsi_serdata* /*data*/) noexcept { return make_key(nullptr, data_operations()); }
void free_data(ddsi_serdata* data) noexcept { free_blob(blob_of(data)); }

std::size_t print(const ddsi_sertype* /*type*/, const ddsi_serdata* data, char* out, std::size_t room) noexcept {
  const int length = std::snprintf(out, room, "%u bytes", blob_of(data).size);
  return static_cast<std::size_t>(length);
}
void key_hash(const ddsi_serdata* /*data*/, ddsi_keyhash* out, bool /*force_md5*/) noexcept {
  std::memset(out->value, 0, sizeof(out->value));
}

#ifdef DDS_HAS_SHM
// Shared memory stays off (participant.cpp): without a size no chunk is ever requested.
std::uint32_t no_chunk_size(const ddsi_serdata* /*data*/) noexcept { return 0; }
ddsi_serdata* from_chunk(const ddsi_sertype* /*type*/, ddsi_serdata_kind /*kind*/, void* /*reader*/,
                         void* /*chunk*/) noexcept {
  return nullptr;
}
#endif

const ddsi_serdata_ops& data_operations() {
  static const ddsi_serdata_ops operations = [] {
    ddsi_serdata_ops made{};
    made.eqkey = same_key;
    made.get_size = size_of;
    made.from_ser = from_network;
    made.from_ser_iov = from_pieces;
    made.from_keyhash = from_key_hash;
    made.from_sample = from_sample;
    made.to_ser = copy_out;
    made.to_ser_ref = lend;
    made.to_ser_unref = end_lending;
    made.to_sample = to_sample;
    made.to_untyped = to_key;
    made.untyped_to_sample = key_to_sample;
    made.free = free_data;
    made.print = print;
    made.get_keyhash = key_hash;
#ifdef DDS_HAS_SHM
    made.get_sample_size = no_chunk_size;
    made.from_iox_buffer = from_chunk;
#endif
    return made;
  }();
  return operations;
}

// --- a type ----------------------------------------------------------------------------------------------------------

void free_type(ddsi_sertype* type) noexcept {
  BlobType* const mine = static_cast<BlobType*>(type);
  ddsi_sertype_fini(mine);
  if (mine->pool != nullptr) mine->pool->drop_user();
  delete mine;
}
bool same_structure(const ddsi_sertype* a, const ddsi_sertype* b) noexcept {
  return type_of(a).structure == type_of(b).structure;
}
std::uint32_t structure_hash(const ddsi_sertype* type) noexcept {
  return static_cast<std::uint32_t>(std::hash<std::string_view>{}(type_of(type).structure));
}
// For loans and dds_read() of samples, which are not used here: there are no samples.
void zero_samples(const ddsi_sertype* /*type*/, void* /*samples*/, std::size_t /*count*/) noexcept {}
void resize_samples(void** out, const ddsi_sertype* /*type*/, void* /*old*/, std::size_t /*old_count*/,
                    std::size_t count) noexcept {
  for (std::size_t i = 0; i < count; ++i) out[i] = nullptr;
}
void free_samples(const ddsi_sertype* /*type*/, void** /*samples*/, std::size_t /*count*/,
                  dds_free_op_t /*how*/) noexcept {}

const ddsi_sertype_ops& type_operations() {
  static const ddsi_sertype_ops operations = [] {
    ddsi_sertype_ops made{};
    made.version = ddsi_sertype_v0;
    made.free = free_type;
    made.zero_samples = zero_samples;
    made.realloc_samples = resize_samples;
    made.free_samples = free_samples;
    made.equal = same_structure;
    made.hash = structure_hash;
    return made;
  }();
  return operations;
}

}  // namespace

void finish_bytes(Blob& blob) {
  const std::size_t padded = (std::size_t{blob.size} + 3) / 4 * 4;  // the capacity is a multiple of 64
  std::memset(blob.data() + blob.size, 0, padded - blob.size);
}

BlobType* make_blob_type(const std::string& name, std::string_view structure, const BlobLimits& limits) {
  auto type = std::make_unique<BlobType>();
  static_cast<ddsi_sertype&>(*type) = ddsi_sertype{};
  type->structure = structure;
  type->pool = BlobPool::make(limits);
  if (type->pool == nullptr) throw std::bad_alloc{};
  ddsi_sertype_init_flags(type.get(), name.c_str(), &type_operations(), &data_operations(),
                          DDSI_SERTYPE_FLAG_TOPICKIND_NO_KEY);
  type->allowed_data_representation = DDS_DATA_REPRESENTATION_FLAG_XCDR1;
  return type.release();
}

}  // namespace nacelle::transport_dds
