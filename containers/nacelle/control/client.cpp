// SPDX-License-Identifier: Apache-2.0
#include "control/client.hpp"

#include <fcntl.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <nlohmann/json.hpp>
#include <utility>

#include "control/trust.hpp"
#include "nacelle/base/files.hpp"
#include "nacelle/base/json_text.hpp"
#include "nacelle/base/problem_json.hpp"

namespace nacelle::control {
namespace {

// An image as JSON is a few megabytes; no answer of a container is longer than this.
constexpr std::size_t kLongestReply = 64U << 20U;
// For a place in the queue of the socket, and for room in its buffer.
constexpr Duration kSocketLimit = 10s;
// A busy container may need time; a suspended one never answers.
constexpr Duration kLookPeriod = 2s;

void limit_sending(int socket) {
  timeval limit{};
  limit.tv_sec = std::chrono::duration_cast<std::chrono::seconds>(kSocketLimit).count();
  ::setsockopt(socket, SOL_SOCKET, SO_SNDTIMEO, &limit, sizeof limit);
}

/// The letter of proc_pid_stat(5): R, S, D, T (stopped), t (by a debugger), Z; '?' where there is none.
char state_of(int process) {
  const std::string text = read_regular_file("/proc/" + std::to_string(process) + "/stat").value_or("");
  const auto end_of_name = text.rfind(") ");  // a name may hold brackets
  return end_of_name == std::string::npos || end_of_name + 2 >= text.size() ? '?' : text[end_of_name + 2];
}

}  // namespace

nlohmann::json reply_of(const Problem& problem) { return {{"ok", false}, {"problem", problem}}; }

Client::Client(int fd) : fd_(fd), reader_(kLongestReply) {}
Client::Client(Client&& other) noexcept
    : fd_(std::exchange(other.fd_, -1)),
      patience_(other.patience_),
      process_(other.process_),
      is_container_(other.is_container_),
      reader_(std::move(other.reader_)),
      out_(std::move(other.out_)) {}
Client& Client::operator=(Client&& other) noexcept {
  std::swap(fd_, other.fd_);
  std::swap(patience_, other.patience_);
  std::swap(process_, other.process_);
  std::swap(is_container_, other.is_container_);
  std::swap(reader_, other.reader_);
  std::swap(out_, other.out_);
  return *this;
}
Client::~Client() {
  if (fd_ >= 0) ::close(fd_);
}

Problem Client::gone(const char* what) const {
  if (!is_container_) return {"--remote", what, "try again"};
  return {"container", what, "look at the container's own output"};
}

Problem Client::problem_of(const Frame& fault) const {
  return {is_container_ ? "container" : "", std::string{as_text(fault.payload)}, ""};
}

Problem Client::farewell(const char* what) {
  while (true) {
    auto frame = receive(0ns);
    if (!frame || !frame.value()) return gone(what);
    if (frame.value()->kind == FrameKind::Fault) return problem_of(*frame.value());
  }
}

std::optional<Problem> Client::is_stopped() const {
  const char state = process_ > 0 ? state_of(process_) : '?';
  if (state != 'T' && state != 't') return std::nullopt;
  const std::string process = std::to_string(process_);
  const bool is_traced = state == 't';
  return Problem{"container", "its process " + process + " is stopped" + (is_traced ? " by a debugger" : ""),
                 is_traced ? "resume it there" : "resume it with `kill -CONT " + process + "`"};
}

Client Client::over(int descriptor, Duration patience) {
  Client client{descriptor};
  client.is_container_ = false;
  client.patience_ = patience;
  return client;
}

Result<Client, Problem> Client::connect(const std::string& path) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  if (path.size() >= sizeof(address.sun_path)) return err(Problem{path, "too long for a socket's path", ""});
  std::memcpy(address.sun_path, path.c_str(), path.size() + 1);
  const int fd = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
  if (fd < 0) return err(Problem{path, std::strerror(errno), ""});
  Client client{fd};
  limit_sending(fd);
  if (::connect(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) {
    if (errno == EAGAIN)
      return err(
          Problem{path, "connecting timed out", "the container may hang or be stopped: see `ps -o pid,stat,args`"});
    return err(Problem{path, std::strerror(errno), "is the container running?"});
  }
  // The kernel's word on the listener: the path may have become another one since it was looked at.
  const auto peer = peer_of(fd);
  if (!peer || !may_answer(*peer, path)) {
    const std::string user = peer ? "user " + std::to_string(peer->user) : "an unknown user";
    return err(Problem{path, "the listener belongs to " + user + ", not to this user or root",
                       "no request was sent; remove the socket"});
  }
  client.process_ = peer->process;
  return client;
}

Result<void, Problem> Client::send(FrameKind kind, std::string_view payload) {
  out_.clear();
  append_frame(out_, kind, payload);
  std::string_view rest = out_;
  while (!rest.empty()) {
    const ssize_t sent = ::send(fd_, rest.data(), rest.size(), MSG_NOSIGNAL);
    if (sent < 0 && errno == EINTR) continue;
    if (sent < 0 && errno == EAGAIN) return err(is_stopped().value_or(gone("sending the request timed out")));
    if (sent <= 0) return err(farewell("it ended during the request"));
    rest.remove_prefix(static_cast<std::size_t>(sent));
  }
  return {};
}

Result<std::optional<Frame>, Problem> Client::receive(Duration limit) {
  const SystemClock clock;
  const MonotonicTime until = clock.now() + limit;
  while (true) {
    auto frame = reader_.next();
    if (!frame)
      return err(Problem{"container", to_text(frame.error()), "use the `nacelle` that started the container"});
    if (frame.value()) return frame.value();
    const Duration left = until - clock.now();
    pollfd wait{fd_, POLLIN, 0};
    const auto milliseconds = left > 0ns ? static_cast<int>(left / 1ms) + 1 : 0;
    const int ready = ::poll(&wait, 1, milliseconds);
    // A signal is the caller's business: it looks at its own flag and asks again.
    if (ready <= 0) return std::optional<Frame>{};
    const ByteSpan room = reader_.room();
    const ssize_t got = ::recv(fd_, room.data(), room.size(), 0);
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) return err(gone("it ended before it answered"));
    reader_.filled(static_cast<std::size_t>(got));
  }
}

