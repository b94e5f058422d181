// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "answers/robot.hpp"
#include "desk/verb_desk.hpp"
#include "nacelle/msgs/type_library.hpp"

namespace nacelle::answers {

/// Answers the requests of a desk for the container of this process. Ownership: the session must outlive it.
class OwnContainer final : public desk::Respondent {
 public:
  explicit OwnContainer(Robot& robot);
  [[nodiscard]] const Clock& clock() const override;
  [[nodiscard]] desk::Answer answer(const std::string& verb, const nlohmann::json& request) override;
  [[nodiscard]] Result<std::unique_ptr<desk::TopicTap>, Problem> tap(const desk::TapWish& wish) override;

 private:
  [[nodiscard]] Result<const msgs::MessageType*, Problem> type_of(const desk::TapWish& wish);

  Robot& robot_;
  msgs::TypeLibrary types_;
};

}  // namespace nacelle::answers
