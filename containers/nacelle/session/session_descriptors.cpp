// SPDX-License-Identifier: Apache-2.0
// How a session handles descriptors that run out or that a component closes (docs/adr/0017).
#include <fmt/format.h>
#include <poll.h>
#include <sys/resource.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "nacelle/desk/verb_desk.hpp"
#include "nacelle/process/attempt.hpp"
#include "nacelle/session/session.hpp"

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

Result<void, Problem> Session::wait(std::vector<pollfd>& waits, std::size_t guests_at, int limit_ms) {
  int ready = ::poll(waits.data(), waits.size(), limit_ms);
  if (ready < 0 && errno != EINTR) {
    // EINVAL: the limit was lowered below the number of connections; or ENOMEM. Clients must not end the robot.
    process::attempt("requests",
                     [&] { desk_->send_half_away("closed: too many connections for the limit of open files"); });
    waits.resize(guests_at);
    ready = ::poll(waits.data(), waits.size(), 0);
    if (ready < 0 && errno != EINTR) {
      return err(Problem{"container", std::string{"poll failed: "} + std::strerror(errno), "raise `ulimit -n`"});
    }
    process::attempt("requests", [&] { desk_->append_waits(waits); });  // looked at in the next round
  }
  const auto is_lost = [](const pollfd& wait) { return (wait.revents & POLLNVAL) != 0; };
  const bool is_signal =
      (waits[0].revents & POLLIN) == 0 || stop_.is_raised();  // else another file has this number now
  if (!is_signal || service_->has_lost_a_descriptor() ||
      std::any_of(waits.begin(), waits.begin() + static_cast<std::ptrdiff_t>(guests_at), is_lost)) {
    lost_descriptors_ = true;
    return err(Problem{"container", "a component closed file descriptors of the container",
                       "find the component that calls closefrom() or closes a descriptor twice; run it with "
                       "`isolate: process`"});
  }
  return {};
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
