// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "iceoryx_posh/runtime/posh_runtime.hpp"

// iceoryx talks to the terminal and stops the process by itself; here it is taught neither.
namespace nacelle::transport_iceoryx {

/// Redirects iceoryx's errors to Nacelle's log, each kind once, and keeps them from ending the process. Threads: any.
void take_over_errors();
/// The name of the last error that iceoryx raised on this thread; empty when none since the last call. Threads: any.
[[nodiscard]] const char* last_error();
/// While true, a fatal error on this thread stops this thread for good, once `told` has been called: what iceoryx would do next
/// is to use memory that it has not got.
void park_this_thread_on_fatal_errors(void (*told)(void* context, const char* error), void* context);
void park_no_longer();

/// Ends the thread that greets the daemon every 300 ms, and that would complain to stderr each time once it is gone.
void stop_greeting(iox::runtime::PoshRuntime& runtime);

}  // namespace nacelle::transport_iceoryx
