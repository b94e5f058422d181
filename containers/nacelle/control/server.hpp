// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <poll.h>

#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "control/connection.hpp"
#include "control/frame.hpp"
#include "control/socket_path.hpp"
#include "control/wire.hpp"
#include "nacelle/base/bell.hpp"
#include "nacelle/base/guarded.hpp"
#include "nacelle/base/result.hpp"
#include "nacelle/base/time.hpp"

namespace nacelle::control {

/// The periodic requests of clients. Threads: called on the control thread only.
/// Allocates: open_writer() only; the rest must not, since the robot's steady state is measured.
class FastService {
 public:
  virtual ~FastService() = default;
  [[nodiscard]] virtual Result<std::uint16_t, std::string> open_writer(NamePair topic_and_type) = 0;
  virtual void close_writer(std::uint16_t handle) = 0;
  /// Null, or why it was refused.
  [[nodiscard]] virtual const char* publish(const Publication& publication) = 0;
  [[nodiscard]] virtual TransformAnswer lookup(NamePair target_and_source) = 0;
  virtual void append_stats(std::string& out) = 0;
  /// Requests an orderly shutdown of the robot. Returns at once.
  virtual void request_shutdown() = 0;
  /// Returns whether a client on a reserved connection may write this topic.
  [[nodiscard]] virtual bool is_emergency_stop(NamePair topic_and_type) const = 0;
  /// The process is out of file descriptors, or has some again.
  virtual void descriptors_ran_out(bool ran_out) = 0;
  /// Other code of the process closed a descriptor of the control thread.
  virtual void descriptor_was_lost() = 0;
};

struct ServerLimits {
  std::size_t guests = most_guests();  ///< Connections beside the reserved ones.
  Duration idle = kIdleLimit;          ///< Closes a connection without a writer after this silence.
  Duration makes_room_after = 1s;  ///< If all connections are in use, closes the longest idle one after this silence.
  Duration writer_makes_room_after = 60s;  ///< The same of a connection with a writer, which may publish at a low rate.
  Duration stop = 2s;                      ///< Closes a reserved connection after this silence.
  Duration without_descriptors = 100ms;    ///< Pause of accept() without a free descriptor.
};

/// The control socket's own thread, "control": it accepts clients and answers periodic requests. Connections that begin
/// with a JSON request are handed over to the thread that polls handed_over_descriptor() (the main thread), which may
/// take its time.
///
/// Every client is untrusted: other users are refused, frames are bounded, a slow client is not read until it has taken its
/// answers, and an invalid frame closes its connection. The number of connections is bounded. A few of them, and one
/// descriptor, are reserved for emergency stops (docs/adr/0017).
/// Threads: start, take_handed_over and the destructor from one thread. Allocates: nothing while the same clients go on asking.
class ControlServer {
 public:
  struct HandedOver {
    std::unique_ptr<Connection> connection;
    std::string request;
  };
  struct Stats {
    std::uint64_t accepted{}, turned_away{}, handed_over{}, faults{};
  };

  /// Errors: std::system_error if the process has no descriptors or threads left.
  ControlServer(SocketClaim claim, FastService& service, const Clock& clock, ServerLimits limits = {});
  ControlServer(const ControlServer&) = delete;
  ControlServer& operator=(const ControlServer&) = delete;
  /// Ends the thread and every connection it still has.
  ~ControlServer();

  [[nodiscard]] const std::string& path() const { return claim_.path(); }
  /// Readable when take_handed_over() has something. Level-triggered; take_handed_over() resets it.
  [[nodiscard]] int handed_over_descriptor() const { return handed_over_event_.descriptor(); }
  [[nodiscard]] std::vector<HandedOver> take_handed_over();
  [[nodiscard]] Stats stats() const;

 private:
  struct Client {
    std::unique_ptr<Connection> connection;
    std::vector<std::uint16_t> writers;
    MonotonicTime said_at{};  // of its last bytes
    bool for_stops = false;   // on a reserved connection
  };
  void run();
  void serve_all(const pollfd* waits);
  void accept_all();
  /// Frees a descriptor for accept() and returns true, or pauses accept().
  [[nodiscard]] bool make_room_for_descriptors();
  void admit(int descriptor, bool for_stops);
  [[nodiscard]] bool is_welcome(Connection& connection);
  /// Returns the longest idle client, if it is idle for at least this long; `for_stops`: of the reserved connections.
  [[nodiscard]] Client* most_idle(bool for_stops, Duration at_least);
  /// Returns when a silent client is closed. None: never.
  [[nodiscard]] std::optional<MonotonicTime> end_of(const Client& client) const;
  void send_the_idle_away();
  void dismiss(Client& client, const char* why);
  void remove(Client& client);
  void close(Client& client);
  void note_shortage(bool ran_out);
  void look_at_descriptors();
  [[nodiscard]] int limit_ms() const;
  /// False when the connection is not ours any more: closed, or handed over.
  [[nodiscard]] bool serve(Client& client, short events);
  [[nodiscard]] bool answer(Client& client, const Frame& frame);
  [[nodiscard]] bool may_have(const Client& client, const Frame& frame) const;
  [[nodiscard]] bool hand_over(Client& client, const Frame& frame);
  void refuse(Client& client, const char* why);

  SocketClaim claim_;
  FastService& service_;
  const Clock& clock_;
  const ServerLimits limits_;
  Bell stop_event_, handed_over_event_;
  MonotonicTime now_{};       // of this round
  int descriptor_kept_ = -1;  // the spare; -1: in use
  bool listens_ = true;
  std::optional<MonotonicTime> accept_again_, look_again_;  // after the descriptors ran out
  std::vector<Client> clients_;
  std::vector<std::unique_ptr<Connection>>
      spare_;  // so that a client that only checks whether the container is alive costs no heap
  Guarded<std::vector<HandedOver>> handed_over_;
  std::atomic<bool> is_ending_{false};
  std::atomic<std::uint64_t> accepted_{0}, turned_away_{0}, handed_over_count_{0}, faults_{0};
  std::thread thread_;
};

}  // namespace nacelle::control
