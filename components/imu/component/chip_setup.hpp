// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "imu/component/imu_options.hpp"
#include "imu/model/chip_reader.hpp"
#include "nacelle/io/register_stream.hpp"

namespace nacelle::imu {

/// One register that must have a value, or gets one.
struct RegisterStep {
  enum class Kind : std::uint8_t { Write, Check };
  Kind kind = Kind::Write;
  std::uint8_t address = 0, reg = 0, value = 0;
  Duration pause{};       ///< After a write.
  const char* chip = "";  ///< Of a check: whose identity it is.
  std::uint8_t also = 0;  ///< Of a check: another value that is right; 0: none.
};

/// How a chip is set up, polled and understood.
struct ChipPlan {
  std::vector<RegisterStep> set_up;
  std::vector<io::PollBlock> blocks;
  Duration poll_period{};
  ChipUnits units{};
  std::unique_ptr<ChipDecoder> decoder;
};

/// The plan of a model on a register bus. Precondition: the options were checked by read_imu_parameters().
[[nodiscard]] ChipPlan plan_chip(const ImuOptions& options);
/// The rate that the chip really makes of the wanted one. Errors: a sentence, with the nearest rates that it has.
[[nodiscard]] Result<double, std::string> chip_rate(ImuModel model, double rate_hz);

/// Why a chip could not be set up.
struct SetUpFault {
  io::StreamFault fault = io::StreamFault::NotUsable;
  std::string what;  ///< "0x68: WHO_AM_I is 0x70, not 0x71 (MPU-9250)"
  std::string way_out;
};
/// Goes through the steps; a failed transfer is tried three times.
[[nodiscard]] Result<void, SetUpFault> set_up_chip(io::RegisterBus& bus, const std::vector<RegisterStep>& steps,
                                                   const Clock& clock);

}  // namespace nacelle::imu
