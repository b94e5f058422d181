// SPDX-License-Identifier: Apache-2.0
#include "record/component/snapshot_thread.hpp"

#include <pthread.h>
#include <sys/resource.h>
#include <unistd.h>

#include <utility>

namespace nacelle::record {
namespace {

constexpr int kNice = 10;  // the robot's threads come first

}  // namespace

SnapshotThread::SnapshotThread() : thread_([this] { run(); }) {}

SnapshotThread::~SnapshotThread() {
  {
    const LockGuard lock{mutex_};
    is_ending_ = true;
  }
  changed_.notify_all();
  thread_.join();
}

void SnapshotThread::write(SnapshotWish wish, Ring::Files files, Done done) {
  add({std::move(wish), std::move(files), nullptr, std::move(done)});
}

void SnapshotThread::write(SnapshotWish wish, std::shared_ptr<RingFolder> left, Done done) {
  add({std::move(wish), {}, std::move(left), std::move(done)});
}

void SnapshotThread::add(Job job) {
  {
    const LockGuard lock{mutex_};
    jobs_.push_back(std::move(job));
  }
  changed_.notify_all();
}

void SnapshotThread::run_job(Job job) {
  job.wish.files.clear();
  for (const auto& file : job.files) job.wish.files.push_back(file->path());
  if (job.left) job.wish.files = job.left->files();
  const auto written = write_snapshot(job.wish);
  if (written && job.left) job.left->clear();
  job.done(written);
}

void SnapshotThread::run() {
  ::pthread_setname_np(::pthread_self(), "record_snapshot");
  ::setpriority(PRIO_PROCESS, static_cast<id_t>(::gettid()), kNice);
  UniqueLock lock{mutex_};
  for (;;) {
    changed_.wait(lock.raw(), [this]() NACELLE_REQUIRES(mutex_) { return !jobs_.empty() || is_ending_; });
    if (jobs_.empty()) return;
    Job job = std::move(jobs_.front());
    jobs_.pop_front();
    lock.unlock();
    run_job(std::move(job));
    lock.lock();
  }
}

}  // namespace nacelle::record
