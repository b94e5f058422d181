// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <memory>
#include <string>

#include "transport_laws.hpp"

namespace nacelle {

/// Counts the reported changes of status.
struct Told final : StatusListener {
  void on_status() noexcept override { ++times; }
  std::atomic<int> times{0};
};

/// Endpoints with listeners, and a clock that the test advances; T is a transport over a Clock.
template <typename T>
class QosContract : public TransportLaws<T> {
 public:
  using Texts = typename TransportLaws<T>::Texts;
  EndpointSpec at(const std::string& node, QoS qos, Told* told = nullptr) {
    EndpointSpec spec = this->spec(qos);
    spec.node = node;
    spec.status_listener = told;
    spec.tells_lost = told != nullptr;
    return spec;
  }
  std::unique_ptr<Writer> writer(QoS qos, Told* told = nullptr) {
    return this->transport.create_writer(at("/writer", qos, told));
  }
  std::unique_ptr<Reader> reader(QoS qos, Told* told = nullptr) {
    return this->transport.create_reader(at("/reader", qos, told), Taking::Share, nullptr);
  }
  MonotonicTime pass(Duration time) {
    this->clock.advance(time);
    return this->transport.watch(this->clock.now());
  }
};

}  // namespace nacelle
