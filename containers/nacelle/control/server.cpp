// SPDX-License-Identifier: Apache-2.0
#include "control/server.hpp"

#include <fcntl.h>
#include <poll.h>
#include <pthread.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <exception>
#include <new>
#include <utility>

#include "control/trust.hpp"

namespace nacelle::control {
namespace {

constexpr std::size_t kStopPlaces = 4;
constexpr std::size_t kSpareConnections = 4;
// A reserved connection without a writer may be closed for the next one after this silence.
constexpr Duration kStopPatience = 250ms;
constexpr Duration kDescriptorPeriod = 1s;

constexpr const char* kOnlyStops =
    "only emergency stops and shutdown are accepted now: all client connections or file descriptors are in use; close "
    "another client and retry";

int open_any() { return ::open("/dev/null", O_RDONLY | O_CLOEXEC); }

}  // namespace

ControlServer::ControlServer(SocketClaim claim, FastService& service, const Clock& clock, ServerLimits limits)
    : claim_(std::move(claim)), service_(service), clock_(clock), limits_(limits) {
  clients_.reserve(limits_.guests + kStopPlaces);
  spare_.reserve(kSpareConnections);
  while (spare_.size() < kSpareConnections) spare_.push_back(std::make_unique<Connection>(-1));
  thread_ = std::thread{[this] { run(); }};
}

ControlServer::~ControlServer() {
  is_ending_ = true;
  stop_event_.ring();
  thread_.join();
}

std::vector<ControlServer::HandedOver> ControlServer::take_handed_over() {
  handed_over_event_.silence();
  return std::exchange(*handed_over_.lock(), {});
}

ControlServer::Stats ControlServer::stats() const { return {accepted_, turned_away_, handed_over_count_, faults_}; }

void ControlServer::run() {
  ::pthread_setname_np(::pthread_self(), "control");
  descriptor_kept_ = open_any();
  std::vector<pollfd> waits;
  waits.reserve(limits_.guests + kStopPlaces + 2);
  bool was_lost = false;
  while (!is_ending_) {
    now_ = clock_.now();
    waits.clear();
    waits.push_back({was_lost ? -1 : stop_event_.descriptor(), POLLIN, 0});
    waits.push_back({listens_ && !accept_again_ ? claim_.listening_descriptor() : -1, POLLIN, 0});
    for (const Client& client : clients_) {
      // A slow client is only written to. Its next requests stay in the kernel's buffer, which is bounded.
      const int events =
          (client.connection->is_slow() ? 0 : POLLIN) | (client.connection->wants_to_write() ? POLLOUT : 0);
      waits.push_back({client.connection->descriptor(), static_cast<short>(events), 0});
    }
    // Without its event the thread has to poll whether it should end.
    const int limit = was_lost ? static_cast<int>(limits_.without_descriptors / 1ms) : limit_ms();
    if (::poll(waits.data(), waits.size(), limit) < 0) {
      if (errno == EINTR) continue;
      // More connections than the limit of open files allows now (EINVAL), or no memory for so many.
      if (!clients_.empty()) {
        Client* const longest = most_idle(false, 0ns);
        dismiss(longest != nullptr ? *longest : clients_.front(),
                "closed: too many connections for the limit of open files");
      } else {
        ::poll(waits.data(), 1, static_cast<int>(limits_.without_descriptors / 1ms));
      }
      continue;
    }
    now_ = clock_.now();
    if (((waits[0].revents | waits[1].revents) & (POLLNVAL | POLLERR)) != 0) {
      listens_ = listens_ && (waits[1].revents & (POLLNVAL | POLLERR)) == 0;
      was_lost = was_lost || waits[0].revents != 0;
      service_.descriptor_was_lost();
    }
    serve_all(waits.data() + 2);
    try {
      send_the_idle_away();
      if (accept_again_ && *accept_again_ <= now_) accept_again_.reset();
      if ((waits[1].revents & POLLIN) != 0) accept_all();
      look_at_descriptors();
    } catch (const std::bad_alloc&) {
      ++faults_;
      accept_again_ = now_ + limits_.without_descriptors;
    }
  }
  while (!clients_.empty()) remove(clients_.back());
  if (descriptor_kept_ >= 0) ::close(descriptor_kept_);
}

void ControlServer::serve_all(const pollfd* waits) {
  for (std::size_t i = clients_.size(); i-- > 0;) {
    Client& client = clients_[i];
    if (waits[i].revents == 0) continue;
    bool stays = false;
    try {
      stays = serve(client, waits[i].revents);
    } catch (const std::exception& failure) {
      // No memory, thread or descriptor is left for it. Only its own connection ends.
      if (client.connection) client.connection->say_farewell(failure.what());
    }
    if (!stays) remove(client);
  }
}

void ControlServer::remove(Client& client) {
  close(client);
  if (&client != &clients_.back()) std::swap(client, clients_.back());
  clients_.pop_back();
  if (descriptor_kept_ < 0) descriptor_kept_ = open_any();  // its place is free again
}

void ControlServer::close(Client& client) {
  for (const std::uint16_t handle : client.writers) service_.close_writer(handle);
  if (!client.connection || spare_.size() == kSpareConnections) return client.connection.reset();
  client.connection->reuse_for(-1);
  spare_.push_back(std::move(client.connection));
}

void ControlServer::dismiss(Client& client, const char* why) {
  ++turned_away_;
  client.connection->say_farewell(why);
  remove(client);
}

// --- admission and idle connections --------------------------------------------------------------------------------------

void ControlServer::accept_all() {
  while (true) {
    const int descriptor = ::accept4(claim_.listening_descriptor(), nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK);
    if (descriptor >= 0) {
      admit(descriptor, false);
      continue;
    }
    if (errno == EINTR || errno == ECONNABORTED) continue;
    if (errno != EMFILE && errno != ENFILE && errno != ENOMEM && errno != ENOBUFS) return;
    note_shortage(true);
    if (!make_room_for_descriptors()) return;
  }
}

bool ControlServer::make_room_for_descriptors() {
  if (Client* const idle = most_idle(false, limits_.makes_room_after); idle != nullptr) {
    dismiss(*idle, "closed as the longest idle connection: the container is out of file descriptors");
    return true;
  }
  if (descriptor_kept_ >= 0) {
    ::close(std::exchange(descriptor_kept_, -1));
    const int descriptor = ::accept4(claim_.listening_descriptor(), nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK);
    if (descriptor >= 0) {
      admit(descriptor, true);
      return true;
    }
  } else if (Client* const idle = most_idle(true, kStopPatience); idle != nullptr) {
    dismiss(*idle, kOnlyStops);
    return true;
  }
  // The listener stays readable, so the loop would spin.
  accept_again_ = now_ + limits_.without_descriptors;
  return false;
}

void ControlServer::admit(int descriptor, bool for_stops) {
  std::unique_ptr<Connection> connection;
  if (spare_.empty()) {
    try {
      connection = std::make_unique<Connection>(descriptor);
    } catch (const std::bad_alloc&) {
      ::close(descriptor);
      throw;
    }
  } else {
    connection = std::move(spare_.back());
    spare_.pop_back();
    connection->reuse_for(descriptor);
  }
  if (!is_welcome(*connection)) {
    ++turned_away_;
    connection->say_farewell("refused: the container accepts its own user, root and its group only");
    return;
  }
  const auto reserved = static_cast<std::size_t>(std::ranges::count_if(clients_, &Client::for_stops));
  if (!for_stops && clients_.size() - reserved >= limits_.guests) {
    if (Client* const idle = most_idle(false, limits_.makes_room_after); idle != nullptr) {
      dismiss(*idle, "closed as the longest idle connection: all client connections are in use");
    } else {
      for_stops = true;
    }
  }
  if (for_stops && reserved >= kStopPlaces) {
    if (Client* const idle = most_idle(true, 0ns); idle != nullptr) dismiss(*idle, kOnlyStops);
  }
  clients_.push_back({std::move(connection), {}, now_, for_stops});
  ++accepted_;
}

bool ControlServer::is_welcome(Connection& connection) {
  const auto peer = peer_of(connection.descriptor());
  return peer && may_ask(connection.descriptor(), *peer, claim_.group());
}

ControlServer::Client* ControlServer::most_idle(bool for_stops, Duration at_least) {
  Client* found = nullptr;
  // Reserved connections with a writer, which send a stop, are closed last.
  const auto goes_first = [&](const Client& one, const Client& other) {
    if (for_stops && one.writers.empty() != other.writers.empty()) return one.writers.empty();
    return one.said_at < other.said_at;
  };
  for (Client& client : clients_) {
    const Duration needed =
        for_stops || client.writers.empty() ? at_least : std::max(at_least, limits_.writer_makes_room_after);
    if (client.for_stops != for_stops || now_ - client.said_at < needed) continue;
    if (found == nullptr || goes_first(client, *found)) found = &client;
  }
  return found;
}

std::optional<MonotonicTime> ControlServer::end_of(const Client& client) const {
  if (client.for_stops) return client.said_at + limits_.stop;
  if (!client.writers.empty()) return std::nullopt;  // it may publish at a low rate
  return client.said_at + limits_.idle;
}

void ControlServer::send_the_idle_away() {
  for (std::size_t i = clients_.size(); i-- > 0;) {
    const auto end = end_of(clients_[i]);
    if (end && *end <= now_) dismiss(clients_[i], "closed after being idle for too long");
  }
}

int ControlServer::limit_ms() const {
  std::optional<MonotonicTime> next;
  const auto consider = [&](const std::optional<MonotonicTime>& due) {
    if (due && (!next || *due < *next)) next = due;
  };
  for (const Client& client : clients_) consider(end_of(client));
  consider(accept_again_);
  consider(look_again_);
  if (!next) return -1;
  return static_cast<int>(std::clamp<Duration>((*next - now_) / 1ms * 1ms + 1ms, 0ns, 1h) / 1ms);
}

void ControlServer::note_shortage(bool ran_out) {
  if (ran_out == look_again_.has_value()) return;
  service_.descriptors_ran_out(ran_out);
  look_again_.reset();
  if (ran_out) look_again_ = now_ + kDescriptorPeriod;
}

// The shortage is over once one more descriptor than the spare can be opened.
void ControlServer::look_at_descriptors() {
  if (!look_again_ || now_ < *look_again_) return;
  look_again_ = now_ + kDescriptorPeriod;
  if (descriptor_kept_ < 0) descriptor_kept_ = open_any();
  const int one_more = descriptor_kept_ < 0 ? -1 : open_any();
  if (one_more < 0) return;
  ::close(one_more);
  note_shortage(false);
}

// --- frames --------------------------------------------------------------------------------------------------------------

bool ControlServer::serve(Client& client, short events) {
  if ((events & (POLLERR | POLLNVAL)) != 0) return false;
  if ((events & (POLLIN | POLLHUP)) != 0) {
    if (!client.connection->read_some()) return false;
    client.said_at = now_;
  }
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
      } else if (client.for_stops && !may_have(client, *frame.value())) {
        refuse(client, kOnlyStops);
        static_cast<void>(connection->write_some());
        return false;
      } else if (!answer(client, *frame.value())) {
        return false;
      }
    }
    if (!connection->write_some()) return false;
    if (drained || connection->is_slow()) return true;
  }
}

