// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
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
/// What was written is on its way to the disk at once, so that a sync has little to wait for.
/// The first failed write or sync is the end: what is queued then, and later, is dropped.
/// Threads: the functions are called by one; room() and problem() by any. Allocates: for buffers until there are as many as waited at once. When all is on the disk
/// and nothing comes, few stay.
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
  /// Queues the buffer's bytes, and gives another buffer for them, of the same size or more. Nothing is copied. Returns false after a failure.
  [[nodiscard]] bool hand_over(const std::shared_ptr<FileSink>& file, ByteBuffer& buffer);
  /// Waits until so many bytes more may wait, or a write has failed. More than may wait at all: until none wait.
  void await_room(std::size_t bytes) const;
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
    ByteBuffer bytes;
    bool closes = false;
  };
  bool push(const std::shared_ptr<FileSink>& file, ByteBuffer& buffer);
  [[nodiscard]] ByteBuffer spare(std::size_t capacity);
  void run();
  void run_job(Job& job);
  void finish_job(Job& job) NACELLE_REQUIRES(mutex_);
  void sync(FileSink& file);
  void note(const FileSink& file);

  const std::size_t most_bytes_;
  mutable Mutex mutex_;
  mutable std::condition_variable changed_;
  std::vector<Job> jobs_ NACELLE_GUARDED_BY(mutex_);
  std::vector<ByteBuffer> spare_ NACELLE_GUARDED_BY(mutex_);
  std::atomic<std::size_t> waiting_{0};  // changed with the mutex
  bool is_busy_ NACELLE_GUARDED_BY(mutex_) = false, is_ending_ NACELLE_GUARDED_BY(mutex_) = false;
  std::optional<Problem> problem_ NACELLE_GUARDED_BY(mutex_);
  std::atomic<std::uint64_t> free_bytes_;
  std::vector<Job> jobs_now_;  // the thread's own
  std::shared_ptr<FileSink> unsynced_;
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
  [[nodiscard]] bool hand_over(ByteBuffer& buffer) override { return queue_.hand_over(file_, buffer); }

 private:
  DiskQueue& queue_;
  std::shared_ptr<FileSink> file_;
};

}  // namespace nacelle::record
