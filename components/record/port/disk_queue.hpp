// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <thread>
#include <vector>

#include "nacelle/base/bytes.hpp"
#include "nacelle/base/mutex.hpp"
#include "nacelle/base/problem.hpp"
#include "record/model/byte_file.hpp"
#include "record/port/recording_file.hpp"

namespace nacelle::record {

/// Writes files on a thread of its own, so that its callers do not wait for a slow disk, and syncs the files once a second.
///
/// The first failed write or sync is the end: what is queued then, and later, is dropped.
/// Threads: the functions are called by one; room() and problem() by any. Allocates: for buffers until there are enough of them.
class DiskQueue {
 public:
  /// `most_bytes`: how many may wait.
  explicit DiskQueue(std::size_t most_bytes);
  /// Writes what waits, then ends.
  ~DiskQueue();
  DiskQueue(const DiskQueue&) = delete;
  DiskQueue& operator=(const DiskQueue&) = delete;

  /// Queues a copy of the bytes. Returns false after a failure. A caller may queue more than room() says, to complete a file.
  [[nodiscard]] bool write(const std::shared_ptr<FileSink>& file, ByteView bytes);
  /// Queues the end of the file: the thread syncs it and gives its reference back, which closes a file without other references.
  void close(std::shared_ptr<FileSink> file);
  /// Waits until all that was queued is on the disk, or has failed.
  void drain();
  /// Returns how many bytes more may wait.
  [[nodiscard]] std::size_t room() const;
  /// Returns what failed first.
  [[nodiscard]] std::optional<Problem> problem() const;
  /// Returns the bytes that the disk had free after the last write to it, less those that wait; a lot before the first one.
  [[nodiscard]] std::uint64_t free_bytes() const;

 private:
  struct Job {
    std::shared_ptr<FileSink> file;
    Bytes bytes;
    bool closes = false;
  };
  void run();
  void run_job(Job& job);
  void sync(FileSink& file);
  void note(const FileSink& file);

  const std::size_t most_bytes_;
  mutable Mutex mutex_;
  mutable std::condition_variable changed_;
  std::deque<Job> jobs_ NACELLE_GUARDED_BY(mutex_);
  std::vector<Bytes> spare_ NACELLE_GUARDED_BY(mutex_);
  std::size_t waiting_ NACELLE_GUARDED_BY(mutex_) = 0;
  bool is_busy_ NACELLE_GUARDED_BY(mutex_) = false, is_ending_ NACELLE_GUARDED_BY(mutex_) = false;
  std::optional<Problem> problem_ NACELLE_GUARDED_BY(mutex_);
  std::atomic<std::uint64_t> free_bytes_;
  std::shared_ptr<FileSink> unsynced_;  // the thread's own
  MonotonicTime sync_at_{}, synced_{};
  const SystemClock clock_;
  std::thread thread_;  // last: it starts when everything above is there
};

/// A file behind a DiskQueue.
class QueuedFile final : public ByteSink {
 public:
  QueuedFile(DiskQueue& queue, std::shared_ptr<FileSink> file) : queue_(queue), file_(std::move(file)) {}
  ~QueuedFile() override { queue_.close(std::move(file_)); }
  [[nodiscard]] bool write(ByteView bytes) override { return queue_.write(file_, bytes); }

 private:
  DiskQueue& queue_;
  std::shared_ptr<FileSink> file_;
};

}  // namespace nacelle::record
