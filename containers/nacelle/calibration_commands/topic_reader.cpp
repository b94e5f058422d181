// SPDX-License-Identifier: Apache-2.0
#include "calibration_commands/topic_reader.hpp"

#include <fmt/format.h>
#include <poll.h>

#include <algorithm>
#include <array>

#include "cli/asking.hpp"
#include "cli/program.hpp"
#include "nacelle/base/json_text.hpp"

namespace nacelle::cli {

using nlohmann::json;

Result<TopicReader, int> TopicReader::open(const std::string& container, const std::string& topic) {
  auto client = connect(container);
  if (!client) return err(client.error());
  const json request{{"verb", "topic.listen"}, {"topic", topic}, {"show", "json"}, {"longest", 0}};
  if (auto reply = client.value().call(request, kAnswerLimit); !reply) return err(complain(reply.error()));
  return TopicReader{std::move(client).value(), topic};
}

Result<std::optional<json>, Problem> TopicReader::take() {
  while (true) {
    auto frame = client_.receive(0ns);
    if (!frame) return err(frame.error());
    if (!frame.value()) return std::optional<json>{};
    if (frame.value()->kind == control::FrameKind::Fault) return err(client_.problem_of(*frame.value()));
    if (frame.value()->kind != control::FrameKind::Item) continue;
    json message = parse_json_or_discard(as_text(frame.value()->payload));
    if (message.is_object()) return std::optional<json>{std::move(message)};
  }
}

Result<json, int> next_message(const Dialogue& dialogue, TopicReader& reader, Duration silence) {
  const SystemClock clock;
  const MonotonicTime until = clock.now() + silence;
  while (true) {
    auto message = reader.take();
    if (!message) return err(dialogue.failed(message.error()));
    if (dialogue.stop().is_raised()) return err(dialogue.interrupted());
    if (*message) return std::move(**message);
    const Duration left = until - clock.now();
    if (left <= Duration::zero()) {
      return err(complain({"topic " + reader.topic(), fmt::format("no message came for {:.0f} s", to_seconds(silence)),
                           "is its node active? See `nacelle component list` and `nacelle faults`"}));
    }
    std::array<pollfd, 2> waits{pollfd{reader.descriptor(), POLLIN, 0},
                                pollfd{dialogue.stop().descriptor(), POLLIN, 0}};
    ::poll(waits.data(), waits.size(), static_cast<int>(left / 1ms) + 1);
  }
}

int collect(const Dialogue& dialogue, const std::string& container, const std::string& topic, Duration silence,
            const std::function<bool(const json&)>& take) {
  auto reader = TopicReader::open(container, topic);
  if (!reader) return reader.error();
  while (true) {
    auto message = next_message(dialogue, reader.value(), silence);
    if (!message) return message.error();
    try {
      if (!take(*message)) return kDone;
    } catch (const json::exception&) {
      return complain({"topic " + topic, "has messages of another type than expected", "see `nacelle topic info`"});
    }
  }
}

}  // namespace nacelle::cli
