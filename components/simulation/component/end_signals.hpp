// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sys/signalfd.h>
#include <unistd.h>

#include <csignal>

#include "nacelle/io/descriptor.hpp"

namespace nacelle::simulation {

/// Takes SIGTERM and SIGINT as events for as long as it lives.
class EndSignals {
 public:
  EndSignals() {
    sigset_t wanted;
    sigemptyset(&wanted);
    sigaddset(&wanted, SIGTERM);
    sigaddset(&wanted, SIGINT);
    pthread_sigmask(SIG_BLOCK, &wanted, &before_);
    event_ = io::Descriptor{::signalfd(-1, &wanted, SFD_NONBLOCK | SFD_CLOEXEC)};
  }
  EndSignals(const EndSignals&) = delete;
  EndSignals& operator=(const EndSignals&) = delete;
  ~EndSignals() {
    // A signal that is still waiting would end the process when it is let through.
    signalfd_siginfo info{};
    while (::read(event_.number(), &info, sizeof info) == static_cast<ssize_t>(sizeof info)) {}
    pthread_sigmask(SIG_SETMASK, &before_, nullptr);
  }
  [[nodiscard]] int descriptor() const { return event_.number(); }
  /// Takes all signals. Returns true if one of them ends the world. A Ctrl-C of the terminal, which the whole foreground group
  /// gets, counts only if the world has no parent that will end it; a SIGINT sent by a program always counts.
  [[nodiscard]] bool ask_to_end(bool terminal_counts) const {
    bool ends = false;
    signalfd_siginfo info{};
    while (::read(event_.number(), &info, sizeof info) == static_cast<ssize_t>(sizeof info)) {
      ends |= info.ssi_signo == SIGTERM || terminal_counts || info.ssi_code != SI_KERNEL;
    }
    return ends;
  }

 private:
  sigset_t before_{};
  io::Descriptor event_;
};

}  // namespace nacelle::simulation
