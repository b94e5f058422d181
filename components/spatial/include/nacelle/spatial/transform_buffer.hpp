// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <compare>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "nacelle/base/clock_skews.hpp"
#include "nacelle/base/result.hpp"
#include "nacelle/base/time.hpp"
#include "nacelle/spatial/lookup_fault.hpp"
#include "nacelle/spatial/rigid_transform.hpp"

namespace nacelle::spatial {

/// A frame name as a number, the same for as long as its buffer lives. 0 is no frame.
struct FrameId {
  std::uint32_t value{};
  explicit operator bool() const { return value != 0; }
  friend auto operator<=>(FrameId, FrameId) = default;
};

enum class Permanence : std::uint8_t { Dynamic, Static };

/// Why a transform was not taken into the buffer. The buffer is unchanged then.
enum class InsertFault : std::uint8_t {
  EmptyFrame,     ///< Parent or child has no name.
  SelfTransform,  ///< Parent and child are one frame.
  NotFinite,      ///< A NaN or an infinity.
  NotNormalised,  ///< | |q|^2 - 1 | >= 0.01: not a rotation.
  TooOld,         ///< Older than the cache time before the newest sample of its frame.
  TooManyFrames,  ///< The table of names is full; nothing that publishes endless names can fill the memory.
};
[[nodiscard]] std::string_view to_text(InsertFault fault);

struct StampedTransform {
  RigidTransform X_TS;  ///< Coordinates in the source frame to coordinates in the target frame.
  WallTime stamp{};     ///< The time it holds for; 0 if every part of the chain is static.
};

struct TransformBufferOptions {
  Duration cache_time = 10s;             ///< How far back a frame's history reaches, seen from its newest sample.
  std::size_t samples_per_frame = 1024;  ///< Room at first; a power of two. It doubles where cache_time needs more,
  std::size_t most_samples_per_frame = 16384;  ///< up to this: 10 s at 1 kHz. Above that the history is shorter.
  std::size_t max_frames = 512;
};

/// Every insert is counted once: inserted + duplicates + the rejected ones.
struct TransformBufferStats {
  std::uint64_t inserted{}, duplicates{};
  std::uint64_t empty_frame{}, self_transform{}, not_finite{}, not_normalised{}, too_old{}, too_many_frames{};
};

/// One edge of the tree, for tools.
struct FrameInfo {
  std::string child, parent;
  bool is_static{};
  WallTime oldest{}, newest{};
  std::size_t samples{};
  std::uint64_t writer{};  ///< Of the last sample: the argument of insert().
};

/// The transforms of the last ten seconds between all frames: one per container, for every component.
///
/// Behaves as tf2's BufferCore: out-of-order samples inside the cache time are sorted in, a newer parent replaces an older
/// one, static transforms hold at any time, samples with different parents are not interpolated. A sample with the stamp
/// of an earlier one replaces it.
///
/// Threads:   any, for every member. Writers exclude each other. Readers take no lock and never wait for each other; a
///            reader waits for a writer only while that one sorts in a sample that came late.
/// Allocates: lookups nothing; inserts only for a frame's first dynamic sample, and when its rate is found to need more room.
class TransformBuffer {
 public:
  explicit TransformBuffer(const TransformBufferOptions& options = {});
  TransformBuffer(const TransformBuffer&) = delete;
  TransformBuffer& operator=(const TransformBuffer&) = delete;
  ~TransformBuffer();

  /// The number of a name, made on first use; a leading '/' does not count. No frame if the name is empty or the table full.
  /// An interned frame is unknown to lookups until a transform names it. Allocates: for a new name.
  [[nodiscard]] FrameId intern(std::string_view name);
  /// The number of a name that was interned before, or no frame. Allocates: nothing.
  [[nodiscard]] FrameId find(std::string_view name) const;
  /// Lives as long as the buffer.
  [[nodiscard]] std::string_view name(FrameId frame) const;

