// SPDX-License-Identifier: Apache-2.0
#include "cli/topic_listener.hpp"

#include <poll.h>

#include <algorithm>
#include <cstdio>
#include <optional>
#include <utility>

#include "cli/asking.hpp"
#include "cli/program.hpp"
#include "process/stop_signal.hpp"

namespace nacelle::cli {
namespace {

using nlohmann::json;

/// After so long without a message a person wants to know why nothing is shown.
constexpr Duration kSilence = 2s;

struct Heard {
  control::Client client;  // one topic a connection
  std::string type;
  std::size_t items = 0;
};

Result<Heard, int> open(const Listening& wish, const Listening::Topic& topic) {
  auto client = connect(wish.whom);
  if (!client) return err(client.error());
  json request{{"verb", "topic.listen"},
               {"topic", absolute(topic.name)},
               {"show", wish.show},
               {"field", wish.field},
               {"longest", wish.longest}};
  if (!topic.type.empty()) request["type"] = full_type_name(topic.type, "msg");
  auto reply = client.value().call(request, kAnswerLimit);
  if (!reply) return err(complain(reply.error()));
  return Heard{std::move(client).value(), text_of(reply.value(), "type"), 0};
}

/// The nodes that publish the topic, and of them those that cannot: their lifecycle is not active.
struct Publishers {
  std::vector<std::string> all, inactive;
  std::string state;
};

Publishers publishers_of(const json& graph, const std::string& topic, const std::string& type) {
  Publishers found;
  found.all = texts_of(graph["endpoints"], "node", [&](const json& end) {
    return end["publisher"].get<bool>() && text_of(end, "topic") == topic && text_of(end, "type") == type;
  });
  for (const auto& node : graph["nodes"]) {
    const std::string name = text_of(node, "node"), state = text_of(node, "state");
    // Of nodes outside the state is not known.
    if (!node["managed"].get<bool>() || state == "active" || state.empty() || std::ranges::count(found.all, name) == 0)
      continue;
    found.inactive.push_back(name);
    found.state = state;
  }
  return found;
}

/// Returns why no messages arrive, as far as the container knows.
Problem why_silent(const Listening& wish, const std::string& topic, const Heard& heard) {
  // A container that is busy is not waited for: messages may come meanwhile.
  constexpr Duration kPatience = 500ms;
  const std::string where = "topic " + topic;
  const std::string look = "see " + wish.whom.command("topic info -v " + topic);
  if (heard.items != 0) return {where, "nothing has come since the first message", look};
  auto asking = connect(wish.whom);
  auto graph = asking ? ask::Nodes{asking.value(), kPatience, 0s}.graph() : err(Problem{});
  if (!graph) return {where, "nothing has come yet", wish.whom.is_remote() ? look : "see `nacelle streams`"};
  const Publishers publishers = publishers_of(graph.value(), topic, heard.type);
  if (publishers.all.empty()) {
    return {where, "it does not appear to be published yet: no node has a publisher of " + heard.type,
            "see " + wish.whom.command("topic list -v")};
  }
  if (publishers.inactive.size() == publishers.all.size()) {
    return {where, "nothing has come yet: " + join(publishers.all) + " is " + publishers.state,
            "`nacelle lifecycle set " + publishers.inactive.front() +
                (publishers.state == "inactive" ? " activate`" : " ...`") + " changes that"};
  }
  return {where, "nothing has come yet: " + join(publishers.all) + " has published nothing meanwhile",
          wish.whom.is_remote() ? look : "see `nacelle faults` and `nacelle streams`"};
}

/// Reads the available items. Returns the exit code at the end.
template <typename Take>
std::optional<int> take_all(Heard& heard, std::size_t index, const process::StopSignal& stop, const Take& take) {
  while (true) {
    auto frame = heard.client.receive(0ns);
    if (!frame) return stop.is_raised() ? kDone : complain(frame.error());
    if (!frame.value()) return std::nullopt;
    if (frame.value()->kind == control::FrameKind::Fault) return complain(heard.client.problem_of(*frame.value()));
    if (frame.value()->kind != control::FrameKind::Item) continue;
    ++heard.items;
    if (!take(index, as_text(frame.value()->payload))) return kDone;
  }
}

}  // namespace

int listen(const Listening& wish, const std::function<bool(std::size_t, std::string_view)>& take) {
  for (const auto& topic : wish.topics) {
    if (complain_of_topic_name(topic.name)) return kUsage;
  }
  const process::StopSignal stop{nullptr, process::FullOutput::Dropped};
  const SystemClock clock;
  std::vector<Heard> all;
  for (const auto& topic : wish.topics) {
    auto heard = open(wish, topic);
    if (!heard) return heard.error();
    all.push_back(std::move(heard).value());
  }
  wish.began();
  const MonotonicTime silent_at = clock.now() + kSilence;
  bool looked = false;
  while (!stop.is_raised()) {
    // First messages that are here already: a latched message may have arrived together with the reply, and be the last.
    std::vector<pollfd> waits{{stop.descriptor(), POLLIN, 0}};
    for (std::size_t i = 0; i < all.size(); ++i) {
      if (const auto ended = take_all(all[i], i, stop, take)) return *ended;
      waits.push_back({all[i].client.descriptor(), POLLIN, 0});
    }
    if (!looked && clock.now() >= silent_at) {
      looked = true;
      for (std::size_t i = 0; i < all.size(); ++i) {
        if (all[i].items >= wish.least) continue;
        const Problem why = why_silent(wish, absolute(wish.topics[i].name), all[i]);
        std::fprintf(stderr, "nacelle: warning: %s\n", why.text().c_str());
      }
    }
    const int limit_ms = looked ? -1 : static_cast<int>((silent_at - clock.now()) / 1ms) + 1;
    ::poll(waits.data(), waits.size(), looked ? -1 : std::max(0, limit_ms));
  }
  return kDone;
}

}  // namespace nacelle::cli
