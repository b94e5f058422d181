// SPDX-License-Identifier: Apache-2.0
// The endpoints of this side, and their counterparts on the network.
#include <algorithm>

#include "mirror_impl.hpp"
#include "nacelle/msgs/message_type.hpp"
#include "transport_dds/wire/names.hpp"
#include "transport_dds/wire/user_data.hpp"

namespace nacelle {
namespace {

/// "/arm" and "driver" of "/arm/driver".
std::pair<std::string, std::string> split_node(const std::string& node) {
  const auto slash = node.rfind('/');
  if (slash == std::string::npos) return {"/", node};
  return {slash == 0 ? "/" : node.substr(0, slash), node.substr(slash + 1)};
}

// For large messages of a writer that has ended.
constexpr Duration kLastWords = 1s;

bool keeps_history(const EndpointInfo& writer) {
  return writer.spec.qos.resolved().durability() == Durability::TransientLocal;
}

}  // namespace

bool DdsMirror::Impl::LocalReader::takes() const {
  return info.open || info.spec.qos.resolved().durability() != Durability::TransientLocal;
}

void DdsMirror::Impl::take(const Event& event) {
  const std::uint64_t id = event.info.id;
  switch (event.kind) {
    case Event::Kind::Made: take_made(event.info); break;
    case Event::Kind::Gone: take_gone(id); break;
    case Event::Kind::Gate:
      if (const auto found = readers.find(id); found != readers.end()) {
        found->second->info.open = event.info.open;
        if (event.info.open) note_ready(*found->second);
      }
      break;
    case Event::Kind::Life:
      if (const auto found = writers.find(id); found != writers.end()) {
        found->second->showed_life = true;
        note_ready(*found->second);
      }
      break;
  }
}

void DdsMirror::Impl::take_made(const EndpointInfo& info) {
  const dds::ExportRule* const rule = dds::rule_of(options.exports, info.spec.topic, info.spec.type->name);
  if (rule == nullptr && !options.exports.empty()) {
    hidden.insert(info.id);
    hidden_count = hidden.size();
    return;
  }
  if (auto& gate = topics[info.spec.topic].gate; rule != nullptr && !gate) gate.emplace(*rule);
  if (info.is_writer) {
    make_writer(info);
  } else {
    make_reader(info);
  }
  writer_count = writers.size();
  count_readers();
  are_types_new = true;
  consider_all(info.spec.topic);
}

Result<dds::EndpointOptions, Problem> DdsMirror::Impl::options_for(const EndpointInfo& info) const {
  const EndpointSpec& spec = info.spec;
  auto name = dds::dds_topic_name(spec.topic, spec.qos.avoid_ros_namespace_conventions());
  if (!name) return err(name.error());
  dds::EndpointOptions with;
  with.topic = std::move(*name);
  with.type = spec.type->dds_name;
  with.structure = spec.type->hash;
  with.qos = dds::to_dds(spec.qos);
  const std::string data =
      dds::write_endpoint_user_data({.type_hash = spec.type->hash, .client_id = {}, .service_id = {}});
  const ByteView bytes = as_bytes(data);
  with.user_data.assign(bytes.begin(), bytes.end());
  return with;
}

void DdsMirror::Impl::make_writer(const EndpointInfo& info) {
  auto end = std::make_unique<LocalWriter>(*this, info);
  auto with = options_for(info);
  if (with && with->qos.history == dds::DdsHistory::KeepAll) {
    // A reader that does not acknowledge must not delay other streams: retry later.
    with->qos.max_blocking = Duration::zero();
    with->most_out = static_cast<std::uint32_t>(std::min<std::size_t>(info.spec.qos.max_samples(), 1U << 20U));
  }
  auto writer = with ? participant->create_writer(*with, end.get()) : err(with.error());
  LocalWriter& made = *writers.insert_or_assign(info.id, std::move(end)).first->second;
  topics[info.spec.topic].writers.push_back(&made);
  if (!writer) return tell(end_not_shown(info.spec.topic, info.spec.topic, writer.error()));
  made.writer = std::move(*writer);
  show(info.spec.node, made.writer->gid(), true);
  look_at_status(made);
  for (const auto& [gid, stand_in] : stand_ins) {
    if (!stand_in.end.is_writer && stand_in.end.name == info.spec.topic &&
        !those_that_do_not_serve(stand_in.end).empty())
      wait_in(unserved, gid);
  }
}

void DdsMirror::Impl::make_reader(const EndpointInfo& info) {
  LocalReader& made = *readers.insert_or_assign(info.id, std::make_unique<LocalReader>(*this, info)).first->second;
  topics[info.spec.topic].readers.push_back(&made);
  if (info.spec.announced == Announced::Always) announce(made);
}

void DdsMirror::Impl::announce(LocalReader& end) {
  const EndpointInfo& info = end.info;
  end.is_announced = true;
  auto with = options_for(info);
  if (with) {
    with->qos.ignores_own_participant = true;
    with->most_waiting = std::max<std::size_t>(1, info.spec.qos.max_samples());
  }
  auto reader = with ? participant->create_reader(*with, &end) : err(with.error());
  if (!reader) return tell(end_not_shown(info.spec.topic, info.spec.topic, reader.error()));
  end.reader = std::move(*reader);
  show(info.spec.node, end.reader->gid(), false);
  // What came before the end was to be found.
  end.is_status_new = true;
  end.queued = false;
  note_ready(end);
}

void DdsMirror::Impl::withdraw(LocalReader& end) {
  end.is_announced = false;
  if (!end.reader) return;
  while (receive(topics.at(end.info.spec.topic))) {}
  tell_losses(end);
  hide(end.info.spec.node, end.reader->gid(), false);
  end.head.reset();
  end.told = {};
  end.told_lost = 0;
  std::shared_ptr<dds::Reader> last = std::move(end.reader);
  if (lane.is_busy()) lane.add([last = std::move(last)] {});  // as bury(); the end itself is buried behind it
}

void DdsMirror::Impl::choose_types() {
  if (!std::exchange(are_types_new, false)) return;
  for (auto& [topic, use] : topics) {
    const bool is_one_of_several = std::ranges::any_of(
        use.readers, [](const LocalReader* end) { return end->info.spec.announced != Announced::Always; });
    if (is_one_of_several) choose_type(use, topic);
  }
  count_readers();
}

void DdsMirror::Impl::choose_type(TopicUse& use, const std::string& topic) {
  std::set<std::string, std::less<>> published;
  for (const LocalWriter* writer : use.writers) published.insert(writer->info.spec.type->name);
  for (const auto& end : remote.lock()->ends_of_topic(topic)) {
    if (end.is_writer) published.insert(end.type);
  }
  const auto is_published = [&](const LocalReader* end) { return published.contains(end->info.spec.type->name); };
  const bool any_is = std::ranges::any_of(use.readers, [&](const LocalReader* end) {
    return end->info.spec.announced != Announced::Always && is_published(end);
  });
  const auto is_wanted = [&](const LocalReader* end) {
    switch (end->info.spec.announced) {
      case Announced::Always: return true;
      case Announced::ByDefault: return !any_is || is_published(end);
      case Announced::WithItsPublisher: return is_published(end);
    }
    return true;
  };
  // Withdraws endpoints first, so that peers never see two types.
  for (LocalReader* end : use.readers) {
    if (end->is_announced && !is_wanted(end)) withdraw(*end);
  }
  for (LocalReader* end : use.readers) {
    if (!end->is_announced && is_wanted(end)) announce(*end);
  }
}

void DdsMirror::Impl::count_readers() {
  reader_count = static_cast<std::uint64_t>(
      std::ranges::count_if(readers, [](const auto& each) { return each.second->is_announced; }));
}

void DdsMirror::Impl::take_gone(std::uint64_t id) {
  if (hidden.erase(id) != 0) {
    hidden_count = hidden.size();
    return;
  }
  std::string topic;
  if (const auto writer = writers.find(id); writer != writers.end()) {
    std::unique_ptr<LocalWriter> end = std::move(writer->second);
    topic = end->info.spec.topic;
    if (end->writer) hide(end->info.spec.node, end->writer->gid(), true);
    std::erase(topics.at(topic).writers, end.get());
    writers.erase(writer);
    end->gives_up_at = clock.now() + kLastWords;
    wind_up(std::move(end));
  } else if (const auto reader = readers.find(id); reader != readers.end()) {
    std::unique_ptr<LocalReader> end = std::move(reader->second);
    topic = end->info.spec.topic;
    if (end->reader) hide(end->info.spec.node, end->reader->gid(), false);
    std::erase(topics.at(topic).readers, end.get());
    readers.erase(reader);
    bury(std::move(end));
  } else {
    return;
  }
  std::erase_if(misfits, [&](const auto& pair) { return pair.second == id; });
  writer_count = writers.size();
  count_readers();
  are_types_new = true;
  consider_all(topic);
  const TopicUse& use = topics.at(topic);
  if (use.writers.empty() && use.readers.empty()) topics.erase(topic);
}

// Sends the messages published before its end; of large messages, as many as leave in time.
void DdsMirror::Impl::wind_up(std::unique_ptr<LocalWriter> end) {
  const bool busy = is_busy(*end);
  if (!busy && clock.now() < end->gives_up_at) {
    while (send(*end)) {}
  }
  if (end->at_lane) {
    const std::uint64_t id = end->info.id;
    ending.insert_or_assign(id, std::move(end));
    return;
  }
  count_overtaken(*end);
  if (end->tap) --taps;
  bury(std::move(end));
}

// While a message is being sent, Cyclone blocks the destruction of endpoints.
void DdsMirror::Impl::bury(std::shared_ptr<LocalEnd> end) {
  if (lane.is_busy()) lane.add([end = std::move(end)] {});
}

// A node is there as long as it has ends.
void DdsMirror::Impl::show(const std::string& node, const dds::Gid& gid, bool is_writer) {
  if (node.empty()) return;
  const auto [node_namespace, name] = split_node(node);
  if (ends_of_node[node]++ == 0) own_nodes.add_node(node_namespace, name);
  own_nodes.add_endpoint(node_namespace, name, gid, is_writer);
  is_snapshot_new = true;
}

void DdsMirror::Impl::hide(const std::string& node, const dds::Gid& gid, bool is_writer) {
  if (node.empty()) return;
  own_nodes.remove_endpoint(gid, is_writer);
  if (--ends_of_node[node] == 0) {
    const auto [node_namespace, name] = split_node(node);
    own_nodes.remove_node(node_namespace, name);
    ends_of_node.erase(node);
  }
  is_snapshot_new = true;
}

void DdsMirror::Impl::look_at_status(LocalWriter& end) {
  if (!end.writer) return;
  const bool wanted = keeps_history(end.info) || end.writer->matched_count() != 0;
  if (wanted && !end.tap) {
    end.tap = graph.create_tap(end.info, number, &end);
    end.told_overwritten = 0;
    ++taps;
  } else if (!wanted && end.tap) {
    end.tap.reset();
    end.drop_unsent();
    --taps;
  }
  std::set<dds::Gid> before;
  for (const auto& peer : end.writer->matched()) before.insert(peer.endpoint.gid);
  std::swap(end.matched, before);
  // A publisher that waits for its readers publishes as soon as it sees them; now the tap is there.
  for (const auto& gid : end.matched) {
    if (!before.contains(gid)) count(gid, end, true);
  }
  for (const auto& gid : before) {
    if (!end.matched.contains(gid)) count(gid, end, false);
  }
}

void DdsMirror::Impl::count(const dds::Gid& reader, const LocalWriter& by, bool counts) {
  const auto found = stand_ins.find(reader);
  if (found != stand_ins.end() && found->second.witness) found->second.witness->count_for(by.info.id, counts);
}

void DdsMirror::Impl::look_at_status(LocalReader& end) {
  if (!end.reader) return;
  for (const auto& peer : end.reader->matched()) handles[peer.handle] = peer.endpoint.gid;
}

}  // namespace nacelle
