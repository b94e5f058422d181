// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

#include "nacelle/host/transport.hpp"
#include "support/usage.hpp"

namespace nacelle::bench {

/// What one run of `handover` does.
struct Plan {
  std::string take = "const_ref";  ///< The readers' signature: const_ref, shared, loan.
  std::uint64_t readers = 1;
  std::uint64_t owners = 0;    ///< Further readers that take a Loan.
  std::uint64_t bytes = 0;     ///< Payload; 0: the 44-byte message.
  std::uint64_t messages = 0;  ///< Counted messages.
  std::uint64_t warm = 300;    ///< Messages before the counting begins.
};

/// What the counted messages have cost.
struct Outcome {
  Usage used;
  WriterCounters written;
  std::uint64_t delivered = 0;
};

/// Publisher and readers in components that share one executor thread: each message is published when the one before has been
/// read, from the last reader's callback.
/// `patience`: see Rig; a thread that is single-stepped needs some.
[[nodiscard]] Outcome run_inline(const Plan& plan, Duration patience = Duration{});
/// Two components on threads of their own send each other one message: each finds its reader asleep.
[[nodiscard]] Outcome run_asleep(const Plan& plan);
/// Messages arrive from another thread, in bursts of kBurst, while the reader's executor is in a callback.
[[nodiscard]] Outcome run_busy(const Plan& plan);
inline constexpr std::uint64_t kBurst = 500;

}  // namespace nacelle::bench
