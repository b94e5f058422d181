// SPDX-License-Identifier: Apache-2.0
#include "frame_history.hpp"

#include <algorithm>
#include <ctime>
#include <utility>

namespace nacelle::spatial {
namespace {

constexpr auto kAcquire = std::memory_order_acquire;
constexpr auto kRelease = std::memory_order_release;
constexpr auto kRelaxed = std::memory_order_relaxed;

// A reader with a higher priority than a preempted writer on its CPU would spin forever: after a while it sleeps
// instead.
constexpr int kSpinsBeforeSleep = 200;
constexpr timespec kShortSleep{0, 50'000};

}  // namespace

void FrameHistory::store(Slot& slot, const TransformSample& sample) {
  slot.stamp_ns.store(sample.stamp_ns, kRelease);
  slot.parent.store(sample.parent, kRelease);
  for (Eigen::Index i = 0; i < 4; ++i) {
    slot.values[static_cast<std::size_t>(i)].store(sample.X_PC.rotation.coeffs()[i], kRelease);
  }
  for (Eigen::Index i = 0; i < 3; ++i) {
    slot.values[static_cast<std::size_t>(4 + i)].store(sample.X_PC.translation_m[i], kRelease);
  }
}

void FrameHistory::copy(Slot& to, const Slot& from) {
  to.stamp_ns.store(from.stamp_ns.load(kRelaxed), kRelease);
  to.parent.store(from.parent.load(kRelaxed), kRelease);
  for (std::size_t i = 0; i < to.values.size(); ++i) to.values[i].store(from.values[i].load(kRelaxed), kRelease);
}

inline void FrameHistory::load(const Slot& slot, RigidTransform& X_PC) {
  const auto value = [&slot](std::size_t i) { return slot.values[i].load(kAcquire); };
  X_PC.rotation = Eigen::Quaterniond{value(3), value(0), value(1), value(2)};
  X_PC.translation_m = Eigen::Vector3d{value(4), value(5), value(6)};
}

bool FrameHistory::same(const Slot& slot, const TransformSample& sample) {
  RigidTransform X;
  load(slot, X);
  return slot.stamp_ns.load(kRelaxed) == sample.stamp_ns && slot.parent.load(kRelaxed) == sample.parent &&
         X.rotation.coeffs() == sample.X_PC.rotation.coeffs() && X.translation_m == sample.X_PC.translation_m;
}

std::uint32_t FrameHistory::wait_for_writer() const {
  for (int spins = 0;; ++spins) {
    const std::uint32_t epoch = epoch_.load(kAcquire);
    if ((epoch & 1U) == 0) return epoch;
    if (spins >= kSpinsBeforeSleep) clock_nanosleep(CLOCK_MONOTONIC, 0, &kShortSleep, nullptr);
  }
}

// The slot before the oldest one is the writer's next: it is never part of what readers see.
inline std::uint64_t FrameHistory::oldest_index(const View& ring, std::uint64_t head) const {
  const std::uint64_t tail = tail_.load(kAcquire);
  return head > ring.mask && head - ring.mask > tail ? head - ring.mask : tail;
}

template <typename Look>
inline FrameHistory::Newest FrameHistory::read_newest(const Look& look) const {
  for (;;) {
    const std::uint32_t epoch = begin_read();
    Newest answer;
    const Kind kind = kind_.load(kAcquire);
    bool clean = true;
    if (kind == Kind::Static) {
      answer = {static_slot_.parent.load(kAcquire), 0, true};
      look(static_slot_);
    } else if (kind == Kind::Dynamic) {
      const Ring* const now = ring_.load(kAcquire);
      const View ring = view(*now);
      const std::uint64_t head = head_.load(kAcquire);
      const Slot& last = ring[head - 1];
      answer = {last.parent.load(kAcquire), last.stamp_ns.load(kAcquire), false};
      look(last);
      clean = head - 1 + ring.mask >= head_.load(kAcquire) && ring_.load(kAcquire) == now;
    }
    if (clean && read_was_clean(epoch)) return answer;
  }
}

FrameHistory::Newest FrameHistory::newest() const {
  return read_newest([](const Slot&) {});
}
FrameHistory::Newest FrameHistory::newest(RigidTransform& X_PC) const {
  return read_newest([&X_PC](const Slot& slot) { load(slot, X_PC); });
}

FrameHistory::Span FrameHistory::span() const {
  for (;;) {
    const std::uint32_t epoch = begin_read();
    Span answer;
    const Kind kind = kind_.load(kAcquire);
    bool clean = true;
    if (kind == Kind::Static) {
      answer.samples = 1;
    } else if (kind == Kind::Dynamic) {
      const Ring* const now = ring_.load(kAcquire);
      const View ring = view(*now);
      const std::uint64_t head = head_.load(kAcquire);
      const std::uint64_t oldest = oldest_index(ring, head);
      answer = {ring[oldest].stamp_ns.load(kAcquire), ring[head - 1].stamp_ns.load(kAcquire), head - oldest};
      clean = oldest + ring.mask >= head_.load(kAcquire) && ring_.load(kAcquire) == now;
    }
    if (clean && read_was_clean(epoch)) return answer;
  }
}

FrameHistory::Answer FrameHistory::at(std::int64_t stamp_ns, RigidTransform& X_PC) const {
  for (;;) {
    const std::uint32_t epoch = begin_read();
    Answer answer;
    const Kind kind = kind_.load(kAcquire);
    bool clean = true;
    if (kind == Kind::Static) {
      load(static_slot_, X_PC);
      answer = {Found::Interpolated, static_slot_.parent.load(kAcquire), 0};
    } else if (kind == Kind::Dynamic) {
      const Ring* const now = ring_.load(kAcquire);
      const View ring = view(*now);
      const std::uint64_t head = head_.load(kAcquire);
      std::uint64_t lowest = head;
      answer = search(stamp_ns, ring, head, X_PC, lowest);
      // Index i shares its slot with i + mask + 1, which is written once head_ has reached that number. If the
      // ring was replaced meanwhile, head_ may lie beyond the written samples.
      clean = lowest + ring.mask >= head_.load(kAcquire) && ring_.load(kAcquire) == now;
    }
    if (clean && read_was_clean(epoch)) return answer;
  }
}

// Steps back from the newest sample in strides 1, 2, 4, ... and then halves the last stride: nearly every question is
// about the last few samples, and the oldest costs 2 log2(n).
inline FrameHistory::Answer FrameHistory::search(std::int64_t stamp_ns, const View& ring, std::uint64_t head,
                                                 RigidTransform& X_PC, std::uint64_t& lowest) const {
  std::uint64_t after = head - 1;
  lowest = after;
  const Slot& last = ring[after];
  const std::int64_t newest_ns = last.stamp_ns.load(kAcquire);
  if (stamp_ns == newest_ns) {
    load(last, X_PC);
    return {Found::Interpolated, last.parent.load(kAcquire), newest_ns};
  }
  const std::uint64_t oldest = oldest_index(ring, head);
  if (after == oldest) return {Found::OneOtherTime, 0, newest_ns};
  if (stamp_ns > newest_ns) return {Found::TooLate, 0, newest_ns};

  std::uint64_t before = 0;
  for (std::uint64_t stride = 1;; stride *= 2) {
    before = after - oldest > stride ? after - stride : oldest;
    const std::int64_t t = ring[before].stamp_ns.load(kAcquire);
    lowest = before;
    if (t <= stamp_ns) break;
    if (before == oldest) return {Found::TooEarly, 0, t};
    after = before;
  }
  while (after - before > 1) {
    const std::uint64_t middle = before + (after - before) / 2;
    (ring[middle].stamp_ns.load(kAcquire) <= stamp_ns ? before : after) = middle;
  }
  const Slot& older = ring[before];
  const std::int64_t older_ns = older.stamp_ns.load(kAcquire);
  const std::uint32_t parent = older.parent.load(kAcquire);
  load(older, X_PC);
  if (older_ns != stamp_ns) {
    const Slot& newer = ring[after];
    if (newer.parent.load(kAcquire) == parent) {
      const std::int64_t newer_ns = newer.stamp_ns.load(kAcquire);
      RigidTransform X_next;
      load(newer, X_next);
      const double ratio = static_cast<double>(stamp_ns - older_ns) / static_cast<double>(newer_ns - older_ns);
      X_PC = interpolate(X_PC, X_next, ratio);
    }
  }
  return {Found::Interpolated, parent, older_ns};
}

FrameHistory::Added FrameHistory::add(const TransformSample& sample, Permanence permanence, const Sizes& sizes) {
  const Kind kind = kind_.load(kRelaxed);
  if (permanence == Permanence::Dynamic) return add_dynamic(sample, sizes);
  if (kind == Kind::Static && same(static_slot_, sample)) return Added::Duplicate;
  const std::uint32_t epoch = epoch_.load(kRelaxed);
  epoch_.store(epoch + 1, kRelease);
  store(static_slot_, sample);
  tail_.store(head_.load(kRelaxed), kRelease);
  kind_.store(Kind::Static, kRelease);
  epoch_.store(epoch + 2, kRelease);
  return Added::Yes;
}

FrameHistory::Added FrameHistory::add_dynamic(const TransformSample& sample, const Sizes& sizes) {
  const std::int64_t cache_ns = sizes.cache_ns;
  if (rings_ == nullptr) {
    rings_ = std::make_unique<Ring>(sizes.first);
    ring_.store(rings_.get(), kRelease);
  }
  const std::uint32_t epoch = epoch_.load(kRelaxed);
  const std::uint64_t head = head_.load(kRelaxed);
  if (kind_.load(kRelaxed) != Kind::Dynamic) {
    const View ring = view(*rings_);
    epoch_.store(epoch + 1, kRelease);
    tail_.store(head, kRelease);
    store(ring[head], sample);
    head_.store(head + 1, kRelease);
    kind_.store(Kind::Dynamic, kRelease);
    epoch_.store(epoch + 2, kRelease);
    return Added::Yes;
  }
  const std::int64_t newest_ns = view(*rings_)[head - 1].stamp_ns.load(kRelaxed);
  if (sample.stamp_ns < newest_ns - cache_ns) return Added::TooOld;
  grow_if_full(std::max(newest_ns, sample.stamp_ns), sizes);
  const View ring = view(*rings_);
  const std::uint64_t oldest = oldest_index(ring, head);
  if (sample.stamp_ns > newest_ns) {
    store(ring[head], sample);
    head_.store(head + 1, kRelease);
    prune(ring, head + 1, cache_ns);
    return Added::Yes;
  }
  std::uint64_t place = head;  // after every sample that is not newer
  while (place > oldest && ring[place - 1].stamp_ns.load(kRelaxed) > sample.stamp_ns) --place;
  const bool same_time = place > oldest && ring[place - 1].stamp_ns.load(kRelaxed) == sample.stamp_ns;
  if (same_time && same(ring[place - 1], sample)) return Added::Duplicate;
  // A full ring and a sample older than all of it: there is no room for it at the old end.
  if (!same_time && place == oldest && head - oldest >= ring.mask) return Added::TooOld;
  epoch_.store(epoch + 1, kRelease);
  if (same_time) {
    store(ring[place - 1], sample);
  } else {
    for (std::uint64_t i = head; i > place; --i) copy(ring[i], ring[i - 1]);
    store(ring[place], sample);
    head_.store(head + 1, kRelease);
  }
  epoch_.store(epoch + 2, kRelease);
  return Added::Yes;
}

// Called before a sample replaces the oldest one. Readers continue in the old ring, or detect that it was replaced.
void FrameHistory::grow_if_full(std::int64_t newest_ns, const Sizes& sizes) {
  const View old = view(*rings_);
  const std::uint64_t head = head_.load(kRelaxed);
  const std::uint64_t oldest = oldest_index(old, head);
  if (head - oldest < old.mask || old.mask + 1 >= sizes.most) return;
  if (old[oldest].stamp_ns.load(kRelaxed) < newest_ns - sizes.cache_ns) return;
  auto larger = std::make_unique<Ring>(2 * (old.mask + 1));
  const View ring = view(*larger);
  for (std::uint64_t i = oldest; i < head; ++i) copy(ring[i], old[i]);
  tail_.store(oldest, kRelease);  // earlier samples are not in the larger ring
  larger->smaller = std::move(rings_);
  rings_ = std::move(larger);
  ring_.store(rings_.get(), kRelease);
}

void FrameHistory::prune(const View& ring, std::uint64_t head, std::int64_t cache_ns) {
  std::uint64_t tail = oldest_index(ring, head);
  const std::int64_t limit_ns = ring[head - 1].stamp_ns.load(kRelaxed) - cache_ns;
  while (ring[tail].stamp_ns.load(kRelaxed) < limit_ns) ++tail;
  tail_.store(tail, kRelease);
}

void FrameHistory::clear() {
  const std::uint32_t epoch = epoch_.load(kRelaxed);
  epoch_.store(epoch + 1, kRelease);
  tail_.store(head_.load(kRelaxed), kRelease);
  kind_.store(Kind::Empty, kRelease);
  epoch_.store(epoch + 2, kRelease);
}

}  // namespace nacelle::spatial
