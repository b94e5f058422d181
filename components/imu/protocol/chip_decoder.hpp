// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "nacelle/base/bytes.hpp"

namespace nacelle::imu {

/// What a block of a polled chip holds.
enum class BlockTag : std::uint8_t {
  Record = 1,    ///< Whole readings, of the data registers or a FIFO.
  Field,         ///< The magnetometer beside the chip.
  Temperature,   ///< The die temperature alone.
  Acceleration,  ///< BMI088: the accelerometer's FIFO.
  Direct         ///< BMI088: the accelerometer's data registers.
};

using Counts = std::array<std::int16_t, 3>;

/// One reading of a chip, in its counts and axes.
struct ChipReading {
  Counts acceleration{}, angular_velocity{};
  std::optional<Counts> field{};                            ///< New since the reading before.
  std::optional<std::array<std::int16_t, 4>> quaternion{};  ///< w x y z
  std::optional<std::int16_t> temperature{};
  std::uint32_t ticks{};  ///< The chip's clock since the reading before; 0: the chip does not say.
  friend bool operator==(const ChipReading&, const ChipReading&) = default;
};

/// Takes readings in their order.
class ReadingSink {
 public:
  ReadingSink() = default;
  ReadingSink(const ReadingSink&) = delete;
  ReadingSink& operator=(const ReadingSink&) = delete;
  virtual ~ReadingSink() = default;
  virtual void on_reading(const ChipReading& reading) = 0;
};

/// Turns the blocks of one kind of chip into readings.
///
/// Threads: one. Allocates: nothing.
class ChipDecoder {
 public:
  /// Every byte is in one place: bytes == used_bytes + skipped_bytes.
  struct Stats {
    std::uint64_t bytes{}, used_bytes{};
    std::uint64_t
        skipped_bytes{};  ///< Of unknown blocks and words, of records that are cut, of fields that are not new.
    std::uint64_t readings{};
    std::uint64_t overflows{};  ///< A FIFO was full: readings were lost.
    friend bool operator==(const Stats&, const Stats&) = default;
  };

  ChipDecoder() = default;
  ChipDecoder(const ChipDecoder&) = delete;
  ChipDecoder& operator=(const ChipDecoder&) = delete;
  virtual ~ChipDecoder() = default;

  void feed(std::uint8_t tag, ByteView payload, ReadingSink& sink);
  /// Forgets what a reading was to be joined of: the chip was set up anew.
  virtual void restart() { pending_ = {}; }
  [[nodiscard]] const Stats& stats() const { return stats_; }

 protected:
  /// Returns how many bytes it could use.
  [[nodiscard]] virtual std::size_t decode(BlockTag tag, ByteView payload, ReadingSink& sink) = 0;
  void emit(ReadingSink& sink);

  ChipReading pending_;  ///< The next reading, as far as it is known.

 private:
  Stats stats_;
};

/// MPU-6050, MPU-9250 and ICM-20948: records of 14 bytes, big-endian, both in the FIFO and in the data registers.
///
///     offset  bytes  MPU-6050, MPU-9250   ICM-20948
///          0      6  acceleration x y z   acceleration x y z
///          6      2  temperature          angular velocity x
///          8      6  angular velocity     angular velocity y z, temperature
///
/// Source: register maps RM-MPU-6000A and RM-MPU-9250A, registers 3B to 48; DS-000189 (ICM-20948), 2D to 3A.
class InvensenseDecoder final : public ChipDecoder {
 public:
  enum class Compass : std::uint8_t { None, Ak8963, Ak09916 };
  InvensenseDecoder(bool temperature_last, Compass compass) : temperature_last_(temperature_last), compass_(compass) {}
  static constexpr std::size_t kRecordBytes = 14;

 private:
  [[nodiscard]] std::size_t decode(BlockTag tag, ByteView payload, ReadingSink& sink) override;

  const bool temperature_last_;
  const Compass compass_;
};

/// LSM6DSOX, with a LIS3MDL beside it.
///
///     FIFO word: tag (sensor in bits 7:3, time slot in 2:1), 6 bytes little-endian.
///     sensor 1 angular velocity, 2 acceleration, 4 timestamp (32 bits of 25 us), others are skipped
///     Data registers from 20: temperature, angular velocity, acceleration, little-endian, 14 bytes.
///     LIS3MDL from 27: status (bit 3: new), x y z little-endian.
///
/// A reading is complete when both sensors of one time slot have come. Its step is that between the last two timestamps, so
/// that it does not matter whether a slot's timestamp comes before or after its sensors.
/// Source: LSM6DSOX data sheet DS12814, sections 6.9 and 9.71; LIS3MDL data sheet DocID024204.
class Lsm6dsoxDecoder final : public ChipDecoder {
 public:
  static constexpr std::size_t kWordBytes = 7, kRecordBytes = 14, kFieldBytes = 7;
  explicit Lsm6dsoxDecoder(bool fifo) : fifo_(fifo) {}
  void restart() override;

 private:
  [[nodiscard]] std::size_t decode(BlockTag tag, ByteView payload, ReadingSink& sink) override;
  bool take_word(const std::uint8_t* word, ReadingSink& sink);

  const bool fifo_;
  std::uint8_t slot_ = 0xFF;
  bool has_acceleration_ = false, has_rate_ = false;
  std::optional<std::uint32_t> last_time_{};
  std::uint32_t since_last_time_ = 0;
};

/// BMI088: two chips in one. A reading is made of each gyro frame, with the acceleration at the same place from the end of the poll.
///
///     accelerometer FIFO, frames: 84 x y z | 44 time (3) | 40 skipped (1) | 48 config (1) | 50 dropped (1) | 80: empty
///     gyro FIFO and both chips' data registers: x y z, little-endian
///     temperature, 22 and 23: 11 bits, the upper 8 first
///
/// Source: BMI088 data sheet BST-BMI088-DS001, sections 4.8 and 5.
class Bmi088Decoder final : public ChipDecoder {
 public:
  static constexpr std::size_t kFrameBytes = 6;
  static constexpr std::size_t kMostAccelerations = 146;  ///< What the FIFO of 1024 bytes holds.
  void restart() override;

 private:
  [[nodiscard]] std::size_t decode(BlockTag tag, ByteView payload, ReadingSink& sink) override;
  [[nodiscard]] std::size_t take_accelerations(ByteView payload);

  std::array<Counts, kMostAccelerations> polled_{};  // of this poll, in their order
  std::size_t polled_count_ = 0;
  bool has_acceleration_ = false;
};

/// BNO055: registers 08 to 35 in one piece, little-endian: acceleration, field, angular velocity, Euler angles, quaternion, linear
/// acceleration, gravity, temperature (one byte), calibration status.
/// Source: BNO055 data sheet BST-BNO055-DS000, section 4.2.1.
class Bno055Decoder final : public ChipDecoder {
 public:
  static constexpr std::size_t kRecordBytes = 46;
  static constexpr std::uint8_t kFirstRegister = 0x08;

 private:
  [[nodiscard]] std::size_t decode(BlockTag tag, ByteView payload, ReadingSink& sink) override;
};

}  // namespace nacelle::imu
