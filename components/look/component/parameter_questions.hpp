// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <list>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "look/component/robot_requests.hpp"
#include "look/protocol/client_message.hpp"
#include "nacelle/base/time.hpp"

namespace nacelle::look {

/// Asks the nodes of a container for their parameters, by their services, and sets them. A parameter is named "/node.parameter".
///
/// A node that does not answer within kPatience is left out of the answer. Threads: the component's executor.
class ParameterQuestions {
 public:
  static constexpr Duration kPatience = 2s;

  explicit ParameterQuestions(RobotRequests& requests) : requests_(requests) {}

  /// `parameters`: in the protocol's form; `problems`: what could not be done, in words.
  using Take = std::function<void(nlohmann::json parameters, const std::vector<std::string>& problems)>;
  /// `names` empty: all parameters of `nodes`.
  void get(const std::vector<std::string>& names, const std::vector<std::string>& nodes, MonotonicTime now, Take take);
  /// Sets them, and hands over what they are then.
  void set(const std::vector<SetParameters::One>& wishes, MonotonicTime now, Take take);
  /// Gives up on what has waited too long. Returns whether something waits.
  bool look_at_time(MonotonicTime now);

 private:
  struct Question {
    Take take;
    MonotonicTime until;
    std::size_t waiting = 0;
    nlohmann::json parameters = nlohmann::json::array();
    std::vector<std::string> problems;
    bool is_over = false;
  };
  using Shared = std::shared_ptr<Question>;
  [[nodiscard]] Shared begin(MonotonicTime now, Take take);
  void list(const Shared& question, const std::string& node);
  void get(const Shared& question, const std::string& node, const std::vector<std::string>& names);
  void answered(const Shared& question);
  void end(Question& question);

  RobotRequests& requests_;
  std::list<Shared> open_;
};

/// "/ns/node" and "a.b" of "/ns/node.a.b".
struct ParameterName {
  std::string node, parameter;
};
[[nodiscard]] ParameterName parameter_name(const std::string& name);

}  // namespace nacelle::look
