// SPDX-License-Identifier: Apache-2.0
#include "record/port/disk_queue.hpp"

#include <pthread.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <iterator>
#include <limits>
#include <utility>

namespace nacelle::record {
namespace {

constexpr Duration kSyncEvery = 750ms;  // with a chunk of 1 s and the disk's own time, less than 2 s are lost
constexpr std::size_t kMostSpare = 4;
constexpr std::size_t kLeastSpare = std::size_t{16} << 10U;  // smaller ones are those of a file's head and end
constexpr int kNice = 10;                                    // the robot's threads come first

}  // namespace

DiskQueue::DiskQueue(std::size_t most_bytes)
    : most_bytes_(most_bytes), free_bytes_(std::numeric_limits<std::uint64_t>::max()), thread_([this] { run(); }) {}

DiskQueue::~DiskQueue() {
  {
    const LockGuard lock{mutex_};
    is_ending_ = true;
  }
  changed_.notify_all();
  thread_.join();
}

ByteBuffer DiskQueue::spare(std::size_t capacity) {
  const LockGuard lock{mutex_};
  // The one that was used last is in the processor's cache.
  const auto found =
      std::find_if(spare_.rbegin(), spare_.rend(), [&](const ByteBuffer& one) { return one.capacity() >= capacity; });
  if (found == spare_.rend()) return ByteBuffer{capacity};
  ByteBuffer taken = std::move(*found);
  spare_.erase(std::next(found).base());
  return taken;
}

bool DiskQueue::push(const std::shared_ptr<FileSink>& file, ByteBuffer& buffer) {
  {
    const LockGuard lock{mutex_};
    if (problem_) return false;
    waiting_ += buffer.size();
    jobs_.push_back({file, std::move(buffer), false});
  }
  changed_.notify_all();
  return true;
}

bool DiskQueue::write(const std::shared_ptr<FileSink>& file, ByteView bytes) {
  ByteBuffer copy = spare(bytes.size());
  copy.append(bytes);
  return push(file, copy);
}

bool DiskQueue::hand_over(const std::shared_ptr<FileSink>& file, ByteBuffer& buffer) {
  ByteBuffer next = spare(buffer.capacity());
  const bool is_queued = push(file, buffer);
  buffer = std::move(next);
  return is_queued;
}

void DiskQueue::await_room(std::size_t bytes) const {
  if (room() >= bytes) return;
  UniqueLock lock{mutex_};
  const std::size_t most = most_bytes_ - std::min(most_bytes_, bytes);
  changed_.wait(lock.raw(), [this, most]() NACELLE_REQUIRES(mutex_) { return waiting_ <= most || problem_; });
}

void DiskQueue::close(std::shared_ptr<FileSink> file) {
  {
    const LockGuard lock{mutex_};
    jobs_.push_back({std::move(file), {}, true});
  }
  changed_.notify_all();
}

void DiskQueue::drain() {
  UniqueLock lock{mutex_};
  changed_.wait(lock.raw(), [this]() NACELLE_REQUIRES(mutex_) { return jobs_.empty() && !is_busy_; });
}

std::size_t DiskQueue::room() const { return most_bytes_ - std::min<std::size_t>(most_bytes_, waiting_); }

std::optional<Problem> DiskQueue::problem() const {
  const LockGuard lock{mutex_};
  return problem_;
}

std::uint64_t DiskQueue::free_bytes() const {
  const std::uint64_t free = free_bytes_;
  return free - std::min<std::uint64_t>(free, waiting_);
}

void DiskQueue::note(const FileSink& file) {
  const LockGuard lock{mutex_};
  if (!problem_) problem_ = file.problem();
}

void DiskQueue::sync(FileSink& file) {
  if (!file.sync()) note(file);
  if (unsynced_.get() == &file) unsynced_.reset();
  synced_ = clock_.now();
}

void DiskQueue::run_job(Job& job) {
  if (job.bytes.size() > 0) {
    if (!job.file->write(std::as_const(job.bytes).bytes())) return note(*job.file);
    job.file->start_writeback();
    // What comes after a pause goes to the disk at once.
    if (!unsynced_) sync_at_ = std::max(clock_.now(), synced_ + kSyncEvery);
    unsynced_ = job.file;
    free_bytes_ = job.file->free_bytes();
  }
  if (job.closes) sync(*job.file);
  if (unsynced_ && clock_.now() >= sync_at_) sync(*std::shared_ptr{unsynced_});
}

/// Keeps its buffer for the next one.
void DiskQueue::finish_job(Job& job) {
  if (job.bytes.capacity() == 0) return;
  waiting_ -= job.bytes.size();
  if (job.bytes.capacity() < kLeastSpare) return;
  job.bytes.clear();
  spare_.push_back(std::move(job.bytes));
}

void DiskQueue::run() {
  ::pthread_setname_np(::pthread_self(), "record_disk");
  ::setpriority(PRIO_PROCESS, static_cast<id_t>(::gettid()), kNice);
  const auto has_work = [this]() NACELLE_REQUIRES(mutex_) { return !jobs_.empty() || is_ending_; };
  UniqueLock lock{mutex_};
  for (;;) {
    if (unsynced_) {
      const Duration left = std::max(sync_at_ - clock_.now(), Duration::zero());
      if (!changed_.wait_for(lock.raw(), left, has_work)) {
        lock.unlock();
        sync(*std::shared_ptr{unsynced_});
        lock.lock();
        continue;
      }
    } else {
      if (jobs_.empty() && spare_.size() > kMostSpare) spare_.resize(kMostSpare);
      changed_.wait(lock.raw(), has_work);
    }
    if (jobs_.empty()) break;
    std::swap(jobs_, jobs_now_);
    is_busy_ = true;
    for (Job& job : jobs_now_) {
      const bool has_failed = problem_.has_value();
      lock.unlock();
      if (!has_failed) run_job(job);
      job.file.reset();  // closing a file may take its time
      lock.lock();
      finish_job(job);
      changed_.notify_all();
    }
    jobs_now_.clear();
    is_busy_ = false;
    changed_.notify_all();
  }
  lock.unlock();
  if (unsynced_) sync(*std::shared_ptr{unsynced_});
}

}  // namespace nacelle::record
