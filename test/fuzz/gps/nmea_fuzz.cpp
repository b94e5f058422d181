// SPDX-License-Identifier: Apache-2.0
// Any bytes, in any chopping: nothing crashes, every byte is accounted for, the sentences do not depend on the chopping, and what is
// read from them is finite and in range.
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <string>
#include <type_traits>
#include <vector>

#include "gps/model/error_model.hpp"
#include "gps/protocol/nmea_framer.hpp"

namespace {

using namespace nacelle::gps;
using namespace std::chrono_literals;

void require(bool holds) {
  if (!holds) std::abort();
}

void require_accounted(const NmeaFramer& framer) {
  const auto& s = framer.stats();
  require(s.bytes == s.sentence_bytes + s.line_end_bytes + s.skipped_bytes + framer.pending());
}

void require_sane(const std::string& text, ErrorModel& errors) {
  std::visit(
      [&](const auto& message) {
        using Message = std::decay_t<decltype(message)>;
        if constexpr (std::is_same_v<Message, Gga> || std::is_same_v<Message, Rmc>) {
          if (message.position) {
            require(std::abs(message.position->latitude_deg) <= 90.0 &&
                    std::abs(message.position->longitude_deg) <= 180.0);
          }
          if (message.utc) require(*message.utc >= 0s && *message.utc <= 24h);
        }
        if constexpr (std::is_same_v<Message, Gga>) {
          require(message.quality <= 9);
          const auto variances = errors.of(message, {});
          require(std::isfinite(variances.east_m2) && variances.east_m2 >= 0.0);
          require(std::isfinite(variances.north_m2) && variances.north_m2 >= 0.0);
          require(std::isfinite(variances.up_m2) && variances.up_m2 >= 0.0);
        }
        if constexpr (std::is_same_v<Message, Gsa> || std::is_same_v<Message, Gst>) errors.add(message, {});
        if constexpr (std::is_same_v<Message, Vtg> || std::is_same_v<Message, Rmc>) {
          if (message.speed_mps) require(std::isfinite(*message.speed_mps) && *message.speed_mps >= 0.0);
          if (message.course_deg) require(std::abs(*message.course_deg) <= 360.0);
        }
      },
      read_nmea(text));
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const nacelle::ByteView bytes{data, size};
  std::vector<std::string> whole, chopped;

  NmeaFramer at_once;
  at_once.feed(bytes, {}, [&](const NmeaSentence& sentence) { whole.emplace_back(sentence.text); });
  require(at_once.stats().bytes == size);
  require_accounted(at_once);

  NmeaFramer in_parts;
  for (std::size_t at = 0; at < size;) {
    const std::size_t part = std::min<std::size_t>(size - at, 1 + data[at] % 17U);
    in_parts.feed(bytes.subspan(at, part), {},
                  [&](const NmeaSentence& sentence) { chopped.emplace_back(sentence.text); });
    at += part;
  }
  require(in_parts.stats() == at_once.stats());
  require(whole == chopped);
  in_parts.restart();
  require_accounted(in_parts);

  ErrorModel errors;
  for (const std::string& text : whole) require_sane(text, errors);
  // The checksum keeps a fuzzer from most fields: the text is also read without one.
  require_sane(std::string(nacelle::as_text(bytes)), errors);
  return 0;
}
