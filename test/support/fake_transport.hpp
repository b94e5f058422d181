// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <condition_variable>
#include <map>
#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <vector>

#include "nacelle/host/transport.hpp"

namespace nacelle::test {

/// The simplest thing that keeps Transport's promises: one lock, heap messages, a copy for every owner. It passes the same
/// conformance suite as the real ones, so a unit test over it means something.
class FakeTransport final : public Transport {
 public:
  explicit FakeTransport(const Clock& clock) : state_(std::make_shared<State>(clock)) {}

  [[nodiscard]] std::unique_ptr<Writer> create_writer(const EndpointSpec& spec) override;
  [[nodiscard]] std::unique_ptr<Reader> create_reader(const EndpointSpec& spec, Taking taking,
                                                      ReadyListener* listener) override;
  MonotonicTime watch(MonotonicTime now) override;

 private:
  class FakeWriter;
  class FakeReader;
  struct State {
    explicit State(const Clock& c) : clock(c) {}
    const Clock& clock;
    std::recursive_mutex mutex;
    std::condition_variable_any room;  // notified when a message leaves a queue
    std::vector<FakeWriter*> writers;
    std::vector<FakeReader*> readers;
    std::set<std::pair<const void*, const void*>> introduced;
    std::uint64_t next_id = 1;
    void introduce(FakeWriter& writer, FakeReader& reader);
  };
  std::shared_ptr<State> state_;
};

}  // namespace nacelle::test
