// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "nacelle/qos/qos.hpp"

namespace nacelle {

enum class Verdict : std::uint8_t {
  Ok,       ///< The pair matches.
  Warning,  ///< Whether it matches depends on a value that is not known here.
  Error     ///< The subscription gets nothing from this publisher.
};

/// One policy that keeps, or may keep, a publisher and a subscription apart.
struct Clash {
  Verdict severity = Verdict::Error;
  std::string policy;     ///< "reliability", "durability", "deadline", "liveliness", "liveliness_lease_duration"
  std::string offered;    ///< The publisher's value, as text.
  std::string requested;  ///< The subscription's value, as text.
  std::string change;     ///< What mends it, in words.

  /// "reliability: the publisher offers best_effort, the subscription requests reliable; <change>"
  [[nodiscard]] std::string text() const;
  /// What is wrong, with the names of the nodes; without the change.
  [[nodiscard]] std::string between(const std::string& publisher, const std::string& subscription) const;
  friend bool operator==(const Clash&, const Clash&) = default;
};

/// The answer for one pair. As with rmw, warnings are left out where there is an error.
struct Compatibility {
  Verdict verdict = Verdict::Ok;
  std::vector<Clash> clashes;

  explicit operator bool() const { return verdict != Verdict::Error; }
  /// All clashes, one per line; "ok" without any.
  [[nodiscard]] std::string text() const;
};

/// Whether a publisher with `offered` serves a subscription with `requested`.
///
/// History, depth and lifespan never matter. A value that is system_default or unknown gives at most a warning (two
/// QoS(10) do, by their liveliness): pass resolved() values where the defaults are Nacelle's own.
/// best_available follows the other side and never clashes.
/// Threads: pure. Allocates: only for clashes.
/// Source: rmw_qos_profile_check_compatible, rmw_dds_common/src/qos.cpp (jazzy).
[[nodiscard]] Compatibility check(const QoS& offered, const QoS& requested);

/// The same answer without its words. Allocates: nothing.
[[nodiscard]] Verdict verdict_of(const QoS& offered, const QoS& requested);

/// best_available made concrete from the publishers known now; none known: reliable, transient_local, automatic.
/// Source: rmw_dds_common/src/qos.cpp (jazzy).
[[nodiscard]] QoS best_available_for_subscription(QoS subscription, std::span<const QoS> publishers);
/// The same for a publisher: reliable and transient_local serve everybody.
[[nodiscard]] QoS best_available_for_publisher(QoS publisher, std::span<const QoS> subscriptions);

}  // namespace nacelle
