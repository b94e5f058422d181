// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <fstream>

#include "in_machine.hpp"

namespace nacelle::test {

/// Two cameras of libcamera, which draw bars in NV12.
inline void make_virtual_cameras() {
  const std::filesystem::path folder = "/usr/share/libcamera/pipeline/virtual";
  std::filesystem::create_directories(folder);
  std::ofstream file{folder / "virtual.yaml"};
  for (const char* const name : {"Front", "Back"}) {
    file << '"' << name << "\":\n  supported_formats:\n";
    for (const char* const size : {"  - width: 320\n    height: 240\n", "  - width: 640\n    height: 480\n"})
      file << size << "    frame_rates:\n    - 10\n    - 30\n";
    file << "  test_pattern: \"bars\"\n  location: \""
         << (name[0] == 'F' ? "CameraLocationFront" : "CameraLocationBack") << "\"\n  model: \"Virtual " << name
         << "\"\n";
  }
}

}  // namespace nacelle::test

/// The first line of a SetUp(). The virtual pipeline's buffers are dma-bufs of the kernel's udmabuf.
#define NACELLE_WITH_VIRTUAL_CAMERAS()                                                                  \
  NACELLE_ONLY_IN_MACHINE("libcamera");                                                                 \
  if (!std::filesystem::exists("/dev/udmabuf"))                                                         \
    GTEST_SKIP() << "this kernel has no udmabuf, Debian 13's has: ./dev vm --release trixie libcamera"; \
  ::nacelle::test::make_virtual_cameras()
