// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <memory>
#include <string>
#include <vector>

#include "mirrored.hpp"

namespace nacelle::test {

/// Time that passes so many times as fast as another clock's, from where that one is now. Threads: any.
class DilatedClock final : public Clock {
 public:
  DilatedClock(const Clock& of, std::int64_t factor)
      : of_(of), factor_(factor), from_(of.now()), wall_from_(of.wall_now()) {}
  [[nodiscard]] MonotonicTime now() const override { return dilated(of_.now()); }
  [[nodiscard]] WallTime wall_now() const override { return wall_from_ + (of_.wall_now() - wall_from_) * factor_; }
  [[nodiscard]] MonotonicTime dilated(MonotonicTime time) const { return from_ + (time - from_) * factor_; }
  /// The other clock's first time at which this one is there.
  [[nodiscard]] MonotonicTime first(MonotonicTime at) const;

 private:
  const Clock& of_;
  const std::int64_t factor_;
  const MonotonicTime from_;
  const WallTime wall_from_;
};

/// Two brokers that only the network joins, DDS on the loopback interface in one process: writers are on one side, readers on
/// the other.
///
/// Each call returns when the network is quiescent: all endpoints that should match have matched, and all messages have arrived.
/// Which these are follows from QoS alone (`fits()`, history, gates). If they do not, the test fails, and later calls no longer wait.
/// A message of another topic is then sent as a fence, so that a message that should not arrive would have arrived before it.
///
/// Times of the QoS and of the brokers' clock are a thousand times those of the test, so that nothing expires by Cyclone's own
/// clock during a test: 50 ms in a test's QoS are 50 s here, which do not pass.
/// Threads: one.
class MirroredBrokers final : public Transport {
 public:
  explicit MirroredBrokers(const Clock& clock);
  ~MirroredBrokers() override;
  [[nodiscard]] std::unique_ptr<Writer> create_writer(const EndpointSpec& spec) override;
  [[nodiscard]] std::unique_ptr<Reader> create_reader(const EndpointSpec& spec, Taking taking,
                                                      ReadyListener* listener) override;
  MonotonicTime watch(MonotonicTime now) override;

  [[nodiscard]] MirrorStats writers_stats() const { return writers_.mirror->stats(); }
  [[nodiscard]] MirrorStats readers_stats() const { return readers_.mirror->stats(); }
  [[nodiscard]] const Clock& brokers_clock() const { return clock_; }
  /// Messages of the writers' side that were copied, or encoded, on their way.
  [[nodiscard]] std::uint64_t copies_at(const std::string& topic) const;

 private:
  class SettlingWriter;
  class SettlingReader;
  struct Side {
    explicit Side(const Clock& clock) : broker(clock), mirror(start_mirror(broker, clock, {})) {}
    runtime::Broker broker;
    std::unique_ptr<DdsMirror> mirror;
  };
  struct Fence {
    std::unique_ptr<Writer> writer;
    std::unique_ptr<Reader> reader;
  };
  template <typename F>
  void until(const char* what, F holds) const;
  void settle_graph() const;
  void settle_messages() const;
  void send_fence() const;
  [[nodiscard]] bool has_met() const;
  [[nodiscard]] bool has_arrived() const;

  const DilatedClock clock_;
  mutable Bell bell_;
  Side writers_, readers_;
  // In turn: a writer's message that comes while the one before is being sent goes before those of others.
  std::array<Fence, 2> fences_;
  std::vector<std::unique_ptr<Writer>> marks_;  // one for each writer that was made, behind it
  std::vector<SettlingWriter*> all_writers_;
  std::vector<SettlingReader*> all_readers_;
  mutable std::uint64_t sent_ = 0, rounds_ = 0;
  mutable bool gave_up_ = false;
};

}  // namespace nacelle::test
