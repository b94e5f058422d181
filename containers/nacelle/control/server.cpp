// SPDX-License-Identifier: Apache-2.0
#include "nacelle/control/server.hpp"

#include <fmt/format.h>
#include <poll.h>
#include <pthread.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <utility>

namespace nacelle::control {
namespace {

constexpr std::size_t kMaxClients = 64;
constexpr std::size_t kSpareConnections = 4;
// Room for the live figures of a large robot, so that answering never grows it.
constexpr std::size_t kOutReserve = 64U << 10U;

void signal_event(int descriptor) {
  const std::uint64_t one = 1;
  // It can only fail when the counter is full, and then the other side has been woken already.
  static_cast<void>(!::write(descriptor, &one, sizeof one));
}

void drain_event(int descriptor) {
  std::uint64_t count = 0;
  static_cast<void>(!::read(descriptor, &count, sizeof count));
}

}  // namespace

Connection::Connection(int descriptor) : descriptor_(descriptor) { out.reserve(kOutReserve); }
Connection::~Connection() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

void Connection::reuse_for(int descriptor) {
  if (descriptor_ >= 0) ::close(descriptor_);
  descriptor_ = descriptor;
  in.forget();
  out.clear();
  sent_ = 0;
}

bool Connection::read_some() {
  const ByteSpan room = in.room();
  const ssize_t got = ::recv(descriptor_, room.data(), room.size(), MSG_DONTWAIT);
  if (got > 0) {
    in.filled(static_cast<std::size_t>(got));
    return true;
  }
  return got < 0 && (errno == EAGAIN || errno == EINTR);
}

bool Connection::write_some() {
  while (wants_to_write()) {
    const ssize_t sent = ::send(descriptor_, out.data() + sent_, out.size() - sent_, MSG_NOSIGNAL | MSG_DONTWAIT);
    if (sent < 0) return errno == EAGAIN || errno == EINTR;
    sent_ += static_cast<std::size_t>(sent);
  }
  out.clear();  // keeps its capacity
  sent_ = 0;
  return true;
}

ControlServer::ControlServer(SocketClaim claim, FastService& service)
    : claim_(std::move(claim)),
      service_(service),
      stop_event_(::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)),
      handed_over_event_(::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)) {
  clients_.reserve(kMaxClients);
  spare_.reserve(kSpareConnections);
  while (spare_.size() < kSpareConnections) spare_.push_back(std::make_unique<Connection>(-1));
  thread_ = std::thread{[this] { run(); }};
}

ControlServer::~ControlServer() {
  signal_event(stop_event_);
  thread_.join();
  ::close(stop_event_);
  ::close(handed_over_event_);
}

std::vector<ControlServer::HandedOver> ControlServer::take_handed_over() {
  drain_event(handed_over_event_);
  return std::exchange(*handed_over_.lock(), {});
}

ControlServer::Stats ControlServer::stats() const { return {accepted_, turned_away_, handed_over_count_, faults_}; }

void ControlServer::run() {
  ::pthread_setname_np(::pthread_self(), "control");
  std::vector<pollfd> waits;
  waits.reserve(kMaxClients + 2);
  while (true) {
    waits.clear();
    waits.push_back({stop_event_, POLLIN, 0});
    waits.push_back({claim_.listening_descriptor(), POLLIN, 0});
    for (const Client& client : clients_) {
      // A slow client is only written to: what it asks for next stays in the kernel's buffer, and that is bounded.
      const int events =
          (client.connection->is_slow() ? 0 : POLLIN) | (client.connection->wants_to_write() ? POLLOUT : 0);
      waits.push_back({client.connection->descriptor(), static_cast<short>(events), 0});
    }
    if (::poll(waits.data(), waits.size(), -1) < 0 && errno != EINTR) break;
    if (waits[0].revents != 0) break;
    for (std::size_t i = clients_.size(); i-- > 0;) {
      Client& client = clients_[i];
      if (waits[i + 2].revents == 0 || serve(client, waits[i + 2].revents)) continue;
      close(client);
      std::swap(client, clients_.back());
      clients_.pop_back();
    }
    if (waits[1].revents != 0) accept_all();
  }
  for (Client& client : clients_) close(client);
  clients_.clear();
}

