// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <poll.h>

#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "nacelle/control/server.hpp"
#include "nacelle/msgs/type_library.hpp"
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

 private:
  enum class Show { Yaml, Json, Times, Transforms };
  struct Guest {
    std::unique_ptr<control::Connection> connection;
    std::unique_ptr<TopicTap> tap;
    Show show = Show::Yaml;
    std::size_t longest = 128;
    bool gone = false;
  };

  void answer(Guest& guest, const std::string& request);
  [[nodiscard]] nlohmann::json reply_to(Guest& guest, const nlohmann::json& request);
  void read(Guest& guest);
  void stream(Guest& guest);

  Session& session_;
  msgs::TypeLibrary types_;
  std::vector<Guest> guests_;
  std::string text_;
};

}  // namespace nacelle::session
