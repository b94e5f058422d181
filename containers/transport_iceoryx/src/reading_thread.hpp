// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <atomic>
#include <memory>
#include <optional>
#include <thread>

#include "iceoryx_posh/internal/popo/building_blocks/condition_variable_data.hpp"
#include "nacelle/base/mutex.hpp"
#include "reader.hpp"

namespace nacelle::transport_iceoryx {

/// Sleeps until a chunk arrives for one of its readers, and has it delivered.
///
/// What iceoryx's Listener does, but that it is made of parts that have been checked (Listener uses a null pointer when the daemon has
/// no more to give), holds no lock while a reader is called, and looks at the flags of its own readers only, not at all 256
/// (3,900 of the 11,400 instructions that a message costs with a Listener, as callgrind counts them).
/// The protocol is iceoryx's: a sender sets the reader's flag, then posts the semaphore. So a flag that is set behind the look has a
/// post to come.
/// Threads: any; its own calls the readers.
class ReadingThread {
 public:
  static constexpr std::size_t kMostReaders = iox::MAX_NUMBER_OF_NOTIFIERS;

  explicit ReadingThread(iox::popo::ConditionVariableData& condition);
  ReadingThread(const ReadingThread&) = delete;
  ReadingThread& operator=(const ReadingThread&) = delete;
  ~ReadingThread();

  /// The reader's place; nothing when all are taken.
  [[nodiscard]] std::optional<std::size_t> add(const std::shared_ptr<StreamReader>& reader);
  void remove(std::size_t place);
  [[nodiscard]] iox::popo::ConditionVariableData& condition() { return condition_; }

 private:
  void run();
  void look_at(std::size_t place);

  iox::popo::ConditionVariableData& condition_;
  std::atomic<bool> ends_{false};
  std::atomic<std::size_t> places_{0};  // the highest that was ever taken, and one
  Mutex mutex_;
  std::array<std::shared_ptr<StreamReader>, kMostReaders> readers_ NACELLE_GUARDED_BY(mutex_);
  std::thread thread_;
};

}  // namespace nacelle::transport_iceoryx
