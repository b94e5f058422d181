// SPDX-License-Identifier: Apache-2.0
#include "support/linked_brokers.hpp"

#include <sys/socket.h>

#include <algorithm>
#include <cstdlib>
#include <std_msgs/msg/header.hpp>
#include <std_msgs/msg/string.hpp>

namespace nacelle::test {
namespace {

template <typename Inner>
class Settling {
 protected:
  Settling(const LinkedBrokers& both, std::unique_ptr<Inner> inner) : both_(both), inner_(std::move(inner)) {
    both_.settle();
  }
  ~Settling() {
    inner_.reset();
    both_.settle();
  }
  /// What the other side did before this call has arrived.
  [[nodiscard]] Inner& now() const {
    both_.settle();
    return *inner_;
  }
  const LinkedBrokers& both_;
  std::unique_ptr<Inner> inner_;
};

class SettlingWriter final : public Writer, Settling<Writer> {
 public:
  SettlingWriter(const LinkedBrokers& both, std::unique_ptr<Writer> inner) : Settling(both, std::move(inner)) {}
  Block* borrow() override { return inner_->borrow(); }
  Block* adopt(void* message) override { return inner_->adopt(message); }
  PublishResult publish(Block& block) override {
    const PublishResult result = now().publish(block);
    both_.settle();
    return result;
  }
  void assert_liveliness() override {
    now().assert_liveliness();
    both_.settle();
  }
  std::size_t reader_count() const override { return now().reader_count(); }
  WriterCounters counters() const override { return now().counters(); }
  EndpointStatus status() const override { return now().status(); }
  std::uint64_t id() const override { return inner_->id(); }
};

class SettlingReader final : public Reader, Settling<Reader> {
 public:
  SettlingReader(const LinkedBrokers& both, std::unique_ptr<Reader> inner) : Settling(both, std::move(inner)) {}
  Block* take() override {
    Block* const block = now().take();
    both_.settle();
    return block;
  }
  bool has_waiting() const override { return now().has_waiting(); }
  std::size_t writer_count() const override { return now().writer_count(); }
  ReaderCounters counters() const override { return now().counters(); }
  EndpointStatus status() const override { return now().status(); }
  void set_enabled(bool enabled) override {
    now().set_enabled(enabled);
    both_.settle();
  }
  void note_latency(Duration latency) override { inner_->note_latency(latency); }
  void note_rehomed() override { inner_->note_rehomed(); }
};

LinkOptions options_of(const char* peer, Carrier* carrier) {
  LinkOptions options;
  options.carrier = carrier;
  options.peer = peer;
  options.find_type = find_test_type;
  return options;
}

}  // namespace

SocketPair::SocketPair() {
  int ends[2];
  if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) != 0) std::abort();
  one = ends[0];
  two = ends[1];
}

const msgs::MessageType* find_test_type(const std::string& name) {
  for (const auto* type : {&std_msgs::msg::String::message_type(), &std_msgs::msg::Header::message_type()}) {
    if (name == type->name) return type;
  }
  return nullptr;
}

LinkedBrokers::LinkedBrokers(const Clock& clock, Carrier* carrier) : writers_(clock), readers_(clock) {
  const SocketPair sockets;
  writers_link_ = std::make_unique<Link>(writers_, clock, sockets.one, options_of("the readers' side", carrier));
  readers_link_ = std::make_unique<Link>(readers_, clock, sockets.two, options_of("the writers' side", carrier));
}

LinkedBrokers::~LinkedBrokers() = default;

void LinkedBrokers::settle() const {
  // Not `||`: each gets its turn.
  while (static_cast<int>(writers_link_->pump()) + static_cast<int>(readers_link_->pump()) != 0) {}
}

std::unique_ptr<Writer> LinkedBrokers::create_writer(const EndpointSpec& spec) {
  return std::make_unique<SettlingWriter>(*this, writers_.create_writer(spec));
}

std::unique_ptr<Reader> LinkedBrokers::create_reader(const EndpointSpec& spec, Taking taking, ReadyListener* listener) {
  return std::make_unique<SettlingReader>(*this, readers_.create_reader(spec, taking, listener));
}

MonotonicTime LinkedBrokers::watch(MonotonicTime now) {
  settle();
  const MonotonicTime one = writers_.watch(now);
  const MonotonicTime two = readers_.watch(now);
  settle();
  return std::min(one, two);
}

}  // namespace nacelle::test
