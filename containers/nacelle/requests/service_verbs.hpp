// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "nacelle/base/problem.hpp"
#include "nacelle/base/result.hpp"
#include "nacelle/base/time.hpp"
#include "nacelle/msgs/type_library.hpp"
#include "nacelle/runtime/introspection.hpp"
#include "requests/late_reply.hpp"

namespace nacelle::requests {

/// As runtime::Container::call_service().
using StartCall = std::function<Result<std::unique_ptr<runtime::ServiceCall>, Problem>(
    const std::string& name, const msgs::ServiceType& type, void* request, std::function<void()> on_answer)>;

/// Calls a service: {"service", "type", "request": message as JSON, "timeout_s"} is answered with "response". "limit_option": the
/// command's option that allows more time, for the message of a timeout.
///
/// The call is a message to its server. A slow or hanging server delays its caller only. `see` is a hint for the case
/// of no answer: "see `nacelle faults`", or nothing.
[[nodiscard]] Answer call_service(const Clock& clock, const StartCall& start, msgs::TypeLibrary& types,
                                  const nlohmann::json& request, const std::string& see);

}  // namespace nacelle::requests
