// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <poll.h>

#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "nacelle/control/server.hpp"
#include "nacelle/msgs/type_library.hpp"
#include "nacelle/session/late_reply.hpp"
#include "nacelle/session/message_field.hpp"
#include "nacelle/session/topic_tap.hpp"

namespace nacelle::session {

class Session;

/// Serves the control socket's JSON requests on the main thread, one at a time, and streams topics to those who listen.
///
/// Requests are objects with a "verb"; replies have "ok" and, if that is false, "problem".
/// Threads: one.
class VerbDesk {
 public:
  explicit VerbDesk(Session& session);
  ~VerbDesk();

  void take(control::ControlServer::HandedOver handed);
  /// What to wait for; the same order is expected by serve().
  void append_waits(std::vector<pollfd>& waits) const;
  void serve(const pollfd* waits, std::size_t count);
  /// When serve() has something to do though nothing happens: somebody has waited long enough.
  [[nodiscard]] std::optional<MonotonicTime> next_due() const;

 private:
  /// Sizes: "<time> <bytes>", Ages: "<time> <age of header.stamp>", in ns but for the bytes; Times: the time of publish() alone.
  enum class Show { Yaml, Json, Times, Sizes, Ages, Transforms };
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

  Session& session_;
  msgs::TypeLibrary types_;
  std::vector<Guest> guests_;
  std::string text_;
};

}  // namespace nacelle::session
