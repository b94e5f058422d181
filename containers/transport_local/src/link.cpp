// SPDX-License-Identifier: Apache-2.0
#include "nacelle/transport_local/link.hpp"

#include <fcntl.h>
#include <poll.h>
#include <pthread.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>

#include "link_services.hpp"

namespace nacelle {
namespace {

// Identifies the sender in the name of a carried stream: a container forwards messages that it got by the same carrier from elsewhere.
std::uint64_t new_token() {
  static std::atomic<std::uint32_t> links{0};
  return static_cast<std::uint64_t>(::getpid()) << 32U | ++links;
}

}  // namespace

Link::Impl::Impl(Graph& g, const Clock& c, int s, LinkOptions o)
    : graph(g),
      clock(c),
      socket(s),
      options(std::move(o)),
      event(::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)),
      token(new_token()),
      services(std::make_unique<Services>(*this)) {
  ::fcntl(socket, F_SETFL, ::fcntl(socket, F_GETFL) | O_NONBLOCK);
  wire::append_hello(out, options.carrier != nullptr ? options.carrier->name() : "", token);
  number = graph.join(*this);
  services->join();
}

Link::Impl::~Impl() {
  stopping = true;
  wake();
  if (thread.joinable()) thread.join();
  graph.leave(number);
  services->end();
  for (const auto& [writer, departure] : departures) lender->set(writer, nullptr);
  departures.clear();
  remotes.clear();
  ::close(socket);
  ::close(event);
}

void Link::Impl::wake() noexcept {
  if (signalled.exchange(true)) return;
  const std::uint64_t one = 1;
  static_cast<void>(!::write(event, &one, sizeof one));
}

void Link::Impl::run() {
  pthread_setname_np(pthread_self(), "link");
  bool readable = true;
  while (!stopping && !ended) {
    pump(readable);
    if (stopping || ended) return;
    bool writing = false;
    {
      const LockGuard lock(pumping);
      writing = out_sent < out.size();
    }
    std::array<pollfd, 2> waits{pollfd{socket, static_cast<short>(POLLIN | (writing ? POLLOUT : 0)), 0},
                                pollfd{event, POLLIN, 0}};
    ::poll(waits.data(), waits.size(), -1);
    readable = (waits[0].revents & ~POLLOUT) != 0;
    if (waits[1].revents != 0) {
      std::uint64_t count = 0;
      static_cast<void>(!::read(event, &count, sizeof count));
    }
  }
}

bool Link::Impl::pump(bool readable) {
  const LockGuard lock(pumping);
  if (ended) return false;
  // Cleared before events are taken, so that a later event wakes again.
  signalled = false;
  bool did = take_events();
  if (readable) did |= read_socket();
  if (ended) return true;
  did |= tell_taken();
  do {
    did |= flush();
    did |= services->send();
    did |= send_ready();
    did |= flush();
    // What was left for want of room, which there is now: the socket would not wake us for it.
  } while ((held_back || services->is_held_back()) && !is_full());
  return did;
}

bool Link::Impl::read_socket() {
  bool did = false;
  // At most so much before it is this side's turn to send.
  for (std::size_t budget = std::size_t{1} << 20U; budget != 0;) {
    const ByteSpan room = in.room();
    const ssize_t n = ::recv(socket, room.data(), room.size(), 0);
    if (n == 0) {
      end({options.peer, "closed the link", ""});
      return true;
    }
    if (n < 0) {
      if (errno == EINTR) continue;
      if (errno != EAGAIN && errno != EWOULDBLOCK)
        end({options.peer, std::string("the link broke: ") + std::strerror(errno), ""});
      return did;
    }
    did = true;
    const auto bytes = static_cast<std::size_t>(n);
    bytes_received += bytes;
    in.filled(bytes);
    for (;;) {
      auto next = in.next();
      if (!next) {
        end({options.peer, to_text(next.error()), "are both processes of the same version?"});
        return true;
      }
      if (!next.value()) break;
      if (!handle(*next.value())) {
        if (!ended) end({options.peer, to_text(wire::LinkFault::BadFrame), "are both processes of the same version?"});
        return true;
      }
    }
    if (bytes < room.size()) break;
    budget -= std::min(budget, bytes);
  }
  return did;
}

