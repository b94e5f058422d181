// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "nacelle/base/problem.hpp"
#include "nacelle/base/result.hpp"
#include "nacelle/msgs/type_library.hpp"
#include "nacelle/runtime/container.hpp"
#include "nacelle/session/late_reply.hpp"

namespace nacelle::session {

class Session;

/// The most bytes of a parameter file that a command sends with component.load_plugin; escaped, they fit into a request.
inline constexpr std::size_t kMostParamsText = 448U << 10U;

/// Returns what component.load_plugin asks for, its namespace below another. The request holds the text of its parameter file
/// (`params_text`; `params_file` is its name). Errors: a parameter or rule that cannot be read, a file without its text.
[[nodiscard]] Result<runtime::LoadRequest, Problem> plugin_request_of(const nlohmann::json& request,
                                                                      const std::string& below);

/// Carries out one request of the control socket and says how it went. Loading, unloading and transitions take as long as a component
/// takes; what else waits for one is answered later.
/// Errors: a reply with "ok": false; nlohmann's exceptions for fields of a wrong type.
[[nodiscard]] Answer reply_to_verb(Session& session, msgs::TypeLibrary& types, const std::string& verb,
                                   const nlohmann::json& request);

}  // namespace nacelle::session
