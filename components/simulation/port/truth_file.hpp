// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "nacelle/base/problem.hpp"
#include "nacelle/base/result.hpp"

namespace nacelle::simulation {

/// Where the simulated robot really is. Only the report of a run reads it; no component does (design D10).
struct Truth {
  double time_s{};                 ///< Since the world began.
  double x_m{}, y_m{}, yaw_rad{};  ///< Base in the world, which begins at (0, 0, 0). The yaw counts turns: not wrapped.
  double speed_mps{}, yaw_rate_rps{};
  double left_command_mps{}, right_command_mps{};  ///< What the motor board aims at.
  std::uint64_t seed{};
  std::uint64_t motion_commands{};        ///< Carried out by the motor board so far.
  std::int64_t last_motion_command_ns{};  ///< CLOCK_MONOTONIC when the last of them was read; 0 before the first.
  std::int64_t last_start_ns{};           ///< CLOCK_MONOTONIC when the board's aim last left zero; 0: never.
  std::int64_t last_stop_ns{};            ///< The same for when it came back to zero, by any cause.
  std::uint64_t starts{}, stops{};        ///< How often it did either.
  std::uint64_t watchdog_stops{};         ///< Stops by the board's own watchdog, of wheels that were to turn.
  std::uint64_t contacts{};               ///< Steps in which a wall held the robot.
  friend bool operator==(const Truth&, const Truth&) = default;
};

/// Why the truth cannot be read.
enum class TruthFault : std::uint8_t {
  NotThere,      ///< No such file, or no right to read it: is the world running?
  NotATruth,     ///< The file is something else, or another version's.
  KeepsChanging  ///< No quiet moment in a thousand attempts: the writer died in the middle of a write.
};

/// Reads the truth once, consistent in itself. Threads: any, any process, while the world writes.
[[nodiscard]] Result<Truth, TruthFault> read_truth(const std::string& path);

/// The world's side: a small file mapped into memory, with a sequence lock.
///
/// Layout: magic, version, sequence, then Truth as 64-bit words; readers and writer are of one build.
class TruthFile {
 public:
  /// Makes the file, instead of one that is there. Errors: a Problem that names it.
  [[nodiscard]] static Result<std::unique_ptr<TruthFile>, Problem> create(const std::string& path);
  TruthFile(const TruthFile&) = delete;
  TruthFile& operator=(const TruthFile&) = delete;
  /// Removes the file.
  ~TruthFile();

  /// Threads: one. Allocates: nothing; no system call.
  void write(const Truth& truth);

 private:
  struct Mapped;
  TruthFile(std::string path, Mapped* mapped) : path_(std::move(path)), mapped_(mapped) {}

  std::string path_;
  Mapped* mapped_;
  friend Result<Truth, TruthFault> read_truth(const std::string& path);
};

}  // namespace nacelle::simulation
