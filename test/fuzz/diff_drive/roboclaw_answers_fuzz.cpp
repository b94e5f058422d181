// SPDX-License-Identifier: Apache-2.0
// Any bytes for any questions, in any chopping: nothing crashes, every byte is accounted for, and the answers do not depend on the
// chopping. The first byte of the input is the number of questions; each question takes one more.
#include <algorithm>
#include <cstdlib>
#include <vector>

#include "diff_drive/protocol/roboclaw_answers.hpp"

namespace {

using nacelle::diff_drive::RoboclawAnswer;
using nacelle::diff_drive::RoboclawAnswers;
using nacelle::diff_drive::RoboclawCommand;

constexpr RoboclawCommand kCommands[] = {
    RoboclawCommand::SerialTimeout, RoboclawCommand::SpeedM1, RoboclawCommand::SpeedM2,  RoboclawCommand::MainBattery,
    RoboclawCommand::Duty,          RoboclawCommand::Speed,   RoboclawCommand::Encoders, RoboclawCommand::Status};

void require(bool holds) {
  if (!holds) std::abort();
}

void require_accounted(const RoboclawAnswers& answers) {
  const auto& stats = answers.stats();
  require(stats.bytes == stats.answer_bytes + stats.lost_bytes + answers.pending());
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const std::size_t questions = std::min<std::size_t>(data[0] % 32U, size - 1);
  const nacelle::ByteView asked{data + 1, questions};
  const nacelle::ByteView bytes{data + 1 + questions, size - 1 - questions};

  std::vector<RoboclawAnswer> whole, chopped;
  RoboclawAnswers at_once{0x80}, in_parts{0x80};
  for (RoboclawAnswers* answers : {&at_once, &in_parts}) {
    for (const std::uint8_t command : asked) {
      if (command == 0xFF) answers->assume_step();
      answers->expect(kCommands[command % 8U]);
    }
  }
  at_once.feed(bytes, [&](const RoboclawAnswer& answer) { whole.push_back(answer); });
  for (std::size_t at = 0; at < bytes.size();) {
    const std::size_t part = std::min<std::size_t>(bytes.size() - at, 1 + bytes[at] % 7U);
    in_parts.feed(bytes.subspan(at, part), [&](const RoboclawAnswer& answer) { chopped.push_back(answer); });
    require_accounted(in_parts);
    at += part;
  }
  require(at_once.stats().bytes == bytes.size());
  require_accounted(at_once);
  require(at_once.stats() == in_parts.stats());
  require(whole == chopped);
  at_once.fall_out_of_step();
  require(at_once.pending() == 0);
  require_accounted(at_once);
  return 0;
}
