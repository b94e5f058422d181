// SPDX-License-Identifier: Apache-2.0
// The laws: any chopping of the bytes gives the same frames and the same end, a frame is never longer than the limit, of an unknown kind
// or refused, and the frames that were read, written again, are the bytes that were read.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdlib>

#include "nacelle/base/frame.hpp"

namespace {

using namespace nacelle;

constexpr std::size_t kLimit = 600;

void require(bool holds) {
  if (!holds) std::abort();
}

enum class Kind : std::uint8_t { A = 'A', B = 'B' };
enum class Fault : std::uint8_t { TooLong, UnknownKind, NotNow };
bool is_known(Kind kind) { return kind == Kind::A || kind == Kind::B; }

struct Outcome {
  Bytes again;
  std::size_t frames = 0;
  std::optional<Fault> fault;
  friend bool operator==(const Outcome&, const Outcome&) = default;
};

Outcome read_in_pieces(ByteView bytes, std::size_t piece) {
  Outcome outcome;
  FrameReader<Kind, Fault> reader{kLimit};
  // Not more than three frames of kind B.
  std::size_t more = 3;
  const auto refusal = [&](Kind kind) {
    return kind == Kind::B && more == 0 ? std::optional{Fault::NotNow} : std::nullopt;
  };
  while (!bytes.empty()) {
    const ByteSpan room = reader.room();
    const std::size_t n = std::min({bytes.size(), room.size(), piece});
    require(n > 0);
    std::copy_n(bytes.begin(), n, room.begin());
    reader.filled(n);
    bytes = bytes.subspan(n);
    while (true) {
      const auto frame = reader.next(refusal);
      if (!frame) {
        outcome.fault = frame.error();
        return outcome;
      }
      if (!frame.value()) break;
      require(frame.value()->payload.size() <= kLimit && is_known(frame.value()->kind));
      if (frame.value()->kind == Kind::B) {
        require(more > 0);
        --more;
      }
      ++outcome.frames;
      append_frame(outcome.again, frame.value()->kind, as_text(frame.value()->payload));
    }
    require(reader.pending() < kFrameHeaderBytes + kLimit);
  }
  return outcome;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const ByteView bytes{data, size};
  const Outcome whole = read_in_pieces(bytes, SIZE_MAX);
  require(whole.again.size() <= size && std::equal(whole.again.begin(), whole.again.end(), bytes.begin()));
  for (const std::size_t piece : {std::size_t{1}, std::size_t{7}, std::size_t{300}})
    require(read_in_pieces(bytes, piece) == whole);
  return 0;
}