bool Link::Impl::flush() {
  bool did = false;
  while (out_sent < out.size()) {
    const ssize_t n = ::send(socket, out.data() + out_sent, out.size() - out_sent, MSG_NOSIGNAL);
    if (n < 0) {
      if (errno == EINTR) continue;
      // The end of a peer is handled when reading, after its last messages.
      if (errno != EAGAIN && errno != EWOULDBLOCK) {
        out.clear();
        out_sent = 0;
        return did;
      }
      break;
    }
    did = true;
    out_sent += static_cast<std::size_t>(n);
    bytes_sent += static_cast<std::uint64_t>(n);
  }
  if (out_sent == out.size()) {
    out.clear();
    out_sent = 0;
  }
  return did;
}

bool Link::Impl::handle(const wire::LinkFrame& frame) {
  using wire::LinkFrameKind;
  const auto id_of = [&] { return wire::read_id(frame.payload); };
  switch (frame.kind) {
    case LinkFrameKind::Hello: {
      const auto hello = wire::read_hello(frame.payload);
      if (hello) {
        carries = options.carrier != nullptr && hello.value().carrier == options.carrier->name();
        peer_token = hello.value().token;
        return true;
      }
      end({options.peer, to_text(hello.error()), "are both processes of the same version?"});
      return false;
    }
    case LinkFrameKind::Writer:
    case LinkFrameKind::Reader: return handle_endpoint(frame);
    case LinkFrameKind::Data: return handle_data(frame.payload);
    case LinkFrameKind::Taken: return handle_taken(frame.payload);
    case LinkFrameKind::Gone: {
      const auto id = id_of();
      if (id) handle_gone(*id);
      return id.has_value();
    }
    case LinkFrameKind::Life: {
      const auto id = id_of();
      if (!id) return false;
      const auto found = remotes.find(*id);
      if (found != remotes.end() && found->second.writer) found->second.writer->assert_liveliness();
      return true;
    }
    case LinkFrameKind::Gate: {
      const auto gate = wire::read_id_and_byte(frame.payload);
      if (gate) handle_gate(gate->first, gate->second != 0);
      return gate.has_value();
    }
    case LinkFrameKind::Lost: {
      const auto lost = wire::read_lost(frame.payload);
      if (lost) handle_lost(*lost);
      return lost.has_value();
    }
    case LinkFrameKind::Carry: return handle_carry(frame.payload);
    case LinkFrameKind::Note:
      if (options.on_note) options.on_note(std::string(as_text(frame.payload)));
      return true;
    case LinkFrameKind::Service:
    case LinkFrameKind::ServiceGone:
    case LinkFrameKind::ServiceReady:
    case LinkFrameKind::Call:
    case LinkFrameKind::Answer: return services->handle(frame);
  }
  return false;
}

void Link::Impl::end(const Problem& problem) {
  if (ended.exchange(true)) return;
  graph.leave(number);
  services->end();
  for (const auto& [writer, departure] : departures) lender->set(writer, nullptr);
  departures.clear();
  remotes.clear();
  topics.clear();
  ::shutdown(socket, SHUT_RDWR);
  if (options.on_end) options.on_end(problem);
}

// --- the outside --------------------------------------------------------------------------------------------------------

Link::Link(Graph& graph, const Clock& clock, int socket, LinkOptions options)
    : impl_(std::make_unique<Impl>(graph, clock, socket, std::move(options))) {}

Link::~Link() = default;

void Link::start() {
  if (!impl_->thread.joinable()) impl_->thread = std::thread([impl = impl_.get()] { impl->run(); });
}

bool Link::pump() {
  const bool did = impl_->pump(true);
  return impl_->drain_carrier() || did;
}

void Link::send_note(std::string note) {
  {
    const LockGuard lock(impl_->noting);
    impl_->notes.push_back(std::move(note));
  }
  impl_->wake();
}

bool Link::has_ended() const { return impl_->ended; }

LinkStats Link::stats() const {
  return {impl_->sent,    impl_->received, impl_->bytes_sent, impl_->bytes_received,
          impl_->carried, impl_->dropped,  impl_->broken};
}

}  // namespace nacelle
