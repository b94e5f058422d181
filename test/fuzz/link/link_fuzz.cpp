// SPDX-License-Identifier: Apache-2.0
// A peer that sends arbitrary bytes: the link ends or continues, nothing crashes, each message is accounted for, and the graph is as
// before once the link is gone.
#include <sys/socket.h>
#include <unistd.h>

#include <cstdlib>

#include "runtime/src/services.hpp"
#include "support/linked_brokers.hpp"
#include "support/manual_clock.hpp"

namespace {

using namespace nacelle;

void require(bool holds) {
  if (!holds) std::abort();
}

/// Calls what the peer offers, and counts how often it is answered.
struct Caller final : AnswerTaker {
  void push(std::int64_t, std::unique_ptr<msgs::AnyMessage>) override { ++answers; }
  void call(runtime::ServiceDirectory& services, const msgs::MessageType& type) {
    msgs::AnyMessage request{type};
    if (services.send("/service", type, {{self, 1}, std::move(request)})) ++calls;
  }
  std::size_t calls = 0, answers = 0;
  std::shared_ptr<Guarded<AnswerTaker*>> self =
      std::make_shared<Guarded<AnswerTaker*>>(std::in_place, static_cast<AnswerTaker*>(this));
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const bool quiet = [] {
    set_log_level(LogLevel::Fatal);
    return true;
  }();
  static_cast<void>(quiet);
  const test::ManualClock clock;
  runtime::Broker broker{clock};
  const auto* const type = test::find_test_type("std_msgs/msg/String");
  auto reader = broker.create_reader({"/chat", type, QoS(3), "/reader"}, Taking::Share, nullptr);
  auto writer = broker.create_writer({"/chat", type, QoS(3).transient_local(), "/writer"});
  const test::SocketPair sockets;
  LinkOptions options;
  options.mirror_all = size % 2 == 0;
  options.find_type = test::find_test_type;
  runtime::ServiceDirectory services;
  Caller caller;
  options.service_hub = &services;
  std::size_t ends = 0;
  options.on_end = [&](const Problem&) { ++ends; };
  {
    Link link{broker, clock, sockets.one, options};
    std::size_t sent = 0;
    while (sent < size && !link.has_ended()) {
      const ssize_t n = ::send(sockets.two, data + sent, size - sent, MSG_DONTWAIT | MSG_NOSIGNAL);
      if (n > 0) sent += static_cast<std::size_t>(n);
      static_cast<void>(writer->publish(*writer->borrow()));
      caller.call(services, *type);
      link.pump();
      Bytes answers(4096);
      while (::recv(sockets.two, answers.data(), answers.size(), MSG_DONTWAIT) > 0) {}
    }
    ::close(sockets.two);
    while (link.pump()) {}
    require(link.has_ended() && ends == 1);
    const LinkStats stats = link.stats();
    require(stats.dropped + stats.broken <= stats.received);
    require(caller.answers == caller.calls);
  }
  require(reader->writer_count() == 1 && writer->reader_count() == 1);
  while (Block* const block = reader->take()) drop_reference(*block);
  return 0;
}
