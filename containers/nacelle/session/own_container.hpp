// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "nacelle/msgs/type_library.hpp"
#include "nacelle/session/verb_desk.hpp"

namespace nacelle::session {

/// The container of this process, at its desk. Ownership: the session outlives it.
class OwnContainer final : public Respondent {
 public:
  explicit OwnContainer(Session& session);
  [[nodiscard]] const Clock& clock() const override;
  [[nodiscard]] Answer answer(const std::string& verb, const nlohmann::json& request) override;
  [[nodiscard]] Result<std::unique_ptr<TopicTap>, Problem> tap(const TapWish& wish) override;

 private:
  [[nodiscard]] Result<const msgs::MessageType*, Problem> type_of(const TapWish& wish);

  Session& session_;
  msgs::TypeLibrary types_;
};

}  // namespace nacelle::session
