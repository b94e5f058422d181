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

/// The periodic requests of clients.
///
/// Threads: called on the control thread only.
/// Allocates: only open_writer() may; the others are part of the robot's steady state, whose allocations are measured.
class FastService {
 public:
  virtual ~FastService() = default;
  [[nodiscard]] virtual Result<std::uint16_t, std::string> open_writer(NamePair topic_and_type) = 0;
  virtual void close_writer(std::uint16_t handle) = 0;
  /// Returns null, or the reason for the refusal.
  [[nodiscard]] virtual const char* publish(const Publication& publication) = 0;
  [[nodiscard]] virtual TransformAnswer lookup(NamePair target_and_source) = 0;
  virtual void append_stats(std::string& out) = 0;
  /// Requests an orderly shutdown of the robot. Returns at once.
  virtual void request_shutdown() = 0;
  /// Returns whether a client on a reserved connection may write this topic.
  [[nodiscard]] virtual bool is_emergency_stop(NamePair topic_and_type) const = 0;
  /// Called when the process runs out of file descriptors, and when some are available again.
  virtual void descriptors_ran_out(bool ran_out) = 0;
  /// Called when other code of the process has closed a descriptor of the control thread.
  virtual void descriptor_was_lost() = 0;
};

struct ServerLimits {
  std::size_t guests = most_guests();  ///< Connections beside the reserved ones.
  Duration idle = kIdleLimit;          ///< Closes a connection without a writer after this silence.
  Duration makes_room_after = 1s;  ///< If all connections are in use, closes the longest idle one after this silence.
  Duration writer_makes_room_after = 60s;  ///< For a connection with a writer.
  Duration stop = 2s;                      ///< Closes a reserved connection after this silence.
  Duration without_descriptors = 100ms;    ///< Pause of accept() without a free descriptor.
};

/// Runs the thread "control", which accepts clients and answers periodic requests. A connection that begins with a JSON
/// request is handed over to the thread that polls handed_over_descriptor() (the main thread), which may be slow.
///
/// Clients are not trusted. The server refuses peers that may_ask() rejects, limits the length of frames, does not read
/// from a slow client until it has taken its answers, and closes a connection after an invalid frame. The number of
/// connections is limited. A few of them, and one descriptor, are reserved for emergency stops (docs/adr/0017).
/// Threads: the constructor, take_handed_over() and the destructor from one thread; stats() from any.
/// Allocates: nothing while the set of clients stays the same.
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
  /// Ends the thread and closes its connections.
  ~ControlServer();

  [[nodiscard]] const std::string& path() const { return claim_.path(); }
  /// Returns a descriptor that is readable when take_handed_over() has a result. Level-triggered; take_handed_over()
  /// resets it.
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
  /// Returns the longest idle client if it has been idle for at least this long. `for_stops`: among the reserved
  /// connections.
  [[nodiscard]] Client* most_idle(bool for_stops, Duration at_least);
  /// Returns when a silent client is closed; nothing: never.
  [[nodiscard]] std::optional<MonotonicTime> end_of(const Client& client) const;
  void send_the_idle_away();
  void dismiss(Client& client, const char* why);
  void remove(Client& client);
  void close(Client& client);
  void note_shortage(bool ran_out);
  void look_at_descriptors();
  [[nodiscard]] int limit_ms() const;
  /// Returns false if the connection was closed or handed over.
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
  std::vector<std::unique_ptr<Connection>> spare_;  // reused, so that a short connection does not allocate
  Guarded<std::vector<HandedOver>> handed_over_;
  std::atomic<bool> is_ending_{false};
  std::atomic<std::uint64_t> accepted_{0}, turned_away_{0}, handed_over_count_{0}, faults_{0};
  std::thread thread_;
};

}  // namespace nacelle::control
