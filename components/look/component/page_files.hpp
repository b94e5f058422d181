// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <string>

#include "look/port/web_server.hpp"

namespace nacelle::look {

/// The files of the folder page, by their paths. Made at build time by embed_page.py.
[[nodiscard]] std::map<std::string, WebServer::File, std::less<>> page_files();

}  // namespace nacelle::look
