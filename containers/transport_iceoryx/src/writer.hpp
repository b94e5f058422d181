// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstdint>
#include <string>

#include "daemon.hpp"
#include "nacelle/base/guarded.hpp"
#include "nacelle/transport_local/carrier.hpp"
#include "transport_iceoryx/wire/chunk.hpp"
#include "writer_port.hpp"

namespace nacelle::transport_iceoryx {

/// Sends the messages of one stream as chunks. Threads: as CarrierWriter.
class StreamWriter final : public CarrierWriter {
 public:
  StreamWriter(WriterPort& port, const Daemon& daemon, const CarriedStream& stream)
      : port_(port), daemon_(daemon), type_(*stream.type), name_(stream.name) {}
  ~StreamWriter() override { port_.close(); }
  StreamWriter(const StreamWriter&) = delete;
  StreamWriter& operator=(const StreamWriter&) = delete;

  Sent send(const Block& block) override;
  bool is_connected() const override { return daemon_.is_alive() && port_.has_readers(); }
  std::uint64_t bytes_copied() const override { return bytes_copied_.load(std::memory_order_relaxed); }
  void prepare(Block& block) override;

 private:
  bool send_in_place(const Block& block, const Stamp& stamp, std::size_t small_bytes, const msgs::PartList& parts);
  Sent send_copy(const Block& block, const Stamp& stamp, std::size_t small_bytes, const msgs::PartList& parts);
  void remember(std::size_t small_bytes, const msgs::PartList& parts);
  Sent refuse(const char* why, std::size_t bytes);

  // The long sequences of the last message with any, and their lengths: prepare() expects the same of the next message.
  struct Layout {
    std::size_t small_bytes = 0;
    msgs::PartList parts;
  };
  WriterPort& port_;
  const Daemon& daemon_;
  const msgs::MessageType& type_;
  const std::string name_;
  std::atomic<std::uint64_t> bytes_copied_{0};
  Guarded<Layout> last_;  // send() and prepare() may run on two threads
  bool refused_ = false;
};

}  // namespace nacelle::transport_iceoryx
