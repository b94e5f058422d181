// SPDX-License-Identifier: Apache-2.0
#include "nacelle/teleop/teleop.hpp"

#include <fmt/format.h>
#include <poll.h>
#include <termios.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdio>
#include <string_view>

#include "nacelle/drive/velocity_sender.hpp"

namespace nacelle::teleop {
namespace {

constexpr std::string_view kHelp = R"(Drive with the keys, as in teleop_twist_keyboard:

   u    i    o        q / z   both speeds up / down by 10 %
   j    k    l        w / x   forward speed only
   m    ,    .        e / c   turning speed only

k, space or any other key stops; so does letting go for half a second. Ctrl-C ends.

)";

/// Keys one by one and unseen, for as long as it lives; nothing if stdin is no terminal.
class KeyMode {
 public:
  KeyMode() {
    if (::tcgetattr(STDIN_FILENO, &before_) != 0) return;
    is_terminal_ = true;
    termios raw = before_;
    raw.c_lflag &= ~static_cast<tcflag_t>(ICANON | ECHO);  // ISIG stays: Ctrl-C is a signal
    raw.c_cc[VMIN] = 1;
    raw.c_cc[VTIME] = 0;
    ::tcsetattr(STDIN_FILENO, TCSANOW, &raw);
  }
  KeyMode(const KeyMode&) = delete;
  KeyMode& operator=(const KeyMode&) = delete;
  ~KeyMode() {
    if (is_terminal_) ::tcsetattr(STDIN_FILENO, TCSANOW, &before_);
  }

 private:
  bool is_terminal_ = false;
  termios before_{};
};

void show(const TeleopKeys& keys, const char* note) {
  std::printf("\r\033[Kspeed %.2f m/s  turn %.2f rad/s   now %+.2f m/s %+.2f rad/s%s", keys.speed_mps(),
              keys.yaw_rate_rps(), keys.command().speed_mps, keys.command().yaw_rate_rps, note);
  std::fflush(stdout);
}

}  // namespace

int run_teleop(control::Client& client, const TeleopSettings& settings, const session::StopSignal& stop,
               const Clock& clock) {
  auto sender = drive::VelocitySender::open(client, settings.topic, settings.stamped, settings.frame);
  if (!sender) {
    std::fprintf(stderr, "nacelle: %s\n", sender.error().text().c_str());
    return 1;
  }
  const KeyMode mode;
  TeleopKeys keys{settings.keys};
  std::fwrite(kHelp.data(), 1, kHelp.size(), stdout);
  show(keys, "");

  std::optional<Problem> failure;
  bool ended = false;
  while (!ended && !failure) {
    // Short enough that a release is seen in time; with no key held nothing is sent.
    std::array<pollfd, 3> waits{pollfd{STDIN_FILENO, POLLIN, 0}, pollfd{stop.descriptor(), POLLIN, 0},
                                pollfd{client.descriptor(), POLLIN, 0}};
    if (::poll(waits.data(), waits.size(), 20) < 0 && errno != EINTR) break;
    if (waits[1].revents != 0) break;
    if (waits[0].revents != 0) {
      std::array<char, 64> typed{};
      const ssize_t got = ::read(STDIN_FILENO, typed.data(), typed.size());
      if (got == 0 || (got < 0 && errno != EINTR && errno != EAGAIN)) ended = true;  // the terminal is gone
      for (ssize_t i = 0; i < got; ++i) {
        const KeyEffect effect = keys.press(typed[static_cast<std::size_t>(i)], clock.now());
        show(keys, effect == KeyEffect::Holonomic ? "   (this base can neither slide nor lift)" : "");
      }
    }
    if (waits[2].revents != 0) {
      // Only refusals come unasked.
      auto frame = client.receive(0ns);
      if (!frame) {
        failure = frame.error();
      } else if (frame.value() && frame.value()->kind == control::FrameKind::Fault) {
        failure = Problem{settings.topic, std::string{as_text(frame.value()->payload)}, "is the robot running?"};
      }
    }
    if (const auto command = keys.due(clock.now()); command && !ended && !failure) {
      if (auto sent = sender.value().send(command->speed_mps, command->yaw_rate_rps, clock.wall_now()); !sent)
        failure = sent.error();
      if (*command == TeleopCommand{}) show(keys, "");
    }
  }
  // Whatever ended it: the robot stops.
  for (int i = 0; i < 3 && (!failure || i == 0); ++i) {
    if (auto sent = sender.value().send(0, 0, clock.wall_now()); !sent && !failure) failure = sent.error();
  }
  // An answer to a question asked behind them says that they have arrived.
  if (!failure) static_cast<void>(client.lookup("odom", "base_link", 500ms));
  std::printf("\n");
  if (!failure) return 0;
  std::fprintf(stderr, "nacelle: %s\n", failure->text().c_str());
  return 1;
}

}  // namespace nacelle::teleop
