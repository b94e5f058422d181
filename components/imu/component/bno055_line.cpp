// SPDX-License-Identifier: Apache-2.0
#include "imu/component/bno055_line.hpp"

#include <algorithm>

#include "nacelle/base/expect.hpp"

namespace nacelle::imu {

Result<Bno055Line::Outcome, io::StreamFault> Bno055Line::ask(ByteView request, ByteSpan in) {
  using namespace bno055_layout;
  // A late answer to an earlier request is not the answer to this one.
  if (auto stale = line_->read_until(clock_.now()); !stale) return err(stale.error());
  decoder_.restart();
  if (auto written = line_->write(request); !written) return err(written.error());
  const MonotonicTime deadline = clock_.now() + kPatience;
  std::optional<Outcome> outcome;
  while (!outcome) {
    const auto bytes = line_->read_until(deadline);
    if (!bytes) return err(bytes.error());
    if (bytes->empty() && clock_.now() >= deadline) return Outcome::Again;
    decoder_.feed(*bytes, [&](const Bno055Answer& answer) {
      if (outcome) return;
      if (answer.status == kOverrun) {
        outcome = Outcome::Again;
      } else if (answer.status != kSuccess) {
        outcome = Outcome::Refused;
      } else if (answer.data.size() == in.size()) {
        std::ranges::copy(answer.data, in.begin());
        outcome = Outcome::Done;
      } else {
        outcome = Outcome::Again;
      }
    });
  }
  return *outcome;
}

Result<void, io::StreamFault> Bno055Line::transfer(std::uint8_t, ByteView out, ByteSpan in) {
  using namespace bno055_layout;
  NACELLE_EXPECT(in.size() <= kMostData && out.size() == (in.empty() ? 2U : 1U),
                 "one register is written, or some read");
  const Bno055Request request = in.empty() ? bno055_write(out[0], out[1]) : bno055_read(out[0], in.size());
  const ByteView bytes = ByteView{request}.first(in.empty() ? kRequestBytes + 1 : kRequestBytes);
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    const auto outcome = ask(bytes, in);
    if (!outcome) return err(outcome.error());
    if (*outcome == Outcome::Done) return {};
    if (*outcome == Outcome::Refused)
      return err(in.empty() ? io::StreamFault::WriteFailed : io::StreamFault::ReadFailed);
  }
  return err(io::StreamFault::NoAnswer);
}

bool Bno055Line::wait_until(MonotonicTime time) {
  for (;;) {
    if (is_interrupted_.exchange(false, std::memory_order_relaxed)) return false;
    // Unasked bytes are of late answers; a broken line shows at the next transfer.
    const auto bytes = line_->read_until(time);
    if (!bytes || clock_.now() >= time) return !is_interrupted_.exchange(false, std::memory_order_relaxed);
  }
}

Result<void, io::StreamFault> Bno055Line::reopen() {
  decoder_.restart();
  return line_->reopen();
}

}  // namespace nacelle::imu
