// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "nacelle/base/time.hpp"

namespace nacelle::transport_dds {

/// In mode Export: permits other machines to see one topic, with limits for its messages, or one service.
struct ExportRule {
  std::string topic;    ///< Fully qualified name of the topic or service. The limits do not apply to services.
  double max_hz = 0.0;  ///< 0: no limit.
  std::size_t max_bytes_per_s = 0;  ///< 0: no limit.
  bool compressed_only = false;     ///< Only the compressed form of an image.
  friend bool operator==(const ExportRule&, const ExportRule&) = default;
};

/// Returns the rule that exports an endpoint of this topic and type ("sensor_msgs/msg/Image"); null if there is none.
///
/// `compressed_only` exports the topic itself if its type is a compressed image, and image_transport's compressed
/// topics below it (/camera/image_raw/compressed), but not the raw image.
[[nodiscard]] const ExportRule* rule_of(const std::vector<ExportRule>& rules, std::string_view topic,
                                        std::string_view type);

/// Rate limiter for the messages of one topic, by its rule. Pure: the caller provides the time.
///
/// max_hz limits the average rate; a burst exceeds it by one message at most: after a pause the second message may
/// follow the first by half a period. max_bytes_per_s is a token bucket with the tokens of one second. A message larger
/// than the bucket is admitted when the bucket is full, and leaves it in debt, so that later messages wait.
class ExportGate {
 public:
  explicit ExportGate(const ExportRule& rule);
  /// Returns whether a message of that many bytes may be sent now. If so, counts it as sent.
  [[nodiscard]] bool admits(MonotonicTime now, std::size_t bytes);
  /// Returns when admits() accepts a message of that many bytes, if no other message is sent before.
  [[nodiscard]] MonotonicTime due(MonotonicTime now, std::size_t bytes) const;

 private:
  [[nodiscard]] double store_at(MonotonicTime now) const;
  [[nodiscard]] double needed(std::size_t bytes) const;

  Duration period_{};                       // zero: no limit
  double bytes_per_s_ = 0;                  // zero: no limit
  MonotonicTime next_;                      // earliest time of the next message, by max_hz
  double store_ = 0;                        // tokens in bytes; negative: debt
  std::optional<MonotonicTime> looked_at_;  // time of store_; none: before the first call of admits()
};

}  // namespace nacelle::transport_dds
