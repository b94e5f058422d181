// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <condition_variable>
#include <cstdint>
#include <functional>
#include <string>
#include <thread>

#include "nacelle/base/guarded.hpp"
#include "nacelle/base/mutex.hpp"
#include "nacelle/io/backoff.hpp"
#include "nacelle/io/byte_stream.hpp"
#include "nacelle/io/line_signature.hpp"

namespace nacelle::io {

/// Takes what a ReaderThread reads. Threads: every call comes from the reading thread.
class ByteSink {
 public:
  ByteSink() = default;
  ByteSink(const ByteSink&) = delete;
  ByteSink& operator=(const ByteSink&) = delete;
  virtual ~ByteSink() = default;

  /// Bytes came; `received` was read from the clock right after the kernel handed them over.
  virtual void on_bytes(ByteView bytes, MonotonicTime received) = 0;
  /// A read ended at its deadline without a byte, or the line is still away: the place to notice silence.
  virtual void on_silence(MonotonicTime now) = 0;
  /// The line broke. Called once per break, before the first attempt to reopen it.
  virtual void on_break(StreamFault fault, MonotonicTime now) = 0;
  /// An attempt to reopen the line failed.
  virtual void on_refusal(StreamFault) {}
  /// Returns until when a read waits, before on_silence() is called: by default `latest`, which is Options::silence from now. A sink that has
  /// something to do sooner returns that time.
  [[nodiscard]] virtual MonotonicTime look_at(MonotonicTime latest) const { return latest; }
  /// Returns false while no usable data arrives: the device may have lost its settings (Options::set_up).
  [[nodiscard]] virtual bool hears() const { return true; }
  /// The line is back. New bytes do not continue a half frame from before.
  virtual void on_return(MonotonicTime now) = 0;
};

/// A thread that reads a byte stream into a sink until it is stopped.
///
/// Threads: make, stop() and destroy from one thread; stats() from any. Allocates: nothing in the reading loop.
class ReaderThread {
 public:
  struct Options {
    std::string name;             ///< Of the thread, as in top and the report; the kernel keeps 15 characters.
    Duration silence = 100ms;     ///< How long a read waits before on_silence(). Must be positive.
    bool reopen = true;           ///< Try to open the line again after a break; false ends the thread.
    Duration first_pause = 50ms;  ///< Before the first attempt; doubles after each failure, until bytes came.
    Duration longest_pause = 1s;
    /// Prepares the device behind a line that was opened again, and again while the sink does not hear it. Null: nothing to do.
    std::function<Result<void, StreamFault>()> set_up{};
    /// The stream or the sink threw: the thread ends after this call, which gets the exception's text and is made on it; a
    /// component calls fault() here. Without it the exception ends the process, as in any thread.
    std::function<void(const std::string& text)> on_exception{};
  };
  struct Stats {
    std::uint64_t bytes{}, chunks{}, silences{};
    std::uint64_t breaks{}, returns{};  ///< breaks == returns, or one more while the line is away
  };

  /// Starts at once. The stream, the clock and the sink outlive this object.
  ReaderThread(ByteStream& stream, const Clock& clock, ByteSink& sink, Options options);
  ReaderThread(const ReaderThread&) = delete;
  ReaderThread& operator=(const ReaderThread&) = delete;
  ~ReaderThread() { stop(); }

  /// Ends the thread and waits for it; no call into the sink comes afterwards. A second call does nothing.
  void stop();
  [[nodiscard]] Stats stats() const { return *stats_.lock(); }
  /// What came first since the start: for why_no_frames(). Threads: any.
  [[nodiscard]] FirstBytes first_bytes() const { return *first_.lock(); }

 private:
  void run();
  void read();
  bool bring_back();
  [[nodiscard]] Result<void, StreamFault> reopen();
  void set_up_again(MonotonicTime now);
  bool pause(Duration length);
  [[nodiscard]] bool stopping() const;

  ByteStream& stream_;
  const Clock& clock_;
  ByteSink& sink_;
  const Options options_;
  Backoff backoff_;
  MonotonicTime next_set_up_{};
  Guarded<Stats> stats_;
  Guarded<FirstBytes> first_;
  mutable Mutex mutex_;
  std::condition_variable stop_asked_;
  bool stop_ NACELLE_GUARDED_BY(mutex_) = false;
  std::thread thread_;  // last: it starts when everything above is there
};

}  // namespace nacelle::io
