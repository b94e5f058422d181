// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "nacelle/base/guarded.hpp"
#include "nacelle/base/problem.hpp"
#include "nacelle/base/result.hpp"
#include "nacelle/control/frame.hpp"
#include "nacelle/control/socket_path.hpp"
#include "nacelle/control/wire.hpp"

namespace nacelle::control {

/// What clients ask for at a rate. Threads: called on the control thread only.
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
  /// Somebody wants the robot stopped in order. Returns at once.
  virtual void request_shutdown() = 0;
};

/// Longest payload that a client may send.
inline constexpr std::size_t kLongestRequest = 1U << 20U;

/// A connected client: its descriptor, what it sent and what it has not taken yet.
class Connection {
 public:
  explicit Connection(int descriptor);
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;
  ~Connection();

  [[nodiscard]] int descriptor() const { return descriptor_; }
  /// Begins anew with another peer, with the memory of the last one.
  void reuse_for(int descriptor);
  /// Takes in what has come. False when the peer is gone.
  [[nodiscard]] bool read_some();
  /// Sends what it can without waiting. False when the peer is gone.
  [[nodiscard]] bool write_some();
  [[nodiscard]] bool wants_to_write() const { return sent_ < out.size(); }
  /// True while so much waits to be sent that no more should be made for this client.
  [[nodiscard]] bool is_slow() const { return out.size() - sent_ > kSlowBytes; }

  FrameReader in{kLongestRequest};
  std::string out;

 private:
  static constexpr std::size_t kSlowBytes = 256U << 10U;
  int descriptor_;
  std::size_t sent_ = 0;
};

/// The control socket's own thread, "control": it accepts clients and answers what runs at a rate. Connections that begin with
/// a JSON request are handed over to whoever polls handed_over_descriptor() (the main thread), which may take its time.
///
/// Every client is untrusted: frames are bounded, a slow one is not read until it has taken its answers, and garbage ends it.
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

  ControlServer(SocketClaim claim, FastService& service);
  ControlServer(const ControlServer&) = delete;
  ControlServer& operator=(const ControlServer&) = delete;
  /// Ends the thread and every connection it still has.
  ~ControlServer();

  [[nodiscard]] const std::string& path() const { return claim_.path(); }
  /// Readable when take_handed_over() has something. Level-triggered; take_handed_over() resets it.
  [[nodiscard]] int handed_over_descriptor() const { return handed_over_event_; }
  [[nodiscard]] std::vector<HandedOver> take_handed_over();
  [[nodiscard]] Stats stats() const;

 private:
  struct Client {
    std::unique_ptr<Connection> connection;
    std::vector<std::uint16_t> writers;
  };
  void run();
  void accept_all();
  void close(Client& client);
  /// False when the connection is not ours any more: closed, or handed over.
  [[nodiscard]] bool serve(Client& client, short events);
  [[nodiscard]] bool answer(Client& client, const Frame& frame);
  void refuse(Client& client, const char* why);

  SocketClaim claim_;
  FastService& service_;
  int stop_event_ = -1, handed_over_event_ = -1;
  std::vector<Client> clients_;
  std::vector<std::unique_ptr<Connection>> spare_;  // so that a client that only looks whether we live costs no heap
  Guarded<std::vector<HandedOver>> handed_over_;
  std::atomic<std::uint64_t> accepted_{0}, turned_away_{0}, handed_over_count_{0}, faults_{0};
  std::thread thread_;
};

}  // namespace nacelle::control
