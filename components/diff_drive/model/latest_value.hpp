// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <optional>
#include <type_traits>

namespace nacelle::diff_drive {

/// Hands the newest value from one thread to another; older ones are overwritten.
///
/// Three places: the writer fills one, the reader looks at one, the third changes hands. Neither side ever waits or
/// retries, so a sender of commands cannot delay the control loop, and the loop never sees half a value.
/// Threads:   put() from one thread, take() from one thread. Allocates: nothing.
template <typename T>
class LatestValue {
  static_assert(std::is_trivially_copyable_v<T>, "a value that is copied while another thread waits must be plain");

 public:
  void put(const T& value) {
    places_[writing_] = value;
    writing_ = shared_.exchange(static_cast<std::uint8_t>(writing_ | kFresh), std::memory_order_acq_rel) & kIndex;
  }
  /// The newest value, once.
  [[nodiscard]] std::optional<T> take() {
    if ((shared_.load(std::memory_order_relaxed) & kFresh) == 0) return std::nullopt;
    reading_ = shared_.exchange(reading_, std::memory_order_acq_rel) & kIndex;
    return places_[reading_];
  }

 private:
  static constexpr std::uint8_t kIndex = 3;
  static constexpr std::uint8_t kFresh = 4;

  std::array<T, 3> places_{};
  std::uint8_t writing_ = 0;
  std::uint8_t reading_ = 1;
  std::atomic<std::uint8_t> shared_{2};
};

}  // namespace nacelle::diff_drive
