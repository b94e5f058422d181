// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <condition_variable>
#include <deque>
#include <functional>
#include <memory>
#include <thread>

#include "nacelle/base/mutex.hpp"
#include "record/component/ring.hpp"
#include "record/component/snapshot.hpp"

namespace nacelle::record {

/// Writes snapshots one after the other, on a thread of its own, so that neither the robot nor the recorder waits for the disk.
///
/// Threads: any.
class SnapshotThread {
 public:
  using Done = std::function<void(const Result<Snapshot, Problem>&)>;
  SnapshotThread();
  /// Writes what is queued, then ends.
  ~SnapshotThread();
  SnapshotThread(const SnapshotThread&) = delete;
  SnapshotThread& operator=(const SnapshotThread&) = delete;

  /// Queues a snapshot of these files, which it holds until it is written; wish.files is not read. `done` is called on the thread.
  void write(SnapshotWish wish, Ring::Files files, Done done);
  /// Queues one of a folder that a killed process left, and removes the folder's files when it is written.
  void write(SnapshotWish wish, std::shared_ptr<RingFolder> left, Done done);

 private:
  struct Job {
    SnapshotWish wish;
    Ring::Files files;
    std::shared_ptr<RingFolder> left;
    Done done;
  };
  void add(Job job);
  void run();
  static void run_job(Job job);

  Mutex mutex_;
  std::condition_variable changed_;
  std::deque<Job> jobs_ NACELLE_GUARDED_BY(mutex_);
  bool is_ending_ NACELLE_GUARDED_BY(mutex_) = false;
  std::thread thread_;  // last: it starts when everything above is there
};

}  // namespace nacelle::record
