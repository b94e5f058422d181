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

/// Calls a service: {"service", "type", "request": message as JSON, "timeout_s"} is answered with "response".
/// "limit_option" names the command's option that allows more time; the message of a timeout mentions it.
///
/// The call is a message to its server, so a slow or hanging server delays its caller only. `see`: a hint for the case
/// of no answer, such as "see `nacelle faults`", or empty.
[[nodiscard]] Answer call_service(const Clock& clock, const StartCall& start, msgs::TypeLibrary& types,
                                  const nlohmann::json& request, const std::string& see);

}  // namespace nacelle::requests
