// SPDX-License-Identifier: Apache-2.0
#include "teleop/teleop.hpp"

#include <fmt/format.h>
#include <poll.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

#include "drive/velocity_sender.hpp"
#include "nacelle/base/json_text.hpp"
#include "process/key_mode.hpp"

namespace nacelle::teleop {
namespace {

constexpr std::string_view kHelp = R"(Drive with the keys, as in teleop_twist_keyboard:

   u    i    o        q / z   both speeds up / down by 10 %
   j    k    l        w / x   forward speed only
   m    ,    .        e / c   turning speed only

k, space or any other key stops; so does letting go for half a second. Ctrl-C ends.
Under an emergency stop the wheels stay stopped until `nacelle estop release`.

)";

constexpr Duration kStopsPeriod = 200ms;

/// Asks again and again which emergency stops are set, and waits for no answer: the keys come first.
class StopWatch {
 public:
  StopWatch(control::Client& client, const Clock& clock, const std::string& container)
      : client_(client),
        clock_(clock),
        question_(nlohmann::json{{"verb", "service.call"},
                                 {"service", container + "/_container/get_emergency_stops"},
                                 {"type", "nacelle_interfaces/srv/GetEmergencyStops"}}
                      .dump()) {}

  /// Asks if it is time. Returns whether the answer has changed.
  bool look() {
    if (is_lost_) return false;
    if (!is_asked_ && clock_.now() >= next_) {
      is_asked_ = client_.send(control::FrameKind::Request, question_).has_value();
      is_lost_ = !is_asked_;
      next_ = clock_.now() + kStopsPeriod;
    }
    if (!is_asked_) return false;
    const auto frame = client_.receive(0ns);
    is_lost_ = !frame.has_value();  // the connection of the commands reports the reason
    if (is_lost_ || !frame.value()) return false;
    is_asked_ = false;
    const auto reply = parse_json_or_discard(as_text(frame.value()->payload));
    std::string set;
    if (reply.is_object() && reply.contains("response")) {
      for (const auto& topic : reply["response"]["topics"]) set += (set.empty() ? "" : ", ") + topic.get<std::string>();
    }
    const bool changed = set != set_;
    set_ = std::move(set);
    return changed;
  }
  /// "/emergency_stop"; empty: none is set.
  [[nodiscard]] const std::string& set() const { return set_; }

 private:
  control::Client& client_;
  const Clock& clock_;
  const std::string question_;
  MonotonicTime next_{};
  std::string set_;
  bool is_asked_ = false, is_lost_ = false;
};

void show(const TeleopKeys& keys, const std::string& stops, const char* note) {
  std::printf("\r\033[Kspeed %.2f m/s  turn %.2f rad/s   ", keys.speed_mps(), keys.yaw_rate_rps());
  if (stops.empty()) {
    std::printf("now %+.2f m/s %+.2f rad/s%s", keys.command().speed_mps, keys.command().yaw_rate_rps, note);
  } else {
    std::printf("%s is set: stands still", stops.c_str());
  }
  std::fflush(stdout);
}

}  // namespace

int run_teleop(control::Client& client, control::Client& asking, const TeleopSettings& settings,
               const process::StopSignal& stop, const Clock& clock) {
  auto sender = drive::VelocitySender::open(client, settings.topic, settings.stamped, settings.frame);
  if (!sender) {
    std::fprintf(stderr, "nacelle: %s\n", sender.error().text().c_str());
    return 1;
  }
  const process::KeyMode mode;
  StopWatch stops{asking, clock, settings.container};
  TeleopKeys keys{settings.keys};
  std::fwrite(kHelp.data(), 1, kHelp.size(), stdout);
  show(keys, stops.set(), "");

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
      if (got == 0 || (got < 0 && errno != EINTR && errno != EAGAIN)) ended = true;  // the terminal was closed
      for (ssize_t i = 0; i < got; ++i) {
        const KeyEffect effect = keys.press(typed[static_cast<std::size_t>(i)], clock.now());
        show(keys, stops.set(), effect == KeyEffect::Holonomic ? "   (this base can neither slide nor lift)" : "");
      }
    }
    if (stops.look()) show(keys, stops.set(), "");
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
      if (*command == TeleopCommand{}) show(keys, stops.set(), "");
    }
  }
  // Whatever ended it: the robot stops.
  for (int i = 0; i < 3 && (!failure || i == 0); ++i) {
    if (auto sent = sender.value().send(0, 0, clock.wall_now()); !sent && !failure) failure = sent.error();
  }
  // The answer to a request sent after them shows that they have arrived.
  if (!failure) static_cast<void>(client.lookup("odom", "base_link", 500ms));
  std::printf("\n");
  if (!failure) return 0;
  std::fprintf(stderr, "nacelle: %s\n", failure->text().c_str());
  return 1;
}

}  // namespace nacelle::teleop
