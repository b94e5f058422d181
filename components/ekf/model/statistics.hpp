// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "nacelle/base/time.hpp"

namespace nacelle::ekf {

/// Why a part of a message was not fused.
enum class Rejection : std::uint8_t {
  Gate,           ///< Farther from the prediction than the rejection threshold.
  Stale,          ///< Older than the last message of the same part.
  NotFinite,      ///< No configured quantity of it is a finite number.
  NoTransform,    ///< Its frame cannot be expressed in the filter's at its time.
  Covariance,     ///< Not finite, or no covariance matrix at all.
  BeforeSetPose,  ///< Not newer than the last set_pose.
  QueueFull,      ///< More wait for their time than the queue may hold.
  Absent,         ///< The message says that it does not carry this part (covariance[0] is -1).
  First,          ///< Differential: the first message only starts the difference.
  NoStamp,        ///< Its stamp is zero.
  Future,         ///< Its stamp lies farther ahead than the rates of the inputs explain.
  BeforeHistory,  ///< Older than the history of smooth_lagged_data.
};
inline constexpr std::size_t kRejections = 12;
inline constexpr std::array<std::string_view, kRejections> kRejectionNames{
    "gate",       "stale",  "not_finite", "no_transform", "covariance", "before_set_pose",
    "queue_full", "absent", "first",      "no_stamp",     "future",     "before_history"};

/// What became of one part (pose, twist, orientation, ...) of one input.
/// received == fused + the sum of rejected + waiting.
struct PartStats {
  std::uint64_t received{}, fused{}, waiting{};
  std::array<std::uint64_t, kRejections> rejected{};
  std::uint64_t
      late{};  ///< Of the fused: older than the filter. With a history put into their place, else fused without going back.
  Duration late_by{};          ///< How far behind the filter the last late one was, fused or not.
  std::uint64_t same_stamp{};  ///< How many of the last messages in a row had one and the same stamp.
  Duration behind{};           ///< How far the last stamp was behind the clock when it came; ahead if negative.

  [[nodiscard]] std::uint64_t& of(Rejection cause) { return rejected[static_cast<std::size_t>(cause)]; }
  [[nodiscard]] std::uint64_t of(Rejection cause) const { return rejected[static_cast<std::size_t>(cause)]; }
};

}  // namespace nacelle::ekf
