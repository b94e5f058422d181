// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <deque>
#include <memory>
#include <optional>
#include <string>

#include "control/client.hpp"
#include "nacelle/base/problem.hpp"
#include "nacelle/base/result.hpp"
#include "process/foreign_programs.hpp"

namespace nacelle::drive {

/// Runs a container in a process of its own and reads its output.
/// Threads: one. The destructor stops the process.
class ContainerProcess {
 public:
  /// Starts the process. `show_output`: also prints its output to stderr.
  [[nodiscard]] static Result<std::unique_ptr<ContainerProcess>, Problem> start(process::ProgramSpec spec,
                                                                                std::string container_name,
                                                                                bool show_output, const Clock& clock);
  ContainerProcess(const ContainerProcess&) = delete;
  ContainerProcess& operator=(const ContainerProcess&) = delete;
  ~ContainerProcess();

  /// Blocks until the control socket answers. Errors: the process ended; the limit passed; `stop_descriptor` became
  /// readable.
  [[nodiscard]] Result<control::Client, Problem> connect(Duration limit, int stop_descriptor);
  /// Reads the output. Blocks up to `limit` for more output, the end of the process, or `stop_descriptor`.
  void listen(Duration limit, int stop_descriptor);
  /// Returns how the process ended, such as "exited with 1"; empty while it runs.
  [[nodiscard]] std::string ended() { return process_->ended(); }
  /// Blocks until the process ends and reads its output meanwhile. Stops it after the limit (ForeignProgram::stop()).
  /// Returns how it ended.
  std::string wait_for_end(Duration limit);
  /// Sends SIGINT, as Ctrl-C does.
  void interrupt() const;
  /// Returns the error lines of its output: those that begin with "nacelle: ", each with the indented lines below it.
  /// Empty if there are none; at most 64 KiB.
  [[nodiscard]] const std::string& complaints() const { return complaints_; }
  /// Returns its last 30 lines of output, indented.
  [[nodiscard]] std::string last_lines() const;

 private:
  ContainerProcess(std::unique_ptr<process::ForeignProgram> process, int output, std::string name, bool show_output,
                   const Clock& clock);
  void take_output();
  void take_line(std::string line);

  std::unique_ptr<process::ForeignProgram> process_;
  int output_;
  std::string name_;
  bool show_output_;
  const Clock& clock_;
  std::string partial_;
  std::deque<std::string> lines_;
  std::string complaints_;
  bool complaining_ = false;  // the last line belonged to an error
};

}  // namespace nacelle::drive
