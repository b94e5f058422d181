// SPDX-License-Identifier: Apache-2.0
#include "range/component/vl53l0x.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <optional>

#include "range/component/vl53l0x_wire.hpp"
#include "range/protocol/vl53l0x_timing.hpp"

namespace nacelle::range {
namespace {

// The maker's names in comments are those of vl53l0x_device.h.
constexpr std::uint8_t kStart = 0x00;           // SYSRANGE_START
constexpr std::uint8_t kSequence = 0x01;        // SYSTEM_SEQUENCE_CONFIG
constexpr std::uint8_t kPeriod = 0x04;          // SYSTEM_INTERMEASUREMENT_PERIOD
constexpr std::uint8_t kInterruptOn = 0x0A;     // SYSTEM_INTERRUPT_CONFIG_GPIO
constexpr std::uint8_t kInterruptClear = 0x0B;  // SYSTEM_INTERRUPT_CLEAR
constexpr std::uint8_t kInterrupt = 0x13;       // RESULT_INTERRUPT_STATUS; the result follows
constexpr std::uint8_t kSignalLimit = 0x44;     // FINAL_RANGE_CONFIG_MIN_COUNT_RATE_RTN_LIMIT
constexpr std::uint8_t kLimitChecks = 0x60;     // MSRC_CONFIG_CONTROL
constexpr std::uint8_t kInterruptPin = 0x84;    // GPIO_HV_MUX_ACTIVE_HIGH
constexpr std::uint8_t kPadVoltage = 0x89;      // VHV_CONFIG_PAD_SCL_SDA__EXTSUP_HV
constexpr std::uint8_t kCells = 0xB0;           // GLOBAL_CONFIG_SPAD_ENABLES_REF_0, 6 bytes
constexpr std::uint8_t kCellsStart = 0xB6;      // GLOBAL_CONFIG_REF_EN_START_SELECT
constexpr std::uint8_t kIdentity = 0xC0;        // IDENTIFICATION_MODEL_ID
constexpr std::uint8_t kOscillator = 0xF8;      // OSC_CALIBRATE_VAL
constexpr std::uint8_t kPage = 0xFF;
constexpr std::uint8_t kStopValue = 0x91;  // on page 1, as the next
constexpr std::uint8_t kStopState = 0x04;

constexpr std::uint8_t kDone = 0x07;  // bits of kInterrupt
constexpr std::uint8_t kSingle = 0x01, kTimed = 0x04, kContinuous = 0x06;
constexpr std::uint8_t kMeasureOnly = 0xE8;  // selection of cells, first and second measurement; no checks between
// 0.25 million photons a second, in 1/128.
constexpr std::uint16_t kLeastSignal = 32;
constexpr Duration kPatience = 250ms;
constexpr Duration kStopPatience = 750ms;  // the longest budget is half a second

/// Gives access to the page that holds what the maker does not document, and ends it.
constexpr std::array kEnter{RegisterWrite{0x80, 0x01}, RegisterWrite{kPage, 0x01}, RegisterWrite{0x00, 0x00}};
constexpr std::array kLeave{RegisterWrite{0x00, 0x01}, RegisterWrite{kPage, 0x00}, RegisterWrite{0x80, 0x00}};

// Source: ST, VL53L0X API, vl53l0x_tuning.h: values that the maker found and does not explain, by page.
constexpr std::array kTuning{
    RegisterWrite{kPage, 1},   RegisterWrite{0x00, 0x00}, RegisterWrite{kPage, 0},   RegisterWrite{0x09, 0x00},
    RegisterWrite{0x10, 0x00}, RegisterWrite{0x11, 0x00}, RegisterWrite{0x24, 0x01}, RegisterWrite{0x25, 0xFF},
    RegisterWrite{0x75, 0x00}, RegisterWrite{kPage, 1},   RegisterWrite{0x4E, 0x2C}, RegisterWrite{0x48, 0x00},
    RegisterWrite{0x30, 0x20}, RegisterWrite{kPage, 0},   RegisterWrite{0x30, 0x09}, RegisterWrite{0x54, 0x00},
    RegisterWrite{0x31, 0x04}, RegisterWrite{0x32, 0x03}, RegisterWrite{0x40, 0x83}, RegisterWrite{0x46, 0x25},
    RegisterWrite{0x60, 0x00}, RegisterWrite{0x27, 0x00}, RegisterWrite{0x50, 0x06}, RegisterWrite{0x51, 0x00},
    RegisterWrite{0x52, 0x96}, RegisterWrite{0x56, 0x08}, RegisterWrite{0x57, 0x30}, RegisterWrite{0x61, 0x00},
    RegisterWrite{0x62, 0x00}, RegisterWrite{0x64, 0x00}, RegisterWrite{0x65, 0x00}, RegisterWrite{0x66, 0xA0},
    RegisterWrite{kPage, 1},   RegisterWrite{0x22, 0x32}, RegisterWrite{0x47, 0x14}, RegisterWrite{0x49, 0xFF},
    RegisterWrite{0x4A, 0x00}, RegisterWrite{kPage, 0},   RegisterWrite{0x7A, 0x0A}, RegisterWrite{0x7B, 0x00},
    RegisterWrite{0x78, 0x21}, RegisterWrite{kPage, 1},   RegisterWrite{0x23, 0x34}, RegisterWrite{0x42, 0x00},
    RegisterWrite{0x44, 0xFF}, RegisterWrite{0x45, 0x26}, RegisterWrite{0x46, 0x05}, RegisterWrite{0x40, 0x40},
    RegisterWrite{0x0E, 0x06}, RegisterWrite{0x20, 0x1A}, RegisterWrite{0x43, 0x40}, RegisterWrite{kPage, 0},
    RegisterWrite{0x34, 0x03}, RegisterWrite{0x35, 0x44}, RegisterWrite{kPage, 1},   RegisterWrite{0x31, 0x04},
    RegisterWrite{0x4B, 0x09}, RegisterWrite{0x4C, 0x05}, RegisterWrite{0x4D, 0x04}, RegisterWrite{kPage, 0},
    RegisterWrite{0x44, 0x00}, RegisterWrite{0x45, 0x20}, RegisterWrite{0x47, 0x08}, RegisterWrite{0x48, 0x28},
    RegisterWrite{0x67, 0x00}, RegisterWrite{0x70, 0x04}, RegisterWrite{0x71, 0x01}, RegisterWrite{0x72, 0xFE},
    RegisterWrite{0x76, 0x00}, RegisterWrite{0x77, 0x00}, RegisterWrite{kPage, 1},   RegisterWrite{0x0D, 0x01},
    RegisterWrite{kPage, 0},   RegisterWrite{0x80, 0x01}, RegisterWrite{0x01, 0xF8}, RegisterWrite{kPage, 1},
    RegisterWrite{0x8E, 0x01}, RegisterWrite{0x00, 0x01}, RegisterWrite{kPage, 0},   RegisterWrite{0x80, 0x00}};

Result<void, Vl53l0xProblem> outcome(const Vl53l0xWire& wire, const char* unfinished = nullptr) {
  if (wire.fault()) return err(Vl53l0xProblem{*wire.fault(), std::string(io::explain(*wire.fault())), "is it wired?"});
  if (unfinished == nullptr) return {};
  return err(Vl53l0xProblem{io::StreamFault::NoAnswer, fmt::format("it does not finish {}", unfinished),
                            "is its supply steady?"});
}

/// Ends continuous measuring. Without the last part the next start would find the value that means stop.
bool halt(Vl53l0xWire& wire, std::uint8_t stop_value) {
  wire.write(kStart, kSingle);
  wire.write(kPage, 0x01).write(0x00, 0x00).write(kStopValue, 0x00).write(0x00, 0x01).write(kPage, 0x00);
  wire.write(kPage, 0x01);
  const bool has_stopped = wire.wait_for(kStopState, 0xFF, false, kStopPatience);
  wire.write(kPage, 0x00);
  wire.write(kEnter).write(kStopValue, stop_value).write(kLeave);
  wire.write(kInterruptClear, 0x01);
  return has_stopped;
}

struct ReferenceCells {
  unsigned count = 0;
  bool behind_aperture = false;
};

/// What the factory wrote down: how many cells see the light that does not leave the case.
std::optional<ReferenceCells> read_reference(Vl53l0xWire& wire) {
  wire.write(kEnter).write(kPage, 0x06);
  wire.write(0x83, static_cast<std::uint8_t>(wire.read(0x83) | 0x04U));
  wire.write(kPage, 0x07).write(0x81, 0x01).write(0x80, 0x01).write(0x94, 0x6B).write(0x83, 0x00);
  const bool came = wire.wait_for(0x83, 0xFF, true, kPatience);
  wire.write(0x83, 0x01);
  const std::uint8_t told = wire.read(0x92);
  wire.write(0x81, 0x00).write(kPage, 0x06);
  wire.write(0x83, static_cast<std::uint8_t>(wire.read(0x83) & 0xFBU));
  wire.write(kPage, 0x01).write(kLeave);
  if (!came || wire.fault()) return std::nullopt;
  return ReferenceCells{told & 0x7FU, (told & 0x80U) != 0};
}

/// Leaves so many of the cells that work switched on: those behind the aperture begin with the twelfth.
void choose_cells(Vl53l0xWire& wire, const ReferenceCells& reference) {
  std::array<std::uint8_t, 6> cells{};
  wire.read_bytes(kCells, cells);
  wire.write(kPage, 0x01).write(0x4F, 0x00).write(0x4E, 0x2C).write(kPage, 0x00).write(kCellsStart, 0xB4);
  unsigned on = 0;
  for (unsigned i = 0; i < cells.size() * 8; ++i) {
    const auto bit = static_cast<std::uint8_t>(1U << i % 8U);
    if ((cells[i / 8] & bit) == 0) continue;
    const bool is_wanted = i >= (reference.behind_aperture ? 12U : 0U) && on < reference.count;
    if (is_wanted) ++on;
    if (!is_wanted) cells[i / 8] &= static_cast<std::uint8_t>(~bit);
  }
  wire.write_bytes(kCells, cells);
}

bool calibrate(Vl53l0xWire& wire, std::uint8_t sequence, std::uint8_t how) {
  wire.write(kSequence, sequence).write(kStart, static_cast<std::uint8_t>(kSingle | how));
  const bool is_done = wire.wait_for(kInterrupt, kDone, true, kPatience);
  wire.write(kInterruptClear, 0x01).write(kStart, 0x00);
  return is_done;
}

}  // namespace

Result<void, Vl53l0xProblem> Vl53l0x::set_up() {
  Vl53l0xWire wire{bus_, settings_.address, clock_};
  // A program that ended in the midst of its work may have left another page.
  wire.write(kPage, 0x00);
  const std::uint16_t identity = wire.read_16(kIdentity);
  if (wire.fault()) return outcome(wire);
  if (identity != 0xEEAA) {
    return err(Vl53l0xProblem{
        io::StreamFault::NotUsable,
        fmt::format("the chip at 0x{:02x} is no VL53L0X (it says {:04x}, not eeaa)", settings_.address, identity),
        "is it a VL53L1X or another chip? give its address"});
  }
  wire.write(kPadVoltage, static_cast<std::uint8_t>(wire.read(kPadVoltage) | 0x01U));  // boards have 2.8 V there
  wire.write(0x88, 0x00);
  // Zero is what a stop leaves that was cut off.
  if (const std::uint8_t told = wire.write(kEnter).read(kStopValue); told != 0) stop_value_ = told;
  wire.write(kLeave);
  if ((wire.read(kStart) & kContinuous) != 0 && !halt(wire, stop_value_)) return outcome(wire, "an old measurement");
  wire.write(kLimitChecks, static_cast<std::uint8_t>(wire.read(kLimitChecks) | 0x12U));
  wire.write_16(kSignalLimit, kLeastSignal).write(kSequence, 0xFF);
  const auto reference = read_reference(wire);
  if (!reference) return outcome(wire, "reading its memory");
  choose_cells(wire, *reference);
  wire.write(kTuning);
  wire.write(kInterruptOn, 0x04);  // a new result
  wire.write(kInterruptPin, static_cast<std::uint8_t>(wire.read(kInterruptPin) & 0xEFU)).write(kInterruptClear, 0x01);
  wire.write(kSequence, kMeasureOnly);
  const Vl53l0xSteps steps{.signal_check = wire.read(0x46),
                           .first_laser_period = wire.read(0x50),
                           .first_timeout = wire.read_16(0x51),
                           .second_laser_period = wire.read(0x70)};
  if (wire.fault()) return outcome(wire);
  const auto timeout = second_timeout(settings_.budget, steps);
  if (!timeout) {
    return err(Vl53l0xProblem{io::StreamFault::NotUsable,
                              fmt::format("{} ms are no time for a measurement", to_seconds(settings_.budget) * 1e3),
                              "set timing_budget between 0.02 and 0.5 s"});
  }
  wire.write_16(0x71, *timeout);
  if (!calibrate(wire, 0x01, 0x40)) return outcome(wire, "the calibration of its voltage");
  if (!calibrate(wire, 0x02, 0x00)) return outcome(wire, "the calibration of its phase");
  wire.write(kSequence, kMeasureOnly);
  return outcome(wire);
}

Result<void, Vl53l0xProblem> Vl53l0x::start() {
  Vl53l0xWire wire{bus_, settings_.address, clock_};
  wire.write(kEnter).write(kStopValue, stop_value_).write(kLeave);
  const std::uint32_t per_ms = wire.read_16(kOscillator);
  const auto period_ms = static_cast<std::uint32_t>(settings_.period / 1ms);
  wire.write_32(kPeriod, per_ms == 0 ? period_ms : period_ms * per_ms).write(kStart, kTimed);
  return outcome(wire);
}

Result<void, Vl53l0xProblem> Vl53l0x::stop() {
  Vl53l0xWire wire{bus_, settings_.address, clock_};
  return outcome(wire, halt(wire, stop_value_) ? nullptr : "its last measurement");
}

Result<bool, io::StreamFault> Vl53l0x::read(std::array<std::uint8_t, Vl53l0xDecoder::kRecordBytes>& record) {
  std::array<std::uint8_t, 1 + Vl53l0xDecoder::kRecordBytes> bytes{};
  const auto again = [this](auto&& transfer) -> Result<void, io::StreamFault> {
    const auto first = transfer();
    if (first || first.error() != io::StreamFault::NoAnswer) return first;
    const auto second = transfer();
    if (second) ++retries_;
    return second;
  };
  if (auto done = again([&] { return io::read_registers(bus_, settings_.address, kInterrupt, bytes); }); !done)
    return err(done.error());
  if ((bytes[0] & kDone) == 0) return false;
  if (auto done = again([&] { return io::write_register(bus_, settings_.address, kInterruptClear, 0x01); }); !done)
    return err(done.error());
  std::copy(bytes.begin() + 1, bytes.end(), record.begin());
  return true;
}

}  // namespace nacelle::range
