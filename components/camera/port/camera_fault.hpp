// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace nacelle::camera {

/// Why a camera cannot be opened, started or set. Problem::where is the device, unless stated otherwise. If a system call failed, the
/// text has the kernel's words.
enum class CameraFault : std::uint8_t {
  NotThere,          ///< There is no such device node.
  Unplugged,         ///< The device was unplugged while it was open.
  NotPermitted,      ///< The user may not open it.
  Busy,              ///< Another program uses it.
  NoBandwidth,       ///< The USB bus has no bandwidth left for the stream.
  NoMemory,          ///< The driver has no memory for its buffers.
  NotACamera,        ///< The node does not capture video, or cannot stream it.
  NeedsLibcamera,    ///< Its media pipeline is not linked: it is driven by libcamera.
  UnreadableFormat,  ///< It offers no pixel format that this component can read. Value: those that it offers.
  UnusableSize,      ///< It answers with a size that no picture can have. Value: the size.
  OutOfRange,        ///< The value is out of the control's range. Value: the value.
  NotOpen,           ///< The device is not open.
  CannotDraw,  ///< The pattern source cannot draw this pixel format or size. Where: the source. Value: the format or size.
  NoControl,  ///< The source has no such control. Where: the source. Value: its name.
  NotConvertible,  ///< The encoding cannot be made from the camera's format. Where: parameter output_encoding. Value: the encoding.
  MemoryRefused,  ///< The driver does not fill memory of that kind (io_method).
  NotInstalled,  ///< The library that drives this kind of camera is not installed, or is of another version of Nacelle.
  Failed,        ///< A system call failed for another reason.
};
[[nodiscard]] constexpr const char* code_text(CameraFault fault) {
  switch (fault) {
    case CameraFault::NotThere: return "camera.not_there";
    case CameraFault::Unplugged: return "camera.unplugged";
    case CameraFault::NotPermitted: return "camera.not_permitted";
    case CameraFault::Busy: return "camera.busy";
    case CameraFault::NoBandwidth: return "camera.no_bandwidth";
    case CameraFault::NoMemory: return "camera.no_memory";
    case CameraFault::NotACamera: return "camera.not_a_camera";
    case CameraFault::NeedsLibcamera: return "camera.needs_libcamera";
    case CameraFault::UnreadableFormat: return "camera.unreadable_format";
    case CameraFault::UnusableSize: return "camera.unusable_size";
    case CameraFault::OutOfRange: return "camera.out_of_range";
    case CameraFault::NotOpen: return "camera.not_open";
    case CameraFault::CannotDraw: return "camera.cannot_draw";
    case CameraFault::NoControl: return "camera.no_control";
    case CameraFault::NotConvertible: return "camera.not_convertible";
    case CameraFault::MemoryRefused: return "camera.memory_refused";
    case CameraFault::NotInstalled: return "camera.not_installed";
    case CameraFault::Failed: return "camera.failed";
  }
  return "";
}

}  // namespace nacelle::camera
