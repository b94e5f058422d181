// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>

#include "nacelle/base/problem.hpp"
#include "nacelle/base/result.hpp"
#include "nacelle/base/time.hpp"
#include "nacelle/transport_local/carrier.hpp"

namespace nacelle::transport_iceoryx {

/// Totals of all readers of a carrier.
struct ReadingCounters {
  std::uint64_t lent = 0;  ///< Long sequences that were read in place.
  /// Bytes of long sequences that were copied: the reader held too many chunks, or CarrierSink::may_lend() was false.
  std::uint64_t bytes_copied = 0;
  std::uint64_t broken = 0;    ///< Chunks that did not contain a message of the stream's type.
  std::uint64_t overruns = 0;  ///< How often a reader found that its full queue had dropped messages.
};

/// Transfers streams through the shared memory of iceoryx. Requires its daemon, iox-roudi, on the same host.
///
/// A message is encoded into a chunk, except for its long sequences: those of numbers with 4 KiB or more
/// (nacelle/msgs/cdr_apart.hpp). These lie in the chunk as in memory. If the message was prepared
/// (CarrierWriter::prepare) and has no other owner when it is sent, the component has written them there itself;
/// otherwise send() copies them once. Readers read them in place, through a Buffer that returns the chunk when the
/// message is released.
///
/// If no daemon runs, start() fails at once. If the daemon ends later, the loss is logged once and is_alive() returns
/// false until this process is restarted: a new daemon does not know this process. From then on writers answer
/// Sent::Dead, and new writers and readers are refused. Readers still deliver what has been sent.
///
/// Limits of Debian's build: 512 writers and 1,024 readers on the host, 256 readers per process, a depth of 256, and
/// messages up to the daemon's largest chunk. A request beyond a limit is refused, and the reason is logged.
/// Threads: any. One thread per process serves the daemon. One thread per carrier waits for messages, from the first
/// reader on.
/// Ownership: writers and readers must be destroyed before the carrier.
class IceoryxCarrier final : public Carrier {
 public:
  /// Connects to the daemon, or reuses the connection of this process. Errors: no daemon runs; this user may not use
  /// it; it has not answered within `patience`; it has ended since this process connected.
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
