// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <poll.h>

#include <limits>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "control/server.hpp"
#include "requests/late_reply.hpp"
#include "requests/topic_tap.hpp"
#include "text/message_field.hpp"

namespace nacelle::requests {

/// A listener's request.
struct TapWish {
  std::string topic, type;   ///< `type` selects one of several; empty: the topic's.
  bool is_measured = false;  ///< No message may be lost; otherwise it is for display.
  bool is_raw = false;       ///< As bytes, without decoding.
  bool needs_values = true;  ///< False: time and length are enough.
};

/// Answers the requests of a RequestServer: a container, or the nodes of the network (remote/).
/// Threads: the server's.
class Respondent {
 public:
  virtual ~Respondent() = default;
  [[nodiscard]] virtual const Clock& clock() const = 0;
  /// Executes a request. Errors: a reply with "ok": false; nlohmann's exceptions for fields of a wrong type.
  [[nodiscard]] virtual Answer answer(const std::string& verb, const nlohmann::json& request) = 0;
  /// Returns a reader of a topic. Errors: no such topic; not one of its types; an unknown type.
  [[nodiscard]] virtual Result<std::unique_ptr<TopicTap>, Problem> tap(const TapWish& wish) = 0;
  /// Returns why listeners of a topic cannot receive messages, or nothing.
  [[nodiscard]] virtual std::optional<Problem> problem_of(const std::string& /*topic*/) const { return std::nullopt; }
  /// Handles a frame that is not a request; the answer goes to `from.out`.
  virtual void take_frame(control::Connection& from, const control::Frame& frame);
  virtual void has_left(const control::Connection&) {}
};

/// Limits of a server's connections. The default is none.
struct RequestLimits {
  std::size_t guests = std::numeric_limits<std::size_t>::max();
  /// Closes a connection without a subscription or a pending answer after this idle time.
  Duration idle = Duration::max();
  /// If all connections are in use, the longest idle one is closed for a new one after this idle time.
  Duration makes_room_after = 1s;
};

/// Serves JSON requests, one at a time, and streams topics to listening clients.
///
/// Requests are objects with a "verb"; replies have "ok" and, if that is false, "problem". An exception in a request
/// becomes its refusal.
/// Threads: one.
class RequestServer {
 public:
  explicit RequestServer(std::unique_ptr<Respondent> own, RequestLimits limits);
  /// `respondent` must outlive this object.
  explicit RequestServer(Respondent& respondent, RequestLimits limits = {});
  ~RequestServer();

  void take(control::ControlServer::HandedOver handed);
  void take(std::unique_ptr<control::Connection> connection);
  /// Appends the descriptors to poll. They are open, because poll() fails on more entries than the limit of open files.
  /// If there is no memory for the list, throws and leaves the list unchanged.
  void append_waits(std::vector<pollfd>& waits);
  /// Serves the ready connections. `waits`: the entries of the last append_waits(). Does nothing if that threw.
  void serve(const pollfd* waits);
  /// Closes the connections that listen to a topic whose messages cannot arrive (Respondent::problem_of()). Do not call
  /// it between append_waits() and serve().
  void end_hopeless_listening();
  /// Closes the newer half of the connections and sends them the reason.
  void send_half_away(const char* why);
  /// Returns when serve() must run although no descriptor is ready: at the next timeout of a connection.
  [[nodiscard]] std::optional<MonotonicTime> next_due() const;

 private:
  /// The form of each item. Sizes: "<time> <bytes>"; Ages: "<time> <age of header.stamp>"; Times: the time of
  /// publish(). Times and ages are in ns. Raw: the bytes in hexadecimal.
  enum class Show { Yaml, Json, Times, Sizes, Ages, Transforms, Raw };
  struct Guest {
    std::unique_ptr<control::Connection> connection;
    std::unique_ptr<TopicTap> tap;
    std::unique_ptr<LateReply> late;  // its next request is not read before this one is answered
    Show show = Show::Yaml;
    std::optional<text::MessageField> field;  // for Yaml and Json; none: the whole message
    std::size_t longest = 128;
    MonotonicTime said_at{};
    bool waits_for_tap = false, waits_for_answer = false;  // set by append_waits()
    short events = 0;                                      // results of poll(): of the connection
    bool has_message = false, has_answer = false;          // of the tap and of the answer
    bool gone = false;
  };

  [[nodiscard]] static Show show_of(const std::string& word);
  /// Calls act(). An exception closes this connection only.
  template <typename Act>
  void guarded(Guest& guest, Act act);
  /// Closes the longest idle connection. Returns false if none is idle.
  [[nodiscard]] bool make_room();
  void take_leave(Guest& guest, const char* why);
  [[nodiscard]] std::optional<MonotonicTime> end_of(const Guest& guest) const;
  void serve(Guest& guest);
  void remove_the_gone();
  void answer(Guest& guest, const std::string& request);
  [[nodiscard]] Answer reply_to(Guest& guest, const nlohmann::json& request);
  [[nodiscard]] nlohmann::json listen(Guest& guest, const nlohmann::json& request);
  void send(Guest& guest, const nlohmann::json& reply);
  void finish(Guest& guest);
  void read(Guest& guest);
  void stream(Guest& guest);
  void append_item(const Guest& guest, const Block& block);

  const std::unique_ptr<Respondent> own_;  // null: the caller owns it
  Respondent& respondent_;
  const RequestLimits limits_;
  std::vector<Guest> guests_;
  bool has_listed_ = false;  // between a complete append_waits() and serve()
  std::string text_;
};

}  // namespace nacelle::requests
