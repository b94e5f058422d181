// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "answers/robot.hpp"
#include "nacelle/msgs/type_library.hpp"
#include "requests/request_server.hpp"

namespace nacelle::answers {

/// Answers the requests of a RequestServer for the container of this process. The robot must outlive this object.
class OwnContainer final : public requests::Respondent {
 public:
  explicit OwnContainer(Robot& robot);
  [[nodiscard]] const Clock& clock() const override;
  [[nodiscard]] requests::Answer answer(const std::string& verb, const nlohmann::json& request) override;
  [[nodiscard]] Result<std::unique_ptr<requests::TopicTap>, Problem> tap(const requests::TapWish& wish) override;

 private:
  [[nodiscard]] Result<const msgs::MessageType*, Problem> type_of(const requests::TapWish& wish);

  Robot& robot_;
  msgs::TypeLibrary types_;
};

}  // namespace nacelle::answers
