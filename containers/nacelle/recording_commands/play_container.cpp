// SPDX-License-Identifier: Apache-2.0
#include "recording_commands/play_container.hpp"

#include <unistd.h>

#include <algorithm>
#include <utility>

#include "cli/program.hpp"

namespace nacelle::cli {

Result<std::unique_ptr<PlayContainer>, Problem> PlayContainer::start() {
  constexpr Duration kLimit = 20s, kLook = 20ms;
  const std::string name = "play_" + std::to_string(::getpid());
  process::ProgramSpec spec;
  spec.label = "container " + name;
  spec.path = "/proc/self/exe";
  spec.arguments = {"container", "--name", name};
  auto program = process::ForeignProgram::start(spec);
  if (!program) return err(program.error());
  std::unique_ptr<PlayContainer> made{new PlayContainer{name, std::move(program).value()}};
  const MonotonicTime until = made->clock_.now() + kLimit;
  while (made->clock_.now() < until) {
    if (made->program_->wait_for_end(kLook, made->clock_))
      return err(Problem{spec.label, made->program_->ended(), "its words are above"});
    const auto running = trusted_containers();
    if (std::any_of(running.begin(), running.end(), [&](const auto& one) { return one.name == name; })) return made;
  }
  return err(Problem{spec.label, "does not accept connections after 20 s", "is the machine very busy?"});
}

PlayContainer::~PlayContainer() {
  if (program_->ended().empty()) static_cast<void>(program_->stop(clock_));
}

}  // namespace nacelle::cli
