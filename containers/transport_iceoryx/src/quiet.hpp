// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "iceoryx_posh/runtime/posh_runtime.hpp"

// By default iceoryx writes to the terminal and ends the process on fatal errors. These functions prevent both.
namespace nacelle::transport_iceoryx {

/// Redirects iceoryx's errors to Nacelle's log, each kind once, and keeps them from ending the process. Threads: any.
void take_over_errors();
/// Returns the last error that iceoryx raised on this thread since the last call, by name; empty: none. Threads: any.
[[nodiscard]] const char* last_error();
/// From now until park_no_longer(), a fatal error of iceoryx on this thread calls `told` and then blocks the thread
/// forever: iceoryx would next use memory that it failed to allocate.
void park_this_thread_on_fatal_errors(void (*told)(void* context, const char* error), void* context);
void park_no_longer();

/// Ends iceoryx's thread that sends a keep-alive to the daemon every 300 ms. Once the daemon is gone, each attempt
/// would write an error to stderr.
void stop_greeting(iox::runtime::PoshRuntime& runtime);

}  // namespace nacelle::transport_iceoryx
