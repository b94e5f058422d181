// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "loading/program_places.hpp"
#include "nacelle/base/time.hpp"
#include "process/stop_signal.hpp"

namespace nacelle::isolation {

/// Runs the process of an isolated component: a container with that component only, linked over `socket` to the
/// container that started it (isolated_component.hpp). Blocks until the socket is closed or a signal requests the end.
/// Then shuts the component down in order and returns the exit code.
/// Threads: the main thread.
[[nodiscard]] int run_isolated(int socket, const std::string& name, const std::string& carrier,
                               const loading::ProgramPlaces& places, const Clock& clock,
                               const process::StopSignal& stop);

}  // namespace nacelle::isolation
