// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "nacelle/base/time.hpp"

namespace nacelle::transport_dds {

/// What leaves the machine of one topic, or that a service may be seen there, in mode Export.
struct ExportRule {
  std::string topic;                ///< Fully qualified name; a service's has no limits.
  double max_hz = 0.0;              ///< 0: every message.
  std::size_t max_bytes_per_s = 0;  ///< 0: no limit.
  bool compressed_only = false;     ///< Only the compressed form of an image.
  friend bool operator==(const ExportRule&, const ExportRule&) = default;
};

/// The rule that shows an end of this topic and type ("sensor_msgs/msg/Image"), or null: none of the list does.
///
/// `compressed_only` shows the topic itself where its type is a compressed image, and image_transport's topics of
/// compressed forms below it (/camera/image_raw/compressed), in place of the raw one.
[[nodiscard]] const ExportRule* rule_of(const std::vector<ExportRule>& rules, std::string_view topic,
                                        std::string_view type);

/// Thins the messages of one topic to what its rule allows. Pure: the caller tells the time.
///
/// max_hz is kept on the average, and never exceeded by more than a message: after a pause the second message may come
/// half a period after the first. max_bytes_per_s has a second's worth in store; a message that is larger than that goes
/// when the store is full, and those behind it wait until it is paid for.
class ExportGate {
 public:
  explicit ExportGate(const ExportRule& rule);
  /// Whether a message of so many bytes may go now; one that may is counted as gone.
  [[nodiscard]] bool admits(MonotonicTime now, std::size_t bytes);
  /// When one that may not go now may, if nothing goes meanwhile.
  [[nodiscard]] MonotonicTime due(MonotonicTime now, std::size_t bytes) const;

 private:
  [[nodiscard]] double store_at(MonotonicTime now) const;
  [[nodiscard]] double needed(std::size_t bytes) const;

  Duration period_{};                       // zero: no limit
  double bytes_per_s_ = 0;                  // zero: no limit
  MonotonicTime next_;                      // by the rate
  double store_ = 0;                        // bytes that may go ...
  std::optional<MonotonicTime> looked_at_;  // ... as of then; none: not asked yet
};

}  // namespace nacelle::transport_dds
