// SPDX-License-Identifier: Apache-2.0
#include "transport_dds/port/blob.hpp"

#include <algorithm>
#include <limits>
#include <new>

#include "transport_dds/port/payload.hpp"

namespace nacelle::transport_dds {
namespace {

constexpr std::size_t kAlwaysKept = std::size_t{64} << 10U;

Blob* make_blob(std::size_t capacity) noexcept {
  void* const memory = ::operator new(sizeof(Blob) + 4 + capacity, std::nothrow);
  if (memory == nullptr) return nullptr;
  Blob* const blob = new (memory) Blob{};
  blob->capacity = static_cast<std::uint32_t>(capacity);
  return blob;
}

void end_blob(Blob* blob) noexcept {
  if (blob == nullptr) return;
  blob->~Blob();
  ::operator delete(blob);
}

}  // namespace

BlobPool* BlobPool::make(const BlobLimits& limits) noexcept { return new (std::nothrow) BlobPool(limits); }

BlobPool::~BlobPool() {
  for (std::size_t i = 0; i < kept_count_; ++i) end_blob(kept_[i]);
}

void BlobPool::drop_user() noexcept {
  if (users_.fetch_sub(1, std::memory_order_acq_rel) == 1) delete this;
}

Blob* BlobPool::remove_kept(std::size_t place) noexcept {
  Blob* const blob = kept_[place];
  std::copy(kept_.begin() + place + 1, kept_.begin() + kept_count_, kept_.begin() + place);
  --kept_count_;
  kept_bytes_ -= blob->capacity;
  return blob;
}

Blob* BlobPool::take_kept(std::size_t bytes) noexcept {
  const LockGuard lock(mutex_);
  recent_ = std::max(bytes, recent_ - recent_ / 8);
  std::size_t best = kept_count_;
  for (std::size_t i = 0; i < kept_count_; ++i) {
    if (kept_[i]->capacity >= bytes && (best == kept_count_ || kept_[i]->capacity < kept_[best]->capacity)) best = i;
  }
  // A short message does not take the place of a long one.
  if (best == kept_count_ || kept_[best]->capacity > 4 * bytes + 4096) return nullptr;
  return remove_kept(best);
}

Blob* BlobPool::borrow(const ddsi_sertype& type, std::size_t bytes) noexcept {
  const std::size_t most = std::min<std::size_t>(limits_.most_bytes, std::numeric_limits<std::int32_t>::max());
  Blob* blob = nullptr;
  if (bytes <= most) {
    blob = take_kept(bytes);
    // Messages of a stream are about as long as each other; to_ser may ask for up to three bytes of padding.
    if (blob == nullptr) blob = make_blob((bytes + bytes / 8 + 63) / 64 * 64);
  }
  if (blob != nullptr && bytes_out_.fetch_add(blob->capacity, std::memory_order_relaxed) + blob->capacity >
                             std::max(limits_.most_bytes_out, std::size_t{blob->capacity})) {
    bytes_out_.fetch_sub(blob->capacity, std::memory_order_relaxed);
    end_blob(std::exchange(blob, nullptr));
  }
  if (blob == nullptr) {
    refused_.fetch_add(1, std::memory_order_relaxed);
    return nullptr;
  }
  ddsi_serdata_init(blob, &type, SDK_DATA);
  blob->hash = type.serdata_basehash;
  blob->size = static_cast<std::uint32_t>(bytes);
  blob->pool = this;
  users_.fetch_add(1, std::memory_order_relaxed);
  return blob;
}

void BlobPool::take_back(Blob& blob) noexcept {
  blob.out.reset();
  bytes_out_.fetch_sub(blob.capacity, std::memory_order_relaxed);
  std::array<Blob*, kMostKept> away{};
  std::size_t away_count = 0;
  bool keep = false;
  {
    const LockGuard lock(mutex_);
    const std::size_t room = std::max(kAlwaysKept, 2 * recent_ + recent_ / 2);
    keep = blob.capacity <= room;
    while (keep && kept_count_ != 0 && (kept_count_ == kMostKept || kept_bytes_ + blob.capacity > room))
      away[away_count++] = remove_kept(0);  // the oldest
    if (keep) {
      kept_[kept_count_++] = &blob;
      kept_bytes_ += blob.capacity;
    }
  }
  for (std::size_t i = 0; i < away_count; ++i) end_blob(away[i]);
  if (!keep) end_blob(&blob);
  drop_user();
}

std::size_t BlobPool::bytes_kept() const {
  const LockGuard lock(mutex_);
  return kept_bytes_;
}

Blob* make_key(const ddsi_sertype* type, const ddsi_serdata_ops& ops) noexcept {
  Blob* const blob = make_blob(0);
  if (blob == nullptr) return nullptr;
  // Of an untyped key Cyclone wants the operations only.
  ddsi_sertype any{};
  any.serdata_ops = &ops;
  ddsi_serdata_init(blob, &any, SDK_KEY);
  blob->type = type;
  blob->hash = ddsi_sertype_compute_serdata_basehash(&ops);
  return blob;
}

void free_blob(Blob& blob) noexcept {
  if (blob.out) blob.out->fetch_sub(1, std::memory_order_relaxed);
  if (blob.pool != nullptr) {
    blob.pool->take_back(blob);
  } else {
    end_blob(&blob);
  }
}

// --- the handles -----------------------------------------------------------------------------------------------------

Payload::~Payload() {
  if (blob_ != nullptr) ddsi_serdata_unref(blob_);
}
ByteView Payload::bytes() const { return blob_ != nullptr ? blob_->bytes() : ByteView{}; }

OutgoingPayload::~OutgoingPayload() {
  if (blob_ != nullptr) ddsi_serdata_unref(blob_);
}
ByteSpan OutgoingPayload::bytes() { return blob_ != nullptr ? ByteSpan{blob_->data(), blob_->size} : ByteSpan{}; }

}  // namespace nacelle::transport_dds
