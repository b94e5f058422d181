// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <memory>

#include "nacelle/spatial/transform_buffer.hpp"

namespace nacelle::spatial {

struct TransformSample {
  std::int64_t stamp_ns{};
  std::uint32_t parent{};
  RigidTransform X_PC;
};

/// The samples of one frame: a ring that one writer appends to and readers search without a lock.
///
/// A sample that is newer than all others (nearly every one) is written beside the visible window and then published by
/// moving head_. A reader is disturbed only if it reads the very sample that is overwritten, which it detects
/// afterwards, and repeats. All other changes (late sample, new kind, clear) are made while epoch_ is odd; readers wait for them.
/// A ring that would lose a sample that is still needed is replaced by one of twice the size while readers continue; they detect
/// that afterwards, too. The smaller rings are kept until the end; together they are smaller than the last.
/// All shared fields are atomics, stored with release and loaded with acquire, so that the order holds without fences.
class [[gnu::visibility("hidden")]] FrameHistory {
 public:
  enum class Found : std::uint8_t { Interpolated, Nothing, TooEarly, TooLate, OneOtherTime };
  enum class Added : std::uint8_t { Yes, Duplicate, TooOld };

  struct Answer {
    Found found{Found::Nothing};
    std::uint32_t parent{};
    std::int64_t available_ns{};
  };
  struct Newest {
    std::uint32_t parent{};  ///< 0: the frame has no samples, it is a root.
    std::int64_t stamp_ns{};
    bool is_static{};
  };

  // Readers, any thread.
  [[nodiscard]] Newest newest() const;
  /// The same with the transform itself; X_PC is left alone if there are no samples.
  [[nodiscard]] Newest newest(RigidTransform & X_PC) const;
  /// The transform to the parent at a time.
  [[nodiscard]] Answer at(std::int64_t stamp_ns, RigidTransform & X_PC) const;
  struct Span {
    std::int64_t oldest_ns{}, newest_ns{};
    std::size_t samples{};
  };
  [[nodiscard]] Span span() const;

  // The writer, one at a time.
  struct Sizes {
    std::int64_t cache_ns{};
    std::size_t first{}, most{};  ///< Of a ring: powers of two.
  };
  [[nodiscard]] Added add(const TransformSample& sample, Permanence permanence, const Sizes& sizes);
  void clear();

 private:
  struct Slot {
    std::atomic<std::int64_t> stamp_ns{0};
    std::atomic<std::uint32_t> parent{0};
    std::array<std::atomic<double>, 7> values{};  // qx qy qz qw x y z
  };
  struct Ring {
    explicit Ring(std::size_t size) : mask(size - 1), slots(std::make_unique<Slot[]>(size)) {}
    std::uint64_t mask;
    std::unique_ptr<Slot[]> slots;
    std::unique_ptr<Ring> smaller;  // the one before it
  };
  // One ring, as a reader or the writer sees it.
  struct View {
    Slot* slots;
    std::uint64_t mask;
    [[nodiscard]] Slot& operator[](std::uint64_t index) const { return slots[index & mask]; }
  };
  [[nodiscard]] static View view(const Ring& ring) { return {ring.slots.get(), ring.mask}; }
  enum class Kind : std::uint8_t { Empty, Static, Dynamic };  // Dynamic has one sample or more

  static void store(Slot & slot, const TransformSample& sample);
  static void copy(Slot & to, const Slot& from);
  static void load(const Slot& slot, RigidTransform& X_PC);
  [[nodiscard]] static bool same(const Slot& slot, const TransformSample& sample);
  [[nodiscard]] std::uint64_t oldest_index(const View& ring, std::uint64_t head) const;
  [[nodiscard]] Answer search(std::int64_t stamp_ns, const View& ring, std::uint64_t head, RigidTransform& X_PC,
                              std::uint64_t& lowest) const;
  Added add_dynamic(const TransformSample& sample, const Sizes& sizes);
  void grow_if_full(std::int64_t newest_ns, const Sizes& sizes);
  void prune(const View& ring, std::uint64_t head, std::int64_t cache_ns);
  template <typename Look>
  [[nodiscard]] Newest read_newest(const Look& look) const;
  [[nodiscard]] std::uint32_t begin_read() const {
    const std::uint32_t epoch = epoch_.load(std::memory_order_acquire);
    return (epoch & 1U) == 0 ? epoch : wait_for_writer();
  }
  [[nodiscard]] std::uint32_t wait_for_writer() const;
  [[nodiscard]] bool read_was_clean(std::uint32_t epoch) const {
    return epoch_.load(std::memory_order_acquire) == epoch;
  }

  // ring_ is not null once kind_ is Dynamic. A reader loads it before head_ and checks it again at the end.
  std::unique_ptr<Ring> rings_;
  std::atomic<const Ring*> ring_{nullptr};
  Slot static_slot_;
  std::atomic<Kind> kind_{Kind::Empty};
  std::atomic<std::uint32_t> epoch_{0};
  std::atomic<std::uint64_t> head_{0};  // samples ever appended; the newest is head_ - 1
  std::atomic<std::uint64_t> tail_{0};  // the oldest that is not pruned
};

}  // namespace nacelle::spatial
