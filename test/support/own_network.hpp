// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace nacelle::test {

/// Puts this process into a network of its own, in which there is nothing but a loopback interface: what other tests,
/// robots and machines send does not come here. Processes and threads that are started afterwards are in it too. Call
/// it before there are threads. Errors: false where the kernel does not allow it; then everything stays as it was.
[[nodiscard]] bool enter_own_network();

}  // namespace nacelle::test