Result<Frame, Problem> Client::expect(FrameKind kind, Duration limit) {
  const SystemClock clock;
  const MonotonicTime until = clock.now() + limit + patience_;
  while (true) {
    auto frame = receive(std::min(until - clock.now(), kLookPeriod));
    if (!frame) return err(frame.error());
    if (!frame.value()) {
      if (auto stopped = is_stopped()) return err(std::move(*stopped));
      if (clock.now() < until) continue;
      return err(gone("it did not answer in time"));
    }
    if (frame.value()->kind == kind) return *frame.value();
    if (frame.value()->kind == FrameKind::Fault) return err(problem_of(*frame.value()));
    // Something that was announced while we waited (Shutdown); the caller asks for it when it matters.
  }
}

Result<nlohmann::json, Problem> Client::call(const nlohmann::json& request, Duration limit) {
  if (auto sent = send(FrameKind::Request, request.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace));
      !sent) {
    return err(sent.error());
  }
  auto frame = expect(FrameKind::Reply, limit);
  if (!frame) return err(frame.error());
  nlohmann::json reply = parse_json_or_discard(as_text(frame.value().payload));
  if (!reply.is_object()) return err(gone("its answer is not an object"));
  if (reply.value("ok", false)) return reply;
  auto problem = reply.value("problem", nlohmann::json::object()).get<Problem>();
  if (problem.what.empty()) problem.what = "refused";
  return err(std::move(problem));
}

Result<std::uint16_t, Problem> Client::open_writer(std::string_view topic, std::string_view type, Duration limit) {
  std::string names;
  append_name_pair(names, {topic, type});
  if (auto sent = send(FrameKind::OpenWriter, names); !sent) return err(sent.error());
  auto frame = expect(FrameKind::Opened, limit);
  if (!frame) return err(frame.error());
  const auto handle = read_handle(frame.value().payload);
  if (!handle) return err(gone("its answer has the wrong length"));
  return *handle;
}

Result<void, Problem> Client::publish(std::uint16_t handle, ByteView cdr) {
  std::string payload;
  append_handle(payload, handle);
  payload.append(as_text(cdr));
  return send(FrameKind::Publish, payload);
}

Result<TransformAnswer, Problem> Client::lookup(std::string_view target, std::string_view source, Duration limit) {
  std::string names;
  append_name_pair(names, {target, source});
  if (auto sent = send(FrameKind::Lookup, names); !sent) return err(sent.error());
  auto frame = expect(FrameKind::Transform, limit);
  if (!frame) return err(frame.error());
  const auto answer = read_transform(frame.value().payload);
  if (!answer) return err(gone("its transform cannot be read"));
  return *answer;
}

Result<std::string, Problem> Client::stats(Duration limit) {
  if (auto sent = send(FrameKind::Stats, ""); !sent) return err(sent.error());
  auto frame = expect(FrameKind::Stats, limit);
  if (!frame) return err(frame.error());
  return std::string{as_text(frame.value().payload)};
}

}  // namespace nacelle::control
