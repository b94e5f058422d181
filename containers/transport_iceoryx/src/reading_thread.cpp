// SPDX-License-Identifier: Apache-2.0
#include "reading_thread.hpp"

#include <pthread.h>

#include <algorithm>
#include <csignal>

#include "nacelle/base/log.hpp"

namespace nacelle::transport_iceoryx {

ReadingThread::ReadingThread(iox::popo::ConditionVariableData& condition) : condition_(condition) {
  sigset_t all, before;
  sigfillset(&all);
  pthread_sigmask(SIG_SETMASK, &all, &before);
  thread_ = std::thread([this] { run(); });
  pthread_sigmask(SIG_SETMASK, &before, nullptr);
}

ReadingThread::~ReadingThread() {
  ends_.store(true, std::memory_order_release);
  static_cast<void>(condition_.m_semaphore.post());
  thread_.join();
  condition_.m_toBeDestroyed.store(true, std::memory_order_relaxed);
}

std::optional<std::size_t> ReadingThread::add(const std::shared_ptr<StreamReader>& reader) {
  const LockGuard lock(mutex_);
  const auto free = std::find(readers_.begin(), readers_.end(), nullptr);
  if (free == readers_.end()) return std::nullopt;
  *free = reader;
  const auto place = static_cast<std::size_t>(free - readers_.begin());
  places_.store(std::max(place + 1, places_.load(std::memory_order_relaxed)), std::memory_order_release);
  return place;
}

void ReadingThread::remove(std::size_t place) {
  const LockGuard lock(mutex_);
  readers_[place].reset();
}

void ReadingThread::run() {
  pthread_setname_np(pthread_self(), "iceoryx_reader");
  while (!ends_.load(std::memory_order_acquire)) {
    if (condition_.m_semaphore.wait().has_error()) {
      Logger("transport_iceoryx").error("waiting for messages failed: this process gets no more through shared memory");
      return;
    }
    const std::size_t places = places_.load(std::memory_order_acquire);
    for (std::size_t place = 0; place < places; ++place) look_at(place);
  }
}

void ReadingThread::look_at(std::size_t place) {
  std::atomic_bool& flag = condition_.m_activeNotifications[place];
  // Cleared before reading, so that a chunk that arrives meanwhile sets the flag again. The exchange synchronises with the last sender
  // that has set it, and so with that sender's chunk.
  if (!flag.load(std::memory_order_relaxed) || !flag.exchange(false, std::memory_order_acq_rel)) return;
  std::shared_ptr<StreamReader> reader;
  {
    const LockGuard lock(mutex_);
    reader = readers_[place];
  }
  if (reader) reader->deliver();
}

}  // namespace nacelle::transport_iceoryx
