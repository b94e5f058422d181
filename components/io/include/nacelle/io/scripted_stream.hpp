// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <condition_variable>
#include <cstddef>
#include <deque>
#include <functional>
#include <optional>
#include <vector>

#include "nacelle/base/mutex.hpp"
#include "nacelle/io/byte_stream.hpp"

namespace nacelle::io {

/// A line whose bytes, times and faults are written down beforehand: the port that tests use.
///
/// Time is the test's: `wait` is called with the time at which a read would have ended, and usually moves a manual
/// clock. Nothing here sleeps. Threads: as ByteStream; append() and written() from any thread. Allocates: yes.
class ScriptedStream final : public ByteStream {
 public:
  /// One thing that happens on the line.
  struct Step {
    MonotonicTime at{};                  ///< When the bytes are there.
    Bytes bytes;                         ///< One chunk, handed over in one read.
    std::optional<StreamFault> fault{};  ///< Instead of bytes; the line stays broken until reopen().
  };
  /// What a read finds when the script is over.
  enum class AtEnd : std::uint8_t {
    Silence,  ///< Nothing comes: every read ends at its deadline.
    Blocks,   ///< Reads ignore their deadline and wait for append() or interrupt(): for tests with a reading thread.
    HangsUp   ///< The other end is closed.
  };
  using Wait = std::function<void(MonotonicTime until)>;

  explicit ScriptedStream(std::vector<Step> script, AtEnd at_end = AtEnd::Silence, Wait wait = {});

  [[nodiscard]] Result<ByteView, StreamFault> read_until(MonotonicTime deadline) override;
  [[nodiscard]] Result<void, StreamFault> write(ByteView bytes) override;
  [[nodiscard]] std::size_t unsent() const noexcept override;
  void drop_unsent() noexcept override;
  [[nodiscard]] Result<void, StreamFault> set_data_terminal_ready(bool ready) override;
  void interrupt() noexcept override;
  [[nodiscard]] Result<void, StreamFault> reopen() override;
  [[nodiscard]] bool is_away() const noexcept override;
  [[nodiscard]] int descriptor() const noexcept override { return -1; }

  /// The device is not there yet: everything fails with NotFound until a reopen() that is not refused. Before reading starts.
  void start_away();

  /// Adds a step to the end of the script.
  void append(Step step);
  /// Waits until a reading thread has taken the whole script and waits for more. Only with AtEnd::Blocks.
  void wait_until_read();
  /// Lets the next reopen() calls fail this often with NotFound.
  void refuse_reopen(std::size_t times);
  /// Makes every write fail from now on; std::nullopt makes writes succeed again.
  void fail_writes(std::optional<StreamFault> fault);
  /// If true, written bytes wait in the line's queue (unsent()) from now on. False sends them, and later ones at once.
  void hold_writes(bool hold);
  /// Returns all bytes written so far, in order, without waiting or dropped ones.
  [[nodiscard]] Bytes written() const;
  /// Returns what DTR was set to last, if it was.
  [[nodiscard]] std::optional<bool> data_terminal_ready() const;
  /// Answers a write: called with the bytes, returns what the device sends back at once. Set before reading starts.
  void answer_writes(std::function<Bytes(ByteView)> device);

 private:
  mutable Mutex mutex_;
  std::condition_variable changed_;
  std::deque<Step> script_ NACELLE_GUARDED_BY(mutex_);
  AtEnd at_end_ NACELLE_GUARDED_BY(mutex_);
  Wait wait_ NACELLE_GUARDED_BY(mutex_);
  std::function<Bytes(ByteView)> device_ NACELLE_GUARDED_BY(mutex_);
  Bytes current_ NACELLE_GUARDED_BY(mutex_);
  Bytes written_ NACELLE_GUARDED_BY(mutex_);
  Bytes unsent_ NACELLE_GUARDED_BY(mutex_);
  std::optional<bool> data_terminal_ready_ NACELLE_GUARDED_BY(mutex_);
  bool holds_writes_ NACELLE_GUARDED_BY(mutex_) = false;
  std::optional<StreamFault> broken_ NACELLE_GUARDED_BY(mutex_);
  std::optional<StreamFault> write_fault_ NACELLE_GUARDED_BY(mutex_);
  std::size_t refusals_ NACELLE_GUARDED_BY(mutex_) = 0;
  bool away_ NACELLE_GUARDED_BY(mutex_) = false;
  bool interrupted_ NACELLE_GUARDED_BY(mutex_) = false;
  bool reader_waits_ NACELLE_GUARDED_BY(mutex_) = false;
};

}  // namespace nacelle::io
