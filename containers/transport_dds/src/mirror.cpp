// SPDX-License-Identifier: Apache-2.0
#include "nacelle/transport_dds/mirror.hpp"

#include <pthread.h>

#include <algorithm>
#include <chrono>

#include "mirror_impl.hpp"
#include "mirror_services.hpp"
#include "nacelle/msgs/message_type.hpp"
#include "transport_dds/wire/names.hpp"
#include "transport_dds/wire/user_data.hpp"

namespace nacelle {
namespace {

// A peer can make up as many names as it likes.
constexpr std::size_t kMostTold = 256;

Bytes bytes_of(const std::string& text) {
  const ByteView view = as_bytes(text);
  return {view.begin(), view.end()};
}

}  // namespace

DdsMirror::Impl::Impl(Graph& g, const Clock& c, MirrorOptions o, std::unique_ptr<dds::Participant> p)
    : graph(g),
      clock(c),
      options(std::move(o)),
      participant(std::move(p)),
      own_nodes(participant->gid()),
      remote(std::in_place, participant->gid()) {}

Result<void, Problem> DdsMirror::Impl::open(ServiceGraph* service_graph) {
  const msgs::MessageType& type = dds::Snapshot::message_type();
  dds::EndpointOptions with;
  with.topic = dds::kDiscoveryTopic;
  with.type = type.dds_name;
  with.structure = type.hash;
  with.user_data = bytes_of(dds::write_endpoint_user_data({.type_hash = type.hash, .client_id = {}, .service_id = {}}));
  with.qos = dds::discovery_writer_qos();
  auto writer = participant->create_writer(with, nullptr);
  if (!writer) return err(writer.error());
  snapshot_writer = std::move(*writer);
  with.qos = dds::discovery_reader_qos();
  auto reader = participant->create_reader(with, &snapshot_listener);
  if (!reader) return err(reader.error());
  snapshot_reader = std::move(*reader);
  auto found = participant->create_discovery(this);
  if (!found) return err(found.error());
  discovery = std::move(*found);
  number = graph.join(*this);
  if (service_graph != nullptr) services = std::make_unique<Services>(*this, *service_graph);
  thread = std::thread([this] { run(); });
  return {};
}

DdsMirror::Impl::~Impl() {
  note([](Noted& to) { to.stopping = true; });
  if (thread.joinable()) thread.join();
  // The message that is on its way may need minutes more; the goodbyes must not be lost with it.
  const bool hurries = lane.is_busy();
  if (hurries) participant->set_mute(true);
  lane.stop();
  if (hurries) participant->set_mute(false);
  if (number != 0) graph.leave(number);
  services.reset();
  if (options.clock_skews) options.clock_skews->replace({});
  // Before the objects that they use, and without notifying a graph of each end.
  stand_ins.clear();
  writers.clear();
  ending.clear();
  readers.clear();
}

// --- notifications ---------------------------------------------------------------------------------------------------

template <typename F>
void DdsMirror::Impl::note(F change) noexcept {
  bool wake = false;
  {
    const LockGuard lock(noting);
    change(noted);
    wake = std::exchange(sleeping, false);
  }
  if (wake) woken.notify_one();
}

void DdsMirror::Impl::on_made(const EndpointInfo& endpoint) noexcept {
  if (number != 0 && endpoint.spec.via == number) return;
  note([&](Noted& to) { to.events.push_back({Event::Kind::Made, endpoint}); });
}

void DdsMirror::Impl::on_gone(std::uint64_t id) noexcept {
  note([&](Noted& to) { to.events.push_back({Event::Kind::Gone, {.id = id, .spec = {}}}); });
}

void DdsMirror::Impl::on_gate(std::uint64_t reader, bool open) noexcept {
  note([&](Noted& to) { to.events.push_back({Event::Kind::Gate, {.id = reader, .open = open, .spec = {}}}); });
}

void DdsMirror::Impl::on_life(std::uint64_t writer) noexcept {
  note([&](Noted& to) { to.events.push_back({Event::Kind::Life, {.id = writer, .spec = {}}}); });
}

void DdsMirror::Impl::on_discovery() noexcept {
  note([](Noted& to) { to.discovery = true; });
}

void DdsMirror::Impl::note_services() noexcept {
  note([](Noted& to) { to.services = true; });
}

void DdsMirror::Impl::SnapshotListener::on_data() noexcept {
  mirror.note([](Noted& to) { to.snapshots = true; });
}

void DdsMirror::Impl::note_ready(LocalEnd& end) noexcept {
  if (end.queued.exchange(true)) return;
  note([&](Noted& to) { to.ready.push_back(end.info.id); });
}

// --- the thread ------------------------------------------------------------------------------------------------------

void DdsMirror::Impl::run() {
  pthread_setname_np(pthread_self(), "network");
  MonotonicTime due = kNeverExpires;
  for (;;) {
    {
      UniqueLock lock(noting);
      sleeping = !noted.any();
      if (sleeping && due == kNeverExpires) {
        woken.wait(lock.raw(), [&]() NACELLE_REQUIRES(noting) { return noted.any(); });
      } else if (sleeping) {
        const Duration wait = std::max(due - clock.now(), Duration{1ms});
        woken.wait_for(lock.raw(), wait, [&]() NACELLE_REQUIRES(noting) { return noted.any(); });
      }
      sleeping = false;
      std::swap(noted, now);
    }
    if (now.stopping) return;
    turn();
    due = std::min({show_life(), send_held_up(), look_at_misfits()});
    if (services) due = std::min(due, services->due());
  }
}

void DdsMirror::Impl::turn() {
  // Ends that have come and gone since the last turn are not worth an announcement, and may be many.
  std::set<std::uint64_t> ends;
  std::vector<bool> is_over(now.events.size());
  for (std::size_t i = now.events.size(); i-- > 0;) {
    const Event& event = now.events[i];
    if (event.kind == Event::Kind::Gone) ends.insert(event.info.id);
    is_over[i] = event.kind == Event::Kind::Made && ends.erase(event.info.id) != 0;
  }
  for (std::size_t i = 0; i < now.events.size(); ++i) {
    if (!is_over[i]) take(now.events[i]);
  }
  if (now.discovery) take_discovery();
  if (now.snapshots) take_snapshots();
  // Before the topics, so that an action's client gets the goal response before the goal's status and feedback.
  if (services) services->turn();
  for (const auto id : now.ready) {
    if (const auto writer = writers.find(id); writer != writers.end()) {
      LocalWriter& end = *writer->second;
      // Reset before reading: events that arrive meanwhile signal again.
      end.queued = false;
      const bool busy = is_busy(end);
      // Cyclone cannot be queried about a writer that is writing. The lane notifies when it is done.
      if (!end.at_lane && end.is_status_new.exchange(false)) look_at_status(end);
      if (!busy) send(end);
      count_overtaken(end);
    } else if (const auto reader = readers.find(id); reader != readers.end()) {
      LocalReader& end = *reader->second;
      end.queued = false;
      if (end.is_status_new.exchange(false)) look_at_status(end);
      receive(topics.at(end.info.spec.topic));
      tell_losses(end);
    } else if (auto last = ending.extract(id); last) {
      last.mapped()->queued = false;
      wind_up(std::move(last.mapped()));
    }
  }
  drop_gone();
  choose_types();
  if (is_snapshot_new || now.discovery || now.snapshots) look_for_namesakes();
  if (is_snapshot_new) send_snapshot();
  now.events.clear();
  now.ready.clear();
  now.discovery = now.snapshots = now.services = false;
}

void DdsMirror::Impl::tell(const Problem& problem) {
  ++problems;
  if (options.on_problem) {
    options.on_problem(problem);
  } else {
    log.error("{}", problem.text());
  }
}

void DdsMirror::Impl::tell_once(const std::string& key, const Problem& problem) {
  if (told.size() > kMostTold || !told.insert(key).second) return;
  if (told.size() <= kMostTold) return tell(problem);
  tell({"network", fmt::format("{} problems with other participants were reported; new ones are not", kMostTold),
        "fix those, and restart the container to see further ones"});
}

// --- the face --------------------------------------------------------------------------------------------------------

DdsMirror::DdsMirror(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
DdsMirror::~DdsMirror() = default;

namespace {
dds::ParticipantOptions participant_options(const MirrorOptions& options) {
  dds::ParticipantOptions with;
  with.domain_id = options.domain_id;
  with.config = options.config;
  with.stays_on_this_machine = options.stays_on_this_machine;
  with.user_data = bytes_of(dds::write_participant_user_data(options.enclave));
  with.most_message_bytes = options.most_message_bytes;
  with.security = options.security;
  return with;
}
}  // namespace

Result<std::vector<Problem>, Problem> DdsMirror::try_to_join(const MirrorOptions& options) {
  dds::ParticipantOptions with = participant_options(options);
  with.is_trial = true;
  const auto participant = dds::Participant::create(with);
  if (!participant) return err(participant.error());
  return participant.value()->remarks();
}

Result<std::unique_ptr<DdsMirror>, Problem> DdsMirror::start(Graph& graph, const Clock& clock, MirrorOptions options,
                                                             ServiceGraph* services) {
  auto participant = dds::Participant::create(participant_options(options));
  if (!participant) return err(participant.error());
  const auto remarks = participant.value()->remarks();
  auto impl = std::make_unique<Impl>(graph, clock, std::move(options), std::move(*participant));
  for (const auto& remark : remarks) impl->tell(remark);  // while it has no thread
  if (const auto opened = impl->open(services); !opened) return err(opened.error());
  return std::unique_ptr<DdsMirror>(new DdsMirror(std::move(impl)));
}

std::vector<Namesake> DdsMirror::namesakes() const { return *impl_->namesakes.lock(); }

MirrorStats DdsMirror::stats() const {
  const Impl& of = *impl_;
  MirrorStats out;
  out.encoded = of.encoded;
  out.bytes_encoded = of.bytes_encoded;
  out.overtaken = of.overtaken;
  out.held_back = of.held_back;
  out.refused = of.refused;
  out.received = of.received;
  out.decoded = of.decoded;
  out.broken = of.broken;
  out.stray = of.stray;
  out.snapshots = of.snapshots;
  out.problems = of.problems;
  out.writers = of.writer_count;
  out.readers = of.reader_count;
  out.hidden = of.hidden_count;
  out.taps = of.taps;
  out.stand_ins = of.stand_in_count;
  if (of.services) of.services->fill(out);
  return out;
}

std::vector<ClockSkew> DdsMirror::clock_skews() const { return *impl_->host_skews.lock(); }

void DdsMirror::look(const std::function<void(const transport_dds::RemoteGraph&)>& at) const {
  at(*impl_->remote.lock());
}

}  // namespace nacelle
