// SPDX-License-Identifier: Apache-2.0
#include "support/places.hpp"

namespace nacelle::test {

std::string source(std::string_view path) { return std::string{NACELLE_SOURCE_DIR "/"}.append(path); }
std::string data(std::string_view path) { return source("test/data/").append(path); }
std::string built(std::string_view path) { return std::string{NACELLE_BINARY_DIR "/"}.append(path); }
std::string component_folder() { return built("lib/nacelle"); }
std::string message_libraries() { return NACELLE_MSGS_LIBRARIES; }

}  // namespace nacelle::test