  /// `writer`: MessageInfo's, for explain_by(); 0 if the broadcaster is on this machine.
  [[nodiscard]] Result<void, InsertFault> insert(FrameId parent, FrameId child, WallTime stamp,
                                                 const RigidTransform& X_PC, Permanence permanence,
                                                 std::uint64_t writer = 0);
  [[nodiscard]] Result<void, InsertFault> insert(std::string_view parent, std::string_view child, WallTime stamp,
                                                 const RigidTransform& X_PC, Permanence permanence,
                                                 std::uint64_t writer = 0);
  /// From now on, faults about time mention if the clock of the frame's last writer differs. Only the first call counts.
  void explain_by(std::shared_ptr<const ClockSkews> skews);

  /// X_TS at a time; time 0 means lookup_latest(), as in tf2. If target and source are the same frame, returns
  /// the identity at the requested time (0: at the newest sample's), even if the frame is unknown.
  [[nodiscard]] Result<StampedTransform, LookupFault> lookup(FrameId target, FrameId source, WallTime at) const;
  [[nodiscard]] Result<StampedTransform, LookupFault> lookup(std::string_view target, std::string_view source,
                                                             WallTime at) const;
  /// X_TS at the latest time that every frame of the chain has reached.
  [[nodiscard]] Result<StampedTransform, LookupFault> lookup_latest(FrameId target, FrameId source) const;
  [[nodiscard]] Result<StampedTransform, LookupFault> lookup_latest(std::string_view target,
                                                                    std::string_view source) const;

  /// X_TS between two times, through a frame that is fixed meanwhile: the pose of the source at source_time, relative to the target
  /// at target_time. The stamp of the result is that of the target's part.
  [[nodiscard]] Result<StampedTransform, LookupFault> lookup(std::string_view target, WallTime target_time,
                                                             std::string_view source, WallTime source_time,
                                                             std::string_view fixed) const;

  /// The same, but blocks the calling thread until the transform is available, at most for `timeout`; then the fault names what is
  /// missing. A thread that feeds the buffer would wait for itself, so it gets the fault (`would_starve`) at once.
  [[nodiscard]] Result<StampedTransform, LookupFault> lookup(std::string_view target, std::string_view source,
                                                             WallTime at, Duration timeout) const;
  [[nodiscard]] Result<StampedTransform, LookupFault> lookup(std::string_view target, WallTime target_time,
                                                             std::string_view source, WallTime source_time,
                                                             std::string_view fixed, Duration timeout) const;

  /// Is called at each insert, on the inserting thread and with the buffer's lock held: only set a flag and return.
  class Listener {
   public:
    virtual void on_insert() noexcept = 0;

   protected:
    ~Listener() = default;
  };
  /// Lookups that wait without a thread: nacelle/node/transform_waits.hpp. Not from a listener.
  void add_listener(Listener& listener);
  void remove_listener(Listener& listener);

  /// Every frame that has a parent, sorted by child. Allocates: the answer.
  [[nodiscard]] std::vector<FrameInfo> frames() const;
  [[nodiscard]] TransformBufferStats stats() const;
  /// Forgets every sample, not the names.
  void clear();
  /// Forgets the samples of moving frames: when the wall clock was set back, they lie in the future.
  void forget_moving();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

using TransformBufferPtr = std::shared_ptr<TransformBuffer>;

/// Makes a buffer that plugins may share: its control block lives here, in a library that is never unloaded. One made in a
/// plugin would dangle after dlclose.
[[nodiscard]] TransformBufferPtr make_transform_buffer(const TransformBufferOptions& options = {});

/// For Node::shared_object(): the buffer of a container, by this name, made by this function with default options.
inline constexpr const char* kTransformBufferName = "transform_buffer";
[[nodiscard]] std::shared_ptr<void> make_shared_transform_buffer();

}  // namespace nacelle::spatial
