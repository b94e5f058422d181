// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>

#include "nacelle/base/time.hpp"

namespace nacelle {

// Values as in rmw's types.h (jazzy), so that they can go over the wire and into ROS 2's graph messages unchanged.
enum class Reliability : std::uint8_t {
  SystemDefault = 0,
  Reliable = 1,
  BestEffort = 2,
  Unknown = 3,
  BestAvailable = 4
};
enum class Durability : std::uint8_t {
  SystemDefault = 0,
  TransientLocal = 1,
  Volatile = 2,
  Unknown = 3,
  BestAvailable = 4
};
enum class History : std::uint8_t { SystemDefault = 0, KeepLast = 1, KeepAll = 2, Unknown = 3 };
enum class Liveliness : std::uint8_t {
  SystemDefault = 0,
  Automatic = 1,
  ManualByTopic = 3,
  Unknown = 4,
  BestAvailable = 5
};

/// Nacelle's: what a publisher does when all messages that the stream's queues and callbacks can hold are out (a reader keeps
/// more of them than its depth says). Each case is counted.
enum class PoolPolicy : std::uint8_t {
  Grow,  ///< Makes another one: nothing is lost, and memory grows with what the readers keep.
  Drop,  ///< The next message is filled and then dropped: memory is bounded, and the reader that keeps too much misses it.
  Fail,  ///< The same, and the publisher's component becomes faulted: a design error that must not pass unseen.
};

// rclcpp's words for the same.
using ReliabilityPolicy = Reliability;
using DurabilityPolicy = Durability;
using HistoryPolicy = History;
using LivelinessPolicy = Liveliness;

/// A deadline or lease that follows the other side's, as rmw writes it.
inline constexpr Duration kBestAvailableDuration = Duration::max() - Duration{1};

struct KeepLast {
  explicit constexpr KeepLast(std::size_t samples) : depth(samples) {}
  std::size_t depth;
};
struct KeepAll {};

/// Quality of service of a publisher or of a subscription. rclcpp's words and defaults: `QoS(10).best_effort()`.
///
/// Durations: zero is "not given", which means infinite; Duration::max() is stored as zero, so that equal meanings
/// compare equal. Negative durations are a bug. Threads: a value. Allocates: nothing.
/// Source: rclcpp/qos.hpp, rmw/qos_profiles.h (jazzy).
class QoS {
 public:
  /// rmw's default profile (keep_last, reliable, volatile) with this depth.
  constexpr QoS(std::size_t depth) : depth_(depth) {}   // NOLINT(google-explicit-constructor): as in rclcpp
  constexpr QoS(KeepLast keep) : depth_(keep.depth) {}  // NOLINT(google-explicit-constructor): as in rclcpp
  constexpr QoS(KeepAll) : history_(History::KeepAll), depth_(0) {}  // NOLINT(google-explicit-constructor)

  QoS& history(History value) { return set(history_, value); }
  QoS& keep_last(std::size_t depth);
  QoS& keep_all();
  QoS& reliability(Reliability value) { return set(reliability_, value); }
  QoS& reliable() { return reliability(Reliability::Reliable); }
  QoS& best_effort() { return reliability(Reliability::BestEffort); }
  QoS& reliability_best_available() { return reliability(Reliability::BestAvailable); }
  QoS& durability(Durability value) { return set(durability_, value); }
  QoS& durability_volatile() { return durability(Durability::Volatile); }
  QoS& transient_local() { return durability(Durability::TransientLocal); }
  QoS& durability_best_available() { return durability(Durability::BestAvailable); }
  /// Longest time between two messages.
  QoS& deadline(Duration value) { return set(deadline_, checked(value)); }
  /// A message older than this is not delivered.
  QoS& lifespan(Duration value) { return set(lifespan_, checked(value)); }
  QoS& liveliness(Liveliness value) { return set(liveliness_, value); }
  /// A publisher that shows no life for this long is lost.
  QoS& liveliness_lease_duration(Duration value) { return set(lease_, checked(value)); }
  QoS& avoid_ros_namespace_conventions(bool value) { return set(avoid_ros_names_, value); }
  /// Nacelle's: how many messages keep_all may hold for one reader before publish() answers WouldBlock or drops.
  QoS& max_samples(std::size_t value) { return set(max_samples_, value); }
  /// Nacelle's: how long a reliable publish() may wait for room; zero (the default) is never.
  QoS& max_blocking_time(Duration value);
  /// Nacelle's, of a publisher: what happens when its pool of messages has run dry.
  QoS& when_dry(PoolPolicy value) { return set(when_dry_, value); }

  [[nodiscard]] constexpr History history() const { return history_; }
  [[nodiscard]] constexpr std::size_t depth() const { return depth_; }
  [[nodiscard]] constexpr Reliability reliability() const { return reliability_; }
  [[nodiscard]] constexpr Durability durability() const { return durability_; }
  [[nodiscard]] constexpr Duration deadline() const { return deadline_; }
  [[nodiscard]] constexpr Duration lifespan() const { return lifespan_; }
  [[nodiscard]] constexpr Liveliness liveliness() const { return liveliness_; }
  [[nodiscard]] constexpr Duration liveliness_lease_duration() const { return lease_; }
  [[nodiscard]] constexpr bool avoid_ros_namespace_conventions() const { return avoid_ros_names_; }
  [[nodiscard]] constexpr std::size_t max_samples() const { return max_samples_; }
  [[nodiscard]] constexpr Duration max_blocking_time() const { return max_blocking_time_; }
  [[nodiscard]] constexpr PoolPolicy when_dry() const { return when_dry_; }

  /// True for keep_all; what is left of system_default counts as keep_last, as in resolved().
  [[nodiscard]] constexpr bool keeps_all() const { return history_ == History::KeepAll; }
  /// How many messages a reader's queue holds: the depth, or max_samples with keep_all.
  [[nodiscard]] std::size_t queue_capacity() const;

  /// The same with every system_default made concrete: keep_last 1, reliable, volatile, automatic.
  /// A keep_last of depth 0 means depth 1. Unknown and best_available stay. Source: rmw_cyclonedds, rmw_node.cpp.
  [[nodiscard]] QoS resolved() const;

  friend bool operator==(const QoS&, const QoS&) = default;

 private:
  template <typename T>
  QoS& set(T& member, T value) {
    member = value;
    return *this;
  }
  static Duration checked(Duration value);

  History history_ = History::KeepLast;
  Reliability reliability_ = Reliability::Reliable;
  Durability durability_ = Durability::Volatile;
  Liveliness liveliness_ = Liveliness::SystemDefault;
  bool avoid_ros_names_ = false;
  PoolPolicy when_dry_ = PoolPolicy::Grow;
  std::size_t depth_;
  std::size_t max_samples_ = 1000;
  Duration deadline_{};
  Duration lifespan_{};
  Duration lease_{};
  Duration max_blocking_time_{};
};

}  // namespace nacelle
