// SPDX-License-Identifier: Apache-2.0
#include "nacelle/session/lookout.hpp"

#include <poll.h>
#include <pthread.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <array>
#include <cstdint>

namespace nacelle::session {

Lookout::Lookout(const StopSignal& stop, std::function<Duration()> patience, std::function<void()> act)
    : over_(::eventfd(0, EFD_CLOEXEC)),
      thread_([over = over_, signal = stop.descriptor(), patience = std::move(patience), act = std::move(act)] {
        ::pthread_setname_np(::pthread_self(), "lookout");
        std::array<pollfd, 2> waits{pollfd{over, POLLIN, 0}, pollfd{signal, POLLIN, 0}};
        while (waits[0].revents == 0 && waits[1].revents == 0) ::poll(waits.data(), waits.size(), -1);
        if (waits[0].revents != 0) return;
        if (::poll(waits.data(), 1, static_cast<int>(patience() / 1ms)) == 0) act();
      }) {}

Lookout::~Lookout() {
  const std::uint64_t one = 1;
  static_cast<void>(!::write(over_, &one, sizeof one));
  thread_.join();
  ::close(over_);
}

}  // namespace nacelle::session
