// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <poll.h>

#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "nacelle/control/server.hpp"
#include "nacelle/session/late_reply.hpp"
#include "nacelle/session/message_field.hpp"
#include "nacelle/session/topic_tap.hpp"

namespace nacelle::session {

class Session;

/// What a listener asks for.
struct TapWish {
  std::string topic, type;   ///< `type`: of a topic with several; empty: the topic's.
  bool is_measured = false;  ///< Nothing must be lost; else a person reads it.
  bool is_raw = false;       ///< As bytes: its values are not wanted.
  bool needs_values = true;  ///< False: only when it came and how long it is.
};

/// Who answers at a desk: a container, or the nodes of the network (remote/).
/// Threads: the desk's.
class Respondent {
 public:
  virtual ~Respondent() = default;
  [[nodiscard]] virtual const Clock& clock() const = 0;
  /// Errors: a reply with "ok": false; nlohmann's exceptions for fields of a wrong type.
  [[nodiscard]] virtual Answer answer(const std::string& verb, const nlohmann::json& request) = 0;
  /// Errors: no such topic, a type that it has not, or that nobody here knows.
  [[nodiscard]] virtual Result<std::unique_ptr<TopicTap>, Problem> tap(const TapWish& wish) = 0;
  /// A frame that is no request; what is to be said to it goes to `from.out`.
  virtual void take_frame(control::Connection& from, const control::Frame& frame);
  virtual void has_left(const control::Connection&) {}
};

/// Serves JSON requests, one at a time, and streams topics to those who listen.
///
/// Requests are objects with a "verb"; replies have "ok" and, if that is false, "problem".
/// Threads: one.
class VerbDesk {
 public:
  /// For the container of this process.
  explicit VerbDesk(Session& session);
  /// `respondent` outlives it.
  explicit VerbDesk(Respondent& respondent);
  ~VerbDesk();

  void take(control::ControlServer::HandedOver handed);
  void take(std::unique_ptr<control::Connection> connection);
  /// What to wait for; the same order is expected by serve().
  void append_waits(std::vector<pollfd>& waits) const;
  void serve(const pollfd* waits, std::size_t count);
  /// When serve() has something to do though nothing happens: somebody has waited long enough.
  [[nodiscard]] std::optional<MonotonicTime> next_due() const;

 private:
  /// Sizes: "<time> <bytes>", Ages: "<time> <age of header.stamp>", in ns but for the bytes; Times: the time of publish() alone.
  /// Raw: the bytes in hexadecimal.
  enum class Show { Yaml, Json, Times, Sizes, Ages, Transforms, Raw };
  struct Guest {
    std::unique_ptr<control::Connection> connection;
    std::unique_ptr<TopicTap> tap;
    std::unique_ptr<LateReply> late;  // its next request is not looked at before this one is answered
    Show show = Show::Yaml;
    std::optional<MessageField> field;  // of Yaml and Json: all of the message without it
    std::size_t longest = 128;
    bool gone = false;
  };

  [[nodiscard]] static Show show_of(const std::string& word);
  void answer(Guest& guest, const std::string& request);
  [[nodiscard]] Answer reply_to(Guest& guest, const nlohmann::json& request);
  [[nodiscard]] nlohmann::json listen(Guest& guest, const nlohmann::json& request);
  void send(Guest& guest, const nlohmann::json& reply);
  void finish(Guest& guest, bool answered);
  void read(Guest& guest);
  void stream(Guest& guest);
  void append_item(const Guest& guest, const Block& block);

  const std::unique_ptr<Respondent> own_;  // null: somebody else's
  Respondent& respondent_;
  std::vector<Guest> guests_;
  std::string text_;
};

}  // namespace nacelle::session
