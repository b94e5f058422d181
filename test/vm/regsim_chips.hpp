// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fcntl.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <functional>
#include <map>
#include <thread>

#include "nacelle/base/mutex.hpp"
#include "nacelle/io/descriptor.hpp"
#include "simulation/protocol/register_chip.hpp"

namespace nacelle::test {

/// The chips of the bus of i2c-regsim, as long as it lives: emulators that answer its transfers on a thread, in the time of the clock.
class RegsimChips {
 public:
  using Chips = std::map<std::uint8_t, simulation::RegisterChip*>;  ///< By address.

  RegsimChips(Chips chips, const Clock& clock)
      : clock_(clock),
        chips_(std::move(chips)),
        bus_(::open("/dev/i2c-regsim", O_RDWR | O_CLOEXEC)),
        then_(clock.now()),
        thread_([this] { answer(); }) {
    EXPECT_TRUE(bus_.is_open());
  }
  ~RegsimChips() {
    stop_ = true;
    bell_.ring();
    thread_.join();
  }
  RegsimChips(const RegsimChips&) = delete;
  RegsimChips& operator=(const RegsimChips&) = delete;

  /// Runs a function while no chip is in use.
  void between_transfers(const std::function<void()>& change) {
    const LockGuard lock{mutex_};
    change();
  }
  /// What the chips of an IMU feel.
  void feel(const simulation::ImuTruth& truth) {
    const LockGuard lock{mutex_};
    truth_ = truth;
  }

 private:
  void answer() {
    std::array<std::uint8_t, 2048> question{}, reply{};
    while (!stop_) {
      if (io::wait_readable(bus_.number(), bell_, clock_, clock_.now() + 60s) != io::Wake::Ready) continue;
      const ssize_t size = ::read(bus_.number(), question.data(), question.size());
      if (size < 5) continue;
      const std::size_t out = load_le16(question.data() + 1), in = load_le16(question.data() + 3);
      const bool is_answered = transfer(question[0], {question.data() + 5, out}, {reply.data() + 1, in});
      reply[0] = is_answered ? 0 : 1;
      EXPECT_GT(::write(bus_.number(), reply.data(), is_answered ? 1 + in : 1), 0);
    }
  }
  bool transfer(std::uint8_t address, ByteView out, ByteSpan in) {
    const LockGuard lock{mutex_};
    const MonotonicTime now = clock_.now();
    for (const auto& [_, chip] : chips_) chip->advance(to_seconds(now - then_), truth_);
    then_ = now;
    const auto chip = chips_.find(address);
    return chip != chips_.end() && chip->second->transfer(out, in);
  }

  const Clock& clock_;
  const Chips chips_;
  const io::Descriptor bus_;
  Bell bell_;
  std::atomic<bool> stop_{false};
  Mutex mutex_;
  simulation::ImuTruth truth_ NACELLE_GUARDED_BY(mutex_);
  MonotonicTime then_ NACELLE_GUARDED_BY(mutex_);
  std::thread thread_;  // last: it starts when everything above is there
};

}  // namespace nacelle::test