bool ControlServer::may_have(const Client& client, const Frame& frame) const {
  switch (frame.kind) {
    case FrameKind::Stats:
    case FrameKind::Shutdown: return true;
    case FrameKind::Publish: return !client.writers.empty();
    case FrameKind::OpenWriter: {
      const auto names = read_name_pair(frame.payload);
      return names && service_.is_emergency_stop(*names);
    }
    default: return false;
  }
}

// False: the connection is the main thread's now.
bool ControlServer::hand_over(Client& client, const Frame& frame) {
  if (!client.writers.empty()) {
    refuse(client, "a connection that publishes does not take requests; open another one");
    return true;
  }
  HandedOver handed{nullptr, std::string{as_text(frame.payload)}};
  {
    auto waiting = handed_over_.lock();
    if (waiting->size() >= limits_.guests) {
      refuse(client, "refused: too many requests are pending; retry later");
      return true;
    }
    waiting->reserve(waiting->size() + 1);
    handed.connection = std::move(client.connection);
    waiting->push_back(std::move(handed));
  }
  ++handed_over_count_;
  handed_over_event_.ring();
  return false;
}

bool ControlServer::answer(Client& client, const Frame& frame) {
  std::string& out = client.connection->out;
  switch (frame.kind) {
    case FrameKind::Request: return hand_over(client, frame);
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
