// SPDX-License-Identifier: Apache-2.0
#include "frame_history.hpp"

#include <ctime>

namespace nacelle::spatial {
namespace {

constexpr auto kAcquire = std::memory_order_acquire;
constexpr auto kRelease = std::memory_order_release;
constexpr auto kRelaxed = std::memory_order_relaxed;

// A reader that outranks a preempted writer on its own CPU would spin for ever: after a while it sleeps instead.
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
inline std::uint64_t FrameHistory::oldest_index(std::uint64_t head) const {
  const std::uint64_t tail = tail_.load(kAcquire);
  return head > mask_ && head - mask_ > tail ? head - mask_ : tail;
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
      const std::uint64_t head = head_.load(kAcquire);
      const Slot& last = slot(head - 1);
      answer = {last.parent.load(kAcquire), last.stamp_ns.load(kAcquire), false};
      look(last);
      clean = head - 1 + mask_ >= head_.load(kAcquire);
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
      const std::uint64_t head = head_.load(kAcquire);
      const std::uint64_t oldest = oldest_index(head);
      answer = {slot(oldest).stamp_ns.load(kAcquire), slot(head - 1).stamp_ns.load(kAcquire), head - oldest};
      clean = oldest + mask_ >= head_.load(kAcquire);
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
      const std::uint64_t head = head_.load(kAcquire);
      std::uint64_t lowest = head;
      answer = search(stamp_ns, head, X_PC, lowest);
      // Index i shares its slot with i + mask_ + 1, which is written once head_ has reached that number.
      clean = lowest + mask_ >= head_.load(kAcquire);
    }
    if (clean && read_was_clean(epoch)) return answer;
  }
}

// Steps back from the newest sample in strides 1, 2, 4, ... and then halves the last stride: nearly every question is
// about the last few samples, and the oldest costs 2 log2(n).
inline FrameHistory::Answer FrameHistory::search(std::int64_t stamp_ns, std::uint64_t head, RigidTransform& X_PC,
                                                 std::uint64_t& lowest) const {
  std::uint64_t after = head - 1;
  lowest = after;
  const Slot& last = slot(after);
  const std::int64_t newest_ns = last.stamp_ns.load(kAcquire);
  if (stamp_ns == newest_ns) {
    load(last, X_PC);
    return {Found::Interpolated, last.parent.load(kAcquire), newest_ns};
  }
  const std::uint64_t oldest = oldest_index(head);
  if (after == oldest) return {Found::OneOtherTime, 0, newest_ns};
  if (stamp_ns > newest_ns) return {Found::TooLate, 0, newest_ns};

  std::uint64_t before = after;
  for (std::uint64_t stride = 1;; stride *= 2) {
    before = after - oldest > stride ? after - stride : oldest;
    const std::int64_t t = slot(before).stamp_ns.load(kAcquire);
    lowest = before;
    if (t <= stamp_ns) break;
    if (before == oldest) return {Found::TooEarly, 0, t};
    after = before;
  }
  while (after - before > 1) {
    const std::uint64_t middle = before + (after - before) / 2;
    (slot(middle).stamp_ns.load(kAcquire) <= stamp_ns ? before : after) = middle;
  }
  const Slot& older = slot(before);
  const std::int64_t older_ns = older.stamp_ns.load(kAcquire);
  const std::uint32_t parent = older.parent.load(kAcquire);
  load(older, X_PC);
  if (older_ns != stamp_ns) {
    const Slot& newer = slot(after);
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

FrameHistory::Added FrameHistory::add(const TransformSample& sample, Permanence permanence, std::int64_t cache_ns,
                                      std::size_t capacity) {
  const Kind kind = kind_.load(kRelaxed);
  if (permanence == Permanence::Dynamic) return add_dynamic(sample, cache_ns, capacity);
  if (kind == Kind::Static && same(static_slot_, sample)) return Added::Duplicate;
  const std::uint32_t epoch = epoch_.load(kRelaxed);
  epoch_.store(epoch + 1, kRelease);
  store(static_slot_, sample);
  tail_.store(head_.load(kRelaxed), kRelease);
  kind_.store(Kind::Static, kRelease);
  epoch_.store(epoch + 2, kRelease);
  return Added::Yes;
}

FrameHistory::Added FrameHistory::add_dynamic(const TransformSample& sample, std::int64_t cache_ns,
                                              std::size_t capacity) {
  if (!ring_) {
    mask_ = capacity - 1;
    ring_ = std::make_unique<Slot[]>(capacity);
  }
  const std::uint32_t epoch = epoch_.load(kRelaxed);
  const std::uint64_t head = head_.load(kRelaxed);
  if (kind_.load(kRelaxed) != Kind::Dynamic) {
    epoch_.store(epoch + 1, kRelease);
    tail_.store(head, kRelease);
    store(slot(head), sample);
    head_.store(head + 1, kRelease);
    kind_.store(Kind::Dynamic, kRelease);
    epoch_.store(epoch + 2, kRelease);
    return Added::Yes;
  }
  const std::uint64_t oldest = oldest_index(head);
  if (sample.stamp_ns > slot(head - 1).stamp_ns.load(kRelaxed)) {
    store(slot(head), sample);
    head_.store(head + 1, kRelease);
    prune(head + 1, cache_ns);
    return Added::Yes;
  }
  if (sample.stamp_ns < slot(head - 1).stamp_ns.load(kRelaxed) - cache_ns) return Added::TooOld;
  std::uint64_t place = head;  // after every sample that is not newer
  while (place > oldest && slot(place - 1).stamp_ns.load(kRelaxed) > sample.stamp_ns) --place;
  const bool same_time = place > oldest && slot(place - 1).stamp_ns.load(kRelaxed) == sample.stamp_ns;
  if (same_time && same(slot(place - 1), sample)) return Added::Duplicate;
  // A full ring and a sample older than all of it: there is no room for it at the old end.
  if (!same_time && place == oldest && head - oldest >= mask_) return Added::TooOld;
  epoch_.store(epoch + 1, kRelease);
  if (same_time) {
    store(slot(place - 1), sample);
  } else {
    for (std::uint64_t i = head; i > place; --i) copy(slot(i), slot(i - 1));
    store(slot(place), sample);
    head_.store(head + 1, kRelease);
  }
  epoch_.store(epoch + 2, kRelease);
  return Added::Yes;
}

void FrameHistory::prune(std::uint64_t head, std::int64_t cache_ns) {
  std::uint64_t tail = oldest_index(head);
  const std::int64_t limit_ns = slot(head - 1).stamp_ns.load(kRelaxed) - cache_ns;
  while (slot(tail).stamp_ns.load(kRelaxed) < limit_ns) ++tail;
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