void ControlServer::close(Client& client) {
  for (const std::uint16_t handle : client.writers) service_.close_writer(handle);
  if (!client.connection || spare_.size() == kSpareConnections) return;
  client.connection->reuse_for(-1);
  spare_.push_back(std::move(client.connection));
}

void ControlServer::accept_all() {
  while (true) {
    const int descriptor = ::accept4(claim_.listening_descriptor(), nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK);
    if (descriptor < 0) return;
    if (clients_.size() == kMaxClients) {
      ::close(descriptor);
      ++turned_away_;
      continue;
    }
    std::unique_ptr<Connection> connection;
    if (spare_.empty()) {
      connection = std::make_unique<Connection>(descriptor);
    } else {
      connection = std::move(spare_.back());
      spare_.pop_back();
      connection->reuse_for(descriptor);
    }
    clients_.push_back({std::move(connection), {}});
    ++accepted_;
  }
}

bool ControlServer::serve(Client& client, short events) {
  if ((events & (POLLERR | POLLNVAL)) != 0) return false;
  if ((events & (POLLIN | POLLHUP)) != 0 && !client.connection->read_some()) return false;
  Connection* const connection = client.connection.get();
  while (true) {
    bool drained = false;
    while (!drained && !connection->is_slow()) {
      auto frame = connection->in.next();
      if (!frame) {
        // Whatever follows cannot be cut into frames any more.
        refuse(client, to_text(frame.error()));
        static_cast<void>(connection->write_some());
        return false;
      }
      if (!frame.value()) {
        drained = true;
      } else if (!answer(client, *frame.value())) {
        return false;
      }
    }
    if (!connection->write_some()) return false;
    if (drained || connection->is_slow()) return true;
  }
}

bool ControlServer::answer(Client& client, const Frame& frame) {
  std::string& out = client.connection->out;
  switch (frame.kind) {
    case FrameKind::Request: {
      if (!client.writers.empty()) {
        refuse(client, "a connection that publishes does not take requests; open another one");
        return true;
      }
      HandedOver handed{nullptr, std::string{as_text(frame.payload)}};
      handed.connection = std::move(client.connection);
      handed_over_.lock()->push_back(std::move(handed));
      ++handed_over_count_;
      signal_event(handed_over_event_);
      return false;
    }
    case FrameKind::OpenWriter: {
      const auto names = read_name_pair(frame.payload);
      if (!names) {
        refuse(client, "two names are needed: topic and type");
        return true;
      }
      auto handle = service_.open_writer(*names);
      if (!handle) {
        refuse(client, handle.error().c_str());
        return true;
      }
      client.writers.push_back(handle.value());
      const std::size_t begin = begin_frame(out, FrameKind::Opened);
      append_handle(out, handle.value());
      end_frame(out, begin);
      return true;
    }
    case FrameKind::Publish: {
      const auto publication = read_publication(frame.payload);
      bool own = false;
      for (const std::uint16_t handle : client.writers) own = own || (publication && handle == publication->handle);
      // A handle of another client is as unknown as any other number.
      const char* const refused = own ? service_.publish(*publication) : "no such handle; open the writer first";
      if (refused != nullptr) refuse(client, refused);
      return true;
    }
    case FrameKind::Lookup: {
      const auto names = read_name_pair(frame.payload);
      if (!names) {
        refuse(client, "two names are needed: target frame and source frame");
        return true;
      }
      const std::size_t begin = begin_frame(out, FrameKind::Transform);
      append_transform(out, service_.lookup(*names));
      end_frame(out, begin);
      return true;
    }
    case FrameKind::Stats: {
      const std::size_t begin = begin_frame(out, FrameKind::Stats);
      service_.append_stats(out);
      end_frame(out, begin);
      return true;
    }
    case FrameKind::Shutdown:
      service_.request_shutdown();
      append_frame(out, FrameKind::Shutdown, "");
      return true;
    case FrameKind::Reply:
    case FrameKind::Item:
    case FrameKind::Opened:
    case FrameKind::Transform:
    case FrameKind::Fault: break;
  }
  refuse(client, "a client does not send this kind of frame");
  return true;
}

void ControlServer::refuse(Client& client, const char* why) {
  ++faults_;
  append_frame(client.connection->out, FrameKind::Fault, why);
}

}  // namespace nacelle::control
