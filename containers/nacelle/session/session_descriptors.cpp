// SPDX-License-Identifier: Apache-2.0
// How a session handles descriptors that run out or that a component closes (docs/adr/0017).
#include <fmt/format.h>
#include <sys/resource.h>

#include "session/session.hpp"

namespace nacelle::session {
namespace {

// An empty container has about 15 open. Below this limit failures would name wrong causes.
constexpr rlim_t kLeastDescriptors = 64;

rlim_t descriptor_limit() {
  rlimit limit{};
  return ::getrlimit(RLIMIT_NOFILE, &limit) == 0 ? limit.rlim_cur : 0;
}

}  // namespace

Result<void, Problem> Session::check_descriptor_limit() {
  const rlim_t limit = descriptor_limit();
  if (limit >= kLeastDescriptors) return {};
  return err(Problem{"container",
                     fmt::format("the limit of {} open files is too low (minimum {})", limit, kLeastDescriptors),
                     "raise it: `ulimit -n 1024`, or LimitNOFILE= of the service"});
}

void Session::look_at_descriptors() {
  const bool ran_out = service_->has_no_descriptors();
  if (ran_out == told_of_descriptors_) return;
  told_of_descriptors_ = ran_out;
  const std::string limit = std::to_string(descriptor_limit());
  if (ran_out) {
    const FaultReason fault{"out_of_descriptors", "all " + limit + " file descriptors of the process are in use"};
    say("nacelle: " + Problem{"container", fault.text,
                              "commands other than `nacelle estop` are refused; raise `ulimit -n` or close clients"}
                          .text());
    supervision_->set_own_fault(fault);
  } else {
    say("nacelle: container: file descriptors are available again");
    supervision_->set_own_fault({});
    keep_composition();  // with the emergency stops that could not be watched meanwhile
  }
}

}  // namespace nacelle::session
