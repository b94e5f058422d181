// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "camera/port/capture_port.hpp"

namespace nacelle::camera {

/// What the function kPortSymbol returns, which a library with a port exports with C linkage: `const PortEntry* ()`.
///
/// The library is built with the component and installed apart from it, so that only those who want its cameras need the libraries
/// that it links.
struct PortEntry {
  std::uint32_t abi;                   ///< kPortAbi.
  CapturePort* (*make)(const Clock&);  ///< The caller owns the port. The clock outlives it.
};
inline constexpr const char* kPortSymbol = "nacelle_capture_port";
/// Raised whenever CapturePort, or a type that it passes, changes.
inline constexpr std::uint32_t kPortAbi = 1;

/// Returns where the library of a port is installed, "libcamera": in nacelle/ports beside libnacelle_base.so. Empty if that is not
/// loaded as a library.
[[nodiscard]] std::string port_library_path(const std::string& name);

/// Makes the port of a library, which is never unloaded: frames that are out have hooks in its code.
///
/// Without the library, or with one of another version, open() of what is returned fails with CameraFault::NotInstalled.
[[nodiscard]] std::unique_ptr<CapturePort> make_port_of(const std::string& library, const Clock& clock);

}  // namespace nacelle::camera
