// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>

#include "nacelle/base/time.hpp"

namespace nacelle::camera {

/// What ended a wait for the device.
struct DeviceWait {
  bool ready = false;     ///< A call to dequeue would answer at once: a frame or an error.
  bool in_error = false;  ///< The device says so itself (not streaming, nothing queued, unplugged).
  bool woken = false;     ///< The bell rang.
};

/// The kernel's calls that V4l2Capture makes, as one small interface: a script can play any device and any fault.
///
/// Every call answers what the kernel would, with -errno for a failure. Threads: any. Allocates: nothing.
class V4l2Calls {
 public:
  V4l2Calls() = default;
  V4l2Calls(const V4l2Calls&) = delete;
  V4l2Calls& operator=(const V4l2Calls&) = delete;
  virtual ~V4l2Calls() = default;

  /// A descriptor, or -errno.
  [[nodiscard]] virtual int open(const char* device) = 0;
  virtual void close(int descriptor) = 0;
  /// 0 or -errno. Interrupted calls are repeated by the caller.
  [[nodiscard]] virtual int control(int descriptor, unsigned long request, void* argument) = 0;
  /// Null on failure.
  [[nodiscard]] virtual void* map(int descriptor, std::size_t length, std::uint32_t offset) = 0;
  /// Whole pages of this process's own memory; null on failure. unmap() gives them back.
  [[nodiscard]] virtual void* allocate(std::size_t length) = 0;
  virtual void unmap(void* memory, std::size_t length) = 0;
  /// Puts memory of this process with the same content in place of mapped memory, at the same address: threads that read it see no
  /// difference, and the mapping no longer keeps the device's file open. Returns false, and changes nothing, without memory for it.
  virtual bool detach(void* memory, std::size_t length) = 0;
  /// Waits until the device or the bell has something, at most `longest`. `bell` is an eventfd; it is not read. A
  /// device of -1 waits for the bell alone.
  [[nodiscard]] virtual DeviceWait wait(int descriptor, int bell, Duration longest) = 0;
};

/// The real ones.
[[nodiscard]] std::shared_ptr<V4l2Calls> kernel_calls();

}  // namespace nacelle::camera
