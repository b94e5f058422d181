// SPDX-License-Identifier: Apache-2.0
#include "session/lookout.hpp"

#include <poll.h>
#include <pthread.h>

#include <array>

namespace nacelle::session {

Lookout::Lookout(const process::StopSignal& stop, std::function<Duration()> patience, std::function<void()> act)
    : thread_([over = over_.descriptor(), signal = stop.descriptor(), patience = std::move(patience),
               act = std::move(act)] {
        ::pthread_setname_np(::pthread_self(), "lookout");
        std::array<pollfd, 2> waits{pollfd{over, POLLIN, 0}, pollfd{signal, POLLIN, 0}};
        while (waits[0].revents == 0 && waits[1].revents == 0) ::poll(waits.data(), waits.size(), -1);
        // A closed descriptor (POLLNVAL) is no signal. The main thread detects it as well.
        if (waits[0].revents != 0 || (waits[1].revents & POLLIN) == 0) return;
        if (::poll(waits.data(), 1, static_cast<int>(patience() / 1ms)) == 0) act();
      }) {}

Lookout::~Lookout() {
  over_.ring();
  thread_.join();
}

}  // namespace nacelle::session
