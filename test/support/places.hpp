// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>
#include <string_view>

/// Where tests find files. Paths of the checkout are compiled into this one library only: a compiler cache that another clone
/// has filled then serves every test.
namespace nacelle::test {

/// A file or folder of the checkout, as source("docs/launch_files.md").
[[nodiscard]] std::string source(std::string_view path);
/// A file or folder of test/data.
[[nodiscard]] std::string data(std::string_view path);
/// A file or folder that the build made, as built("test/peers/cyclone_peer").
[[nodiscard]] std::string built(std::string_view path);
/// The folder of the components.
[[nodiscard]] std::string component_folder();
/// The folder of the message libraries.
[[nodiscard]] std::string message_libraries();

}  // namespace nacelle::test
