// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <string>

#include "nacelle/base/bytes.hpp"
#include "nacelle/runtime/crash_record.hpp"

namespace nacelle::runtime {

/// The data about a component that a signal handler can read: its identity, and the bytes that stop its hardware.
/// Entries are fixed memory that is recycled but never freed, linked into one list of the process, so that a handler
/// can read it at any time without a lock.
struct CrashEntry {
  std::atomic<bool> in_use{true};
  CrashEntry* next = nullptr;
  std::array<char, 128> node{};
  std::array<char, 256> image{};  // the library's path, as the linker has it
  std::atomic<int> descriptor{-1};
  std::size_t length = 0;
  std::size_t bytes_a_write = 0;  // a CAN socket takes one frame a write, and refuses more; 0: all in one
  std::array<std::uint8_t, 64> frame{};
  std::size_t number = kNoNumber;  // of its copy for the watcher (stop_watcher.hpp), from the first frame on
  /// Monotonic nanoseconds of the load, or of the last activation.
  std::atomic<std::int64_t> up_since_ns{0};
  std::atomic<bool> was_activated{false};
  static constexpr std::size_t kNoNumber = ~std::size_t{0};
};

/// Returns the first entry, or null. Async-signal-safe, like everything here that only reads.
[[nodiscard]] const CrashEntry* first_crash_entry() noexcept;
/// Writes a stop frame in pieces of so many bytes (0: in one). A piece that is refused does not keep the others, which may be another
/// wheel's, from being written. Returns whether all were. Async-signal-safe.
[[nodiscard]] bool write_stop(int descriptor, ByteView frame, std::size_t bytes_a_write) noexcept;
/// Copies the registered frames to a watcher that has just been started.
void mirror_safe_stops() noexcept;

/// A component's entry, from its host's construction to its destruction. Threads: one, but write() from any.
class SafeStop {
 public:
  explicit SafeStop(const std::string& node);
  ~SafeStop();
  SafeStop(const SafeStop&) = delete;
  SafeStop& operator=(const SafeStop&) = delete;

  void set_image(const std::string& image);
  /// Records that the component becomes active now, for the age in a crash record.
  void note_activation();
  /// A frame for a descriptor; in place of an earlier one for the same. Precondition: at most kMost descriptors until clear().
  /// `bytes_a_write` 0: the descriptor tells, 16 for a CAN socket (a struct can_frame), else all in one write.
  void set(int descriptor, ByteView frame, std::size_t bytes_a_write = 0);
  /// Forgets all of them.
  void clear();
  /// Makes one attempt: the line is non-blocking, and the caller could not report a failure.
  void write() const noexcept;
  /// Returns whether it has ever had a frame to write, so the component moves something.
  [[nodiscard]] bool was_ever_set() const { return was_set_.load(std::memory_order_relaxed); }

  static constexpr std::size_t kMost = 4;

 private:
  /// Where the frame for this descriptor is, or is to be.
  CrashEntry& entry_for(int descriptor);

  CrashEntry& entry_;
  // Of the second descriptor and those that follow it, made when they are first needed. They have no names: a crash record names the component once.
  std::array<std::atomic<CrashEntry*>, kMost - 1> further_{};
  std::atomic<bool> was_set_{false};
};

}  // namespace nacelle::runtime
