// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace nacelle::runtime {

/// Why a component cannot be loaded. Problem::where is the component or the library's file. Problem::value is the
/// class, or the file if the fault is the library's.
enum class PluginFault : std::uint8_t {
  UnknownClass,        ///< No index of the plugin folders lists the class.
  NoLibrary,           ///< The library that an index lists does not exist, or cannot be read.
  OverwrittenLibrary,  ///< The library was overwritten in place while its code is loaded.
  NotLinked,           ///< The dynamic linker refuses the library, e.g. for a missing symbol; the text has its message.
  TooManyFiles,        ///< The process or the machine has no free file descriptor for the library.
  NotAComponentLibrary,  ///< The library has no entry point of components.
  OtherAbi,              ///< The library was built for another component ABI.
  ClassNotInLibrary,     ///< The library does not contain the class that an index lists for it.
  FailedConstructor,     ///< The constructor threw, or made no node; the text has the exception's message.
  NoThread,              ///< No thread can be started to run the library's code.
  TimedOut,  ///< The library's start-up code or the constructor has not returned within the transition timeout.
};
[[nodiscard]] constexpr const char* code_text(PluginFault fault) {
  switch (fault) {
    case PluginFault::UnknownClass: return "plugin.unknown_class";
    case PluginFault::NoLibrary: return "plugin.no_library";
    case PluginFault::OverwrittenLibrary: return "plugin.overwritten_library";
    case PluginFault::NotLinked: return "plugin.not_linked";
    case PluginFault::TooManyFiles: return "plugin.too_many_files";
    case PluginFault::NotAComponentLibrary: return "plugin.not_a_component_library";
    case PluginFault::OtherAbi: return "plugin.other_abi";
    case PluginFault::ClassNotInLibrary: return "plugin.class_not_in_library";
    case PluginFault::FailedConstructor: return "plugin.failed_constructor";
    case PluginFault::NoThread: return "plugin.no_thread";
    case PluginFault::TimedOut: return "plugin.timed_out";
  }
  return "";
}

}  // namespace nacelle::runtime
