// SPDX-License-Identifier: Apache-2.0
#include "support/neighbour.hpp"

#include <fcntl.h>
#include <sched.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <csignal>
#include <cstdlib>

namespace nacelle::test {
namespace {

bool shell(const std::string& line) { return std::system((line + " 2>/dev/null").c_str()) == 0; }

}  // namespace

Neighbour::Neighbour() {
  std::array<int, 2> ready{-1, -1};
  if (::pipe2(ready.data(), O_CLOEXEC) != 0) return;
  const pid_t parent = ::getpid();
  holder_ = ::fork();
  if (holder_ == 0) {
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);
    const bool apart = ::getppid() == parent && ::unshare(CLONE_NEWNET) == 0;
    if (!apart || ::write(ready[1], "!", 1) != 1) std::_Exit(1);
    for (;;) ::pause();
  }
  ::close(ready[1]);
  char said = 0;
  const bool apart = ::read(ready[0], &said, 1) == 1;
  ::close(ready[0]);
  if (!apart) return;
  const std::string here = std::to_string(parent), there = std::to_string(holder_), cable = kCable;
  const auto is_set_up = [&cable](const std::string& where, const std::string& address) {
    return shell(where + "ip link set lo up") && shell(where + "ip addr add " + address + "/24 dev " + cable) &&
           shell(where + "ip link set " + cable + " up") && shell(where + "ip route replace 224.0.0.0/4 dev " + cable);
  };
  const std::string inside = "nsenter -t " + there + " -n ";
  is_there_ =
      shell("ip link add name " + cable + " netns " + here + " type veth peer name " + cable + " netns " + there) &&
      is_set_up("", "10.88.0.1") && is_set_up(inside, "10.88.0.2");
}

Neighbour::~Neighbour() {
  if (holder_ <= 0) return;
  // At once, and not when the kernel comes to it: the next one has a link of the same name.
  shell(std::string("ip link del ") + kCable);
  ::kill(holder_, SIGKILL);
  ::waitpid(holder_, nullptr, 0);
}

std::vector<std::string> Neighbour::within(std::vector<std::string> words) const {
  std::vector<std::string> all{"/usr/bin/nsenter", "-t", std::to_string(holder_), "-n"};
  all.insert(all.end(), words.begin(), words.end());
  return all;
}

}  // namespace nacelle::test
