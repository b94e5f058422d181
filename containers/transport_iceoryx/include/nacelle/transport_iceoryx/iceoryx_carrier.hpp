// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>

#include "nacelle/base/problem.hpp"
#include "nacelle/base/result.hpp"
#include "nacelle/base/time.hpp"
#include "nacelle/transport_local/carrier.hpp"

namespace nacelle::transport_iceoryx {

/// How often a process's readers kept a message where the writer had put it, and how often they could not.
struct ReadingCounters {
  std::uint64_t lent = 0;  ///< Long sequences read in shared memory.
  std::uint64_t bytes_copied =
      0;                       ///< Of long sequences that were copied: too many held already, or the sink asked for it.
  std::uint64_t broken = 0;    ///< Chunks that were no message of the stream's type.
  std::uint64_t overruns = 0;  ///< Times that a reader's queue was found to have overwritten messages.
};

/// Moves streams through the shared memory of iceoryx (its own C++ API), where its daemon iox-roudi runs.
///
/// A message of up to 4 KiB of numbers is encoded into a chunk and decoded from it. A longer sequence lies in the chunk
/// as it is: the component writes it there if the message was prepared (CarrierWriter::prepare) and has no other owner
/// when it is sent; otherwise it is copied there once. Readers read it in place, through a Buffer that returns the
/// chunk with the message's release.
///
/// The daemon is a process of its own. Without it start() is a Problem, at once. When it ends, what is connected still moves,
/// but nothing new can be made and a daemon that is started later knows nothing of this process: is_alive() is false for
/// good, and says so once.
///
/// Limits of Debian's build: 512 writers and 1,024 readers on the host, 256 readers per process, a depth of 256, and messages up to
/// the daemon's largest chunk. What is beyond them is refused with its reason in the log; nothing aborts.
/// Threads: any. One thread of its own waits for messages, once there is a reader; one per process waits for the daemon's end.
/// Ownership: writers and readers must go before the carrier.
class IceoryxCarrier final : public Carrier {
 public:
  /// Errors: no daemon, no permission, or none that answers within `patience`; the way out says which.
  [[nodiscard]] static Result<std::unique_ptr<IceoryxCarrier>, Problem> start(
      Duration patience = std::chrono::seconds(3));
  ~IceoryxCarrier() override;

  [[nodiscard]] const char* name() const override { return "iceoryx"; }
  [[nodiscard]] bool is_alive() const override;
  [[nodiscard]] std::unique_ptr<CarrierWriter> create_writer(const CarriedStream& stream) override;
  [[nodiscard]] std::unique_ptr<CarrierReader> create_reader(const CarriedStream& stream, CarrierSink& sink) override;
  [[nodiscard]] ReadingCounters reading() const;

 private:
  class Impl;
  explicit IceoryxCarrier(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace nacelle::transport_iceoryx
