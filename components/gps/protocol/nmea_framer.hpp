// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "nacelle/base/bytes.hpp"
#include "nacelle/base/time.hpp"

namespace nacelle::gps {

namespace nmea_layout {
// NMEA 0183, a sentence: printable ASCII, fields between commas.
// Source: NovAtel, MiLLennium Command Descriptions, appendix D; Trimble R750, "NMEA-0183 messages"; gpsd, "NMEA Revealed".
//
//   bytes     field      on the wire
//   1         start      $
//   2         talker     GP GPS, GL GLONASS, GA Galileo, GB or BD BeiDou, GN several; P: one company's own sentence
//   3         formatter  GGA, RMC, GSA, GST, VTG, ...
//   0 to ...  fields     each after a comma; may be empty
//   1         star       *
//   2         checksum   hexadecimal: XOR of all bytes between $ and *
//   2         end        CR LF
//
// The standard allows 82 bytes. Receivers with more decimals exceed that.
inline constexpr std::size_t kLongest = 160;
}  // namespace nmea_layout

/// One sentence with a right checksum, without `$`, `*` and what follows. Valid for the length of the call that gives it.
struct NmeaSentence {
  std::string_view text;    ///< "GPGGA,092750.000,5321.6802,N,..."
  MonotonicTime started{};  ///< When the chunk with its `$` was received.
};

/// Finds NMEA sentences in a stream of bytes, however it is chopped. Sentences without a checksum are refused: a digit that was disturbed
/// on the line would move the robot.
///
/// Threads: one. Allocates: nothing.
class NmeaFramer {
 public:
  /// Every byte that was fed is in one place: bytes == sentence_bytes + line_end_bytes + skipped_bytes + pending().
  struct Stats {
    std::uint64_t bytes{};           ///< Fed so far.
    std::uint64_t sentences{};       ///< Handed to the sink.
    std::uint64_t sentence_bytes{};  ///< Of those, from `$` to the checksum.
    std::uint64_t line_end_bytes{};  ///< CR and LF.
    std::uint64_t skipped_bytes{};   ///< Of rejected sentences, and between sentences.
    std::uint64_t bad_checksums{};   ///< Sentences with a wrong checksum.
    std::uint64_t
        broken{};  ///< Sentences that were torn, too long, without a checksum, or held a byte that is not text.
    friend bool operator==(const Stats&, const Stats&) = default;
  };

  /// Calls `on_sentence(const NmeaSentence&)` for each sentence.
  template <typename Sink>
  void feed(ByteView bytes, MonotonicTime received, Sink&& on_sentence) {
    for (const std::uint8_t byte : bytes) {
      if (!take(byte, received)) continue;
      on_sentence(NmeaSentence{{window_.data() + 1, length_ - 4}, started_});
      length_ = 0;
    }
  }

  /// Forgets half a sentence: the line was opened again.
  void restart();
  [[nodiscard]] const Stats& stats() const { return stats_; }
  [[nodiscard]] std::size_t pending() const { return length_; }

 private:
  /// Returns true if the window holds a whole sentence.
  bool take(std::uint8_t byte, MonotonicTime received);
  bool close();
  void skip_pending();

  std::array<char, nmea_layout::kLongest> window_{};
  std::size_t length_ = 0;
  std::size_t star_ = 0;  // its place in the window; 0: it has not come
  std::uint8_t sum_ = 0;  // of the bytes behind `$`
  MonotonicTime started_{};
  Stats stats_;
};

}  // namespace nacelle::gps
