// SPDX-License-Identifier: Apache-2.0
#include "reading_thread.hpp"

#include <pthread.h>

#include <algorithm>
#include <csignal>

namespace nacelle::transport_iceoryx {

ReadingThread::ReadingThread(iox::popo::ConditionVariableData& condition) : condition_(condition), listener_(condition) {
  sigset_t all, before;
  sigfillset(&all);
  pthread_sigmask(SIG_SETMASK, &all, &before);
  thread_ = std::thread([this] { run(); });
  pthread_sigmask(SIG_SETMASK, &before, nullptr);
}

ReadingThread::~ReadingThread() {
  listener_.destroy();
  thread_.join();
  condition_.m_toBeDestroyed.store(true, std::memory_order_relaxed);
}

std::optional<std::size_t> ReadingThread::add(const std::shared_ptr<StreamReader>& reader) {
  const std::lock_guard lock(mutex_);
  const auto free = std::find(readers_.begin(), readers_.end(), nullptr);
  if (free == readers_.end()) return std::nullopt;
  *free = reader;
  return static_cast<std::size_t>(free - readers_.begin());
}

void ReadingThread::remove(std::size_t place) {
  const std::lock_guard lock(mutex_);
  readers_[place].reset();
}

void ReadingThread::run() {
  pthread_setname_np(pthread_self(), "iceoryx_reader");
  while (true) {
    const auto notified = listener_.wait();
    if (notified.empty()) return;  // destroy()
    for (const auto place : notified) {
      std::shared_ptr<StreamReader> reader;
      {
        const std::lock_guard lock(mutex_);
        reader = readers_[place];
      }
      if (reader) reader->deliver();
    }
  }
}

}  // namespace nacelle::transport_iceoryx
