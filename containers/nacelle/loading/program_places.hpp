// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace nacelle::loading {

/// The folders of an installed or freshly built program.
struct ProgramPlaces {
  std::string program;                         ///< The running `nacelle`.
  std::vector<std::string> component_folders;  ///< NACELLE_COMPONENT_PATH, ../lib/nacelle, ../lib/<arch>/nacelle.
  std::vector<std::filesystem::path> message_folders;
  std::vector<std::string> prefixes;  ///< For a foreign node's <prefix>/lib/<package>/<program>.
};

}  // namespace nacelle::loading
