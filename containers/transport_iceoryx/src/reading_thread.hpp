// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>

#include "iceoryx_posh/internal/popo/building_blocks/condition_listener.hpp"
#include "reader.hpp"

namespace nacelle::transport_iceoryx {

/// Sleeps until a chunk arrives for one of its readers, and has it delivered. What iceoryx's Listener does, but that it is made
/// of ports that are checked (Listener uses a null pointer when the daemon has no more to give), and without a lock per event
/// that is held while a callback runs.
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

  iox::popo::ConditionVariableData& condition_;
  iox::popo::ConditionListener listener_;
  std::mutex mutex_;
  std::array<std::shared_ptr<StreamReader>, kMostReaders> readers_;
  std::thread thread_;
};

}  // namespace nacelle::transport_iceoryx
