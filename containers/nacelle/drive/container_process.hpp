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

/// A container in its own process, and its output.
/// Threads: one. The destructor ends the process.
class ContainerProcess {
 public:
  /// `show_output`: also prints its lines to stderr.
  [[nodiscard]] static Result<std::unique_ptr<ContainerProcess>, Problem> start(process::ProgramSpec spec,
                                                                                std::string container_name,
                                                                                bool show_output, const Clock& clock);
  ContainerProcess(const ContainerProcess&) = delete;
  ContainerProcess& operator=(const ContainerProcess&) = delete;
  ~ContainerProcess();

  /// Waits until the control socket answers. Errors: the process ended (with its last lines), or the limit passed.
  [[nodiscard]] Result<control::Client, Problem> connect(Duration limit, int stop_descriptor);
  /// Reads its output, waiting up to `limit` for more, for its end, or for `stop_descriptor`.
  void listen(Duration limit, int stop_descriptor);
  /// "exited with 1"; empty while it runs.
  [[nodiscard]] std::string ended() { return process_->ended(); }
  /// Waits for its end while reading its output; kills it after the limit. Returns how it ended.
  std::string wait_for_end(Duration limit);
  /// Asks it to end as Ctrl-C does.
  void interrupt() const;
  /// Returns its error lines, which begin with "nacelle: ", each with the indented lines below it. Empty if there were
  /// none.
  [[nodiscard]] const std::string& complaints() const { return complaints_; }
  /// Returns its last lines of output, indented.
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
  bool complaining_ = false;  // the last line was one, or belonged to one
};

}  // namespace nacelle::drive
