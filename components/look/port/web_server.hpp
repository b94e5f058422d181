// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "nacelle/base/bytes.hpp"
#include "nacelle/base/mutex.hpp"
#include "nacelle/base/problem.hpp"
#include "nacelle/base/result.hpp"
#include "nacelle/base/time.hpp"

struct lws;
struct lws_context;

namespace nacelle::look {

/// One connection while it lives; never used again.
using ViewerId = std::uint64_t;

/// What a viewer's program says when it asks for a WebSocket. The views are valid during the call.
struct Handshake {
  std::string_view host, origin, token;  ///< The headers; the query's "token". Empty: there is none.
};

/// Takes what happens at the connections. Threads: the server's.
class WebHandler {
 public:
  virtual ~WebHandler() = default;
  /// Returns whether pages of this host are given out.
  [[nodiscard]] virtual bool takes_host(std::string_view host) = 0;
  /// Returns the HTTP status of a refusal; 0: welcome.
  [[nodiscard]] virtual unsigned refusal_of(const Handshake& handshake) = 0;
  virtual void on_open(ViewerId viewer, const Handshake& handshake) = 0;
  /// A whole message. Returns false to end the connection.
  [[nodiscard]] virtual bool on_message(ViewerId viewer, bool is_binary, ByteView bytes) = 0;
  virtual void on_close(ViewerId viewer) = 0;
  /// Appends the next frame to `out`, if there is one that may be sent now; sets `is_binary`.
  [[nodiscard]] virtual bool next(ViewerId viewer, bool& is_binary, Bytes& out) = 0;
  virtual void on_tick() = 0;
};

/// An HTTP server with files from memory and WebSockets of the Foxglove protocol, by libwebsockets.
///
/// Threads: run() and the calls of the handler are on one thread, as is everything but post(), stop() and port().
class WebServer {
 public:
  struct File {
    std::string media_type;
    Bytes body;
  };
  struct Options {
    std::string address = "127.0.0.1";  ///< Of an interface, or the interface's name; empty: all.
    std::uint16_t port = 8080;          ///< 0: one that is free.
    std::uint32_t most_viewers = 100;
    std::size_t most_message_bytes = std::size_t{1} << 20U;
    std::map<std::string, File, std::less<>> files;  ///< By path: "/", "/main.js".
  };
  /// Listens. The handler outlives the server. Errors: the address is not this machine's, or the port is in use.
  [[nodiscard]] static Result<std::unique_ptr<WebServer>, Problem> listen(Options options, WebHandler& handler);
  WebServer(const WebServer&) = delete;
  WebServer& operator=(const WebServer&) = delete;
  ~WebServer();

  [[nodiscard]] std::uint16_t port() const { return port_; }
  /// Serves until stop().
  void run();
  /// Ends run(). Threads: any.
  void stop();
  /// Runs it on the server's thread. Threads: any, with locks held.
  void post(std::function<void()> work);

  /// Has next() called as soon as the connection takes more.
  void ask_to_write(ViewerId viewer);
  void close(ViewerId viewer);
  /// Calls on_tick() with this period; zero: not at all.
  void tick_every(Duration period);

 private:
  struct Connection;
  struct Callbacks;
  struct Timer;
  WebServer(Options options, WebHandler& handler);
  void take_posts();

  const Options options_;
  WebHandler& handler_;
  std::uint16_t port_ = 0;
  lws_context* context_ = nullptr;
  std::map<ViewerId, Connection> connections_;
  std::map<lws*, ViewerId> by_socket_;
  std::map<lws*, std::pair<const Bytes*, std::size_t>> sending_;  // files, with what has gone of them
  ViewerId last_viewer_ = 0;
  std::unique_ptr<Timer> timer_;
  Bytes scratch_;

  Mutex mutex_;
  std::vector<std::function<void()>> posts_ NACELLE_GUARDED_BY(mutex_);
  bool is_ending_ NACELLE_GUARDED_BY(mutex_) = false;
};

}  // namespace nacelle::look
