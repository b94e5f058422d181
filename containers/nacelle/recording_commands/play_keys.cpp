// SPDX-License-Identifier: Apache-2.0
#include "recording_commands/play_keys.hpp"

#include <poll.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <nlohmann/json.hpp>
#include <string_view>
#include <utility>

#include "ask/nodes.hpp"
#include "cli/program.hpp"

namespace nacelle::cli {
namespace {

using nlohmann::json;

constexpr double kFaster = 1.1;

/// What a key asks for. Errors are the container's: it says what it does not do.
void carry_out(ask::Nodes& nodes, const std::string& player, char key) {
  const auto call = [&](const char* service, const char* type, const json& request) {
    return nodes.call(player + "/" + service, type, request);
  };
  if (key == ' ') {
    static_cast<void>(call("toggle_paused", "rosbag2_interfaces/srv/TogglePaused", json::object()));
  } else if (key == 'C') {
    static_cast<void>(call("play_next", "rosbag2_interfaces/srv/PlayNext", json::object()));
  } else {
    const auto rate = call("get_rate", "rosbag2_interfaces/srv/GetRate", json::object());
    if (!rate) return;
    const double now = rate->value("rate", 1.0);
    static_cast<void>(
        call("set_rate", "rosbag2_interfaces/srv/SetRate", {{"rate", key == 'A' ? now * kFaster : now / kFaster}}));
  }
}

/// The keys among what was typed: ' ', and the last letter of an arrow's sequence ("\x1b[A" is up, B down, C right). A sequence that is cut
/// goes on in the next read.
std::string keys_of(std::string& typed) {
  std::string keys;
  while (!typed.empty()) {
    if (typed[0] != '\x1b') {
      if (typed[0] == ' ') keys += ' ';
      typed.erase(0, 1);
      continue;
    }
    if (typed.size() < 3) break;
    if (typed[1] == '[' && std::string_view{"ABC"}.find(typed[2]) != std::string_view::npos) keys += typed[2];
    typed.erase(0, 3);
  }
  return keys;
}

}  // namespace

PlayKeys::PlayKeys(Whom whom, std::string player) : whom_(std::move(whom)), player_(std::move(player)) {
  if (mode_.is_on()) thread_ = std::thread{[this] { run(); }};
}

PlayKeys::~PlayKeys() {
  end_.ring();
  if (thread_.joinable()) thread_.join();
}

void PlayKeys::run() {
  auto client = connect(whom_);
  if (!client) return;
  ask::Nodes nodes{client.value()};
  const auto node = nodes.find(player_);
  if (!node) return;
  std::string typed;
  for (;;) {
    std::array<pollfd, 2> waits{pollfd{STDIN_FILENO, POLLIN, 0}, pollfd{end_.descriptor(), POLLIN, 0}};
    if (::poll(waits.data(), waits.size(), -1) < 0 && errno != EINTR) return;
    if (waits[1].revents != 0) return;
    if (waits[0].revents == 0) continue;
    std::array<char, 64> bytes{};
    const ssize_t got = ::read(STDIN_FILENO, bytes.data(), bytes.size());
    if (got <= 0) return;
    typed.append(bytes.data(), static_cast<std::size_t>(got));
    for (const char key : keys_of(typed)) carry_out(nodes, node.value(), key);
  }
}

}  // namespace nacelle::cli
