// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <deque>
#include <vector>

#include "simulation/model/random.hpp"
#include "simulation/model/serial_device.hpp"

namespace nacelle::lidar {

/// A bad cable and a busy host between a simulated device and a driver: bytes are changed, lost and added, and the rest is read
/// in chunks as a USB bridge and a delayed thread make them. Simulated time; the seed repeats it.
class BadLine {
 public:
  struct Settings {
    double changed = 0.0, lost = 0.0, added = 0.0;  ///< Share of the bytes.
    Duration latency{1ms};                          ///< The bridge hands over what it has after this time, or 62 bytes.
    Duration longest_delay{};                       ///< Of the reading thread, drawn for each chunk.
  };
  BadLine(const Settings& settings, unsigned baud, std::uint64_t seed)
      : settings_(settings), byte_time_(Duration{10'000'000'000LL / baud}), draws_(seed, 77) {}

  /// The device begins to send these bytes at this time.
  void send(Duration at, ByteView bytes) {
    free_at_ = std::max(free_at_, at);
    for (std::uint8_t byte : bytes) {
      free_at_ += byte_time_;
      const double draw = draws_.uniform();
      if (draw < settings_.lost) continue;
      if (draw > 1.0 - settings_.changed)
        byte = static_cast<std::uint8_t>(byte ^ (1U << static_cast<unsigned>(draws_.uniform() * 8)));
      waiting_.push_back({free_at_, byte});
      if (draw < settings_.lost + settings_.added)
        waiting_.push_back({free_at_, static_cast<std::uint8_t>(draws_.uniform() * 256)});
    }
  }
  /// Calls `read(ByteView, Duration received)` for each chunk that the host reads until `now`.
  template <typename Read>
  void deliver(Duration now, Read&& read) {
    for (;;) {
      if (chunk_.empty()) {
        if (waiting_.empty()) return;
        const Duration first = waiting_.front().at;
        std::size_t count = 1;
        while (count < std::min<std::size_t>(waiting_.size(), 62) && waiting_[count].at <= first + settings_.latency)
          ++count;
        const bool is_full = count == 62;
        // More may belong to the chunk until the latency is over.
        if (!is_full && now < first + settings_.latency) return;
        const Duration handed = is_full ? waiting_[count - 1].at : first + settings_.latency;
        const Duration delay{
            static_cast<std::int64_t>(draws_.uniform() * static_cast<double>(settings_.longest_delay.count()))};
        read_at_ = std::max(read_at_, handed + delay);
        for (std::size_t i = 0; i < count; ++i) chunk_.push_back(waiting_[i].value);
        waiting_.erase(waiting_.begin(), waiting_.begin() + static_cast<std::ptrdiff_t>(count));
      }
      if (read_at_ > now) return;
      read(ByteView{chunk_}, read_at_);
      chunk_.clear();
    }
  }

 private:
  struct Timed {
    Duration at;
    std::uint8_t value;
  };
  const Settings settings_;
  const Duration byte_time_;
  simulation::Random draws_;
  Duration free_at_{}, read_at_{};
  std::deque<Timed> waiting_;
  Bytes chunk_;
};

}  // namespace nacelle::lidar
