// SPDX-License-Identifier: Apache-2.0
#include "mirrored_brokers.hpp"

#include <algorithm>

#include "nacelle/qos/compatibility.hpp"

namespace nacelle::test {
namespace {

constexpr std::int64_t kDilation = 1000;

QoS dilated(QoS qos) {
  const auto longer = [](Duration time) { return time == kBestAvailableDuration ? time : time * kDilation; };
  return qos.deadline(longer(qos.deadline()))
      .lifespan(longer(qos.lifespan()))
      .liveliness_lease_duration(longer(qos.liveliness_lease_duration()));
}

EndpointSpec dilated(EndpointSpec spec) {
  spec.qos = dilated(spec.qos);
  return spec;
}

bool same_stream(const EndpointSpec& writer, const EndpointSpec& reader) {
  return writer.topic == reader.topic && writer.type == reader.type;
}

bool fits(const EndpointSpec& writer, const EndpointSpec& reader) {
  return same_stream(writer, reader) && verdict_of(writer.qos.resolved(), reader.qos.resolved()) != Verdict::Error;
}

/// Returns whether the reader takes messages of a compatible writer, or leaves them to another reader. DDS does not know of the latter.
bool hears(const EndpointSpec& writer, const EndpointSpec& reader) {
  const bool leaves_it =
      reader.unless_offered && verdict_of(writer.qos.resolved(), reader.unless_offered->resolved()) != Verdict::Error;
  return fits(writer, reader) && !leaves_it;
}

bool keeps(const EndpointSpec& end) { return end.qos.resolved().durability() == Durability::TransientLocal; }

EndpointSpec string_spec(const std::string& topic) {
  return {topic, &String::message_type(), QoS(KeepAll{}), "/settling"};
}

}  // namespace

MonotonicTime DilatedClock::first(MonotonicTime at) const {
  if (at == kNeverExpires) return at;
  return from_ + (at - from_ + Duration{factor_ - 1}) / factor_;
}

class MirroredBrokers::SettlingWriter final : public Writer {
 public:
  SettlingWriter(MirroredBrokers& both, const EndpointSpec& spec)
      : both_(both), spec_(spec), inner_(both.writers_.broker.create_writer(spec)) {
    both_.all_writers_.push_back(this);
  }
  ~SettlingWriter() override {
    std::erase(both_.all_writers_, this);
    inner_.reset();
    both_.settle_graph();
  }
  Block* borrow() override { return inner_->borrow(); }
  Block* adopt(void* message) override { return inner_->adopt(message); }
  PublishResult publish(Block& block) override;
  void assert_liveliness() override {
    inner_->assert_liveliness();
    both_.settle_messages();
  }
  std::size_t reader_count() const override { return inner_->reader_count(); }
  WriterCounters counters() const override { return inner_->counters(); }
  EndpointStatus status() const override { return inner_->status(); }
  std::uint64_t id() const override { return inner_->id(); }

  [[nodiscard]] const EndpointSpec& spec() const { return spec_; }
  [[nodiscard]] std::size_t count_fitting() const;
  [[nodiscard]] bool is_tapped() const { return keeps(spec_) || count_fitting() != 0; }
  /// What a late reader gets of it.
  [[nodiscard]] std::size_t kept() const {
    return keeps(spec_) ? std::min<std::size_t>(published_, spec_.qos.resolved().queue_capacity()) : 0;
  }

 private:
  MirroredBrokers& both_;
  const EndpointSpec spec_;
  std::unique_ptr<Writer> inner_;
  std::size_t published_ = 0;
};

class MirroredBrokers::SettlingReader final : public Reader {
 public:
  SettlingReader(MirroredBrokers& both, const EndpointSpec& spec, Taking taking, ReadyListener* listener)
      : both_(both),
        spec_(spec),
        open_(spec.gate == nullptr || *spec.gate),
        inner_(both.readers_.broker.create_reader(spec, taking, listener)) {
    both_.all_readers_.push_back(this);
    // Cyclone sends a history to reliable readers only.
    const bool asks = keeps(spec_) && spec_.qos.resolved().reliability() == Reliability::Reliable;
    for (const SettlingWriter* writer : both_.all_writers_) {
      if (asks && hears(writer->spec(), spec_)) expect(writer->kept());
    }
    both_.settle_graph();
  }
  ~SettlingReader() override {
    std::erase(both_.all_readers_, this);
    inner_.reset();
    both_.settle_graph();
  }
  Block* take() override { return inner_->take(); }
  bool has_waiting() const override { return inner_->has_waiting(); }
  std::size_t writer_count() const override { return inner_->writer_count(); }
  ReaderCounters counters() const override { return inner_->counters(); }
  EndpointStatus status() const override { return inner_->status(); }
  void set_enabled(bool enabled) override;
  void note_latency(Duration latency) override { inner_->note_latency(latency); }
  void note_rehomed() override { inner_->note_rehomed(); }

  [[nodiscard]] const EndpointSpec& spec() const { return spec_; }
  [[nodiscard]] bool has_all() const { return came() >= expected_; }
  /// So many more are on their way. Behind a closed gate those of a history wait on the network's side.
  void expect(std::size_t messages) {
    if (open_ || !keeps(spec_)) {
      expected_ += messages;
    } else {
      held_ = std::min(held_ + messages, spec_.qos.resolved().queue_capacity());
    }
  }

 private:
  /// Returns the number of messages that were passed to the reader, dropped ones included.
  [[nodiscard]] std::uint64_t came() const {
    const ReaderCounters counters = inner_->counters();
    return counters.received + counters.full + counters.inactive - dropped_by_gate_;
  }

  MirroredBrokers& both_;
  const EndpointSpec spec_;
  bool open_;
  std::unique_ptr<Reader> inner_;
  std::uint64_t expected_ = 0, dropped_by_gate_ = 0;
  std::size_t held_ = 0;
};

std::size_t MirroredBrokers::SettlingWriter::count_fitting() const {
  return static_cast<std::size_t>(std::ranges::count_if(
      both_.all_readers_, [&](const SettlingReader* reader) { return fits(spec_, reader->spec()); }));
}

PublishResult MirroredBrokers::SettlingWriter::publish(Block& block) {
  const PublishResult result = inner_->publish(block);
  if (result == PublishResult::Inactive || result == PublishResult::PoolDry) return result;
  ++published_;
  if (is_tapped()) ++both_.sent_;
  for (SettlingReader* reader : both_.all_readers_) {
    if (hears(spec_, reader->spec())) reader->expect(1);
  }
  both_.settle_messages();
  return result;
}

void MirroredBrokers::SettlingReader::set_enabled(bool enabled) {
  const std::uint64_t before = came();
  inner_->set_enabled(enabled);
  if (!enabled) dropped_by_gate_ += came() - before;  // they had come already
  open_ = enabled;
  if (enabled) expect(std::exchange(held_, 0));
  both_.settle_messages();
}

MirroredBrokers::MirroredBrokers(const Clock& clock) : clock_(clock, kDilation), writers_(clock_), readers_(clock_) {
  int number = 0;
  for (Fence& fence : fences_) {
    const EndpointSpec spec = string_spec("/fence_" + std::to_string(++number));
    fence.writer = writers_.broker.create_writer(spec);
    fence.reader = readers_.broker.create_reader(spec, Taking::Share, &bell_);
    until("the fences have met", [&] { return fence.writer->reader_count() + fence.reader->writer_count() == 2; });
  }
  // The first message of a stream may arrive after later messages, which are sent when Cyclone already knows the readers.
  for (std::size_t i = 0; i < fences_.size(); ++i) send_fence();
}

MirroredBrokers::~MirroredBrokers() = default;

template <typename F>
void MirroredBrokers::until(const char* what, F holds) const {
  if (gave_up_) return;
  gave_up_ = !bell_.until(holds);
  if (gave_up_) ADD_FAILURE() << "the network does not come to rest: " << what;
}

bool MirroredBrokers::has_met() const {
  const std::uint64_t of_fences = fences_.size();
  std::uint64_t taps = of_fences, writers_used = of_fences, readers_used = of_fences;
  for (const SettlingWriter* writer : all_writers_) {
    if (writer->reader_count() != writer->count_fitting()) return false;
    if (writer->is_tapped()) ++taps;
    if (std::ranges::any_of(all_readers_,
                            [&](const auto* reader) { return same_stream(writer->spec(), reader->spec()); }))
      ++writers_used;
  }
  for (const SettlingReader* reader : all_readers_) {
    if (std::ranges::any_of(all_writers_,
                            [&](const auto* writer) { return same_stream(writer->spec(), reader->spec()); }))
      ++readers_used;
  }
  const MirrorStats here = writers_stats(), there = readers_stats();
  return here.writers == of_fences + marks_.size() + all_writers_.size() &&
         there.readers == of_fences + all_readers_.size() && here.taps == taps && here.stand_ins == readers_used &&
         there.stand_ins == writers_used;
}

// Cyclone's threads report the end of an endpoint asynchronously, so all endpoints are counted. Announcements arrive in order:
// once the readers' side of Cyclone (not only the mirror) knows the mark, it knows every endpoint that was made before it.
void MirroredBrokers::settle_graph() const {
  until("matching endpoints have met", [&] { return has_met(); });
  until("what was announced is known", [&] {
    std::size_t known = 0;
    readers_.mirror->look(
        [&](const transport_dds::RemoteGraph& graph) { known = graph.ends_of_topic("/mark").size(); });
    return known == marks_.size();
  });
  settle_messages();
}

bool MirroredBrokers::has_arrived() const {
  const MirrorStats here = writers_stats();
  return here.encoded + here.overtaken + here.refused == sent_ &&
         std::ranges::all_of(all_readers_, [](const SettlingReader* reader) { return reader->has_all(); });
}

void MirroredBrokers::settle_messages() const {
  send_fence();
  if (has_arrived()) return;
  until("what was sent has arrived", [&] { return has_arrived(); });
  send_fence();
  until("the last fence is counted, too", [&] { return has_arrived(); });
}

// Whatever was sent or arrived before it has been handed on when it has: each mirror looks at all in order.
void MirroredBrokers::send_fence() const {
  const Fence& fence = fences_[++rounds_ % fences_.size()];
  ++sent_;
  say(*fence.writer, "fence");
  until("a fence has arrived", [&] { return !hear(*fence.reader).empty(); });
}

std::unique_ptr<Writer> MirroredBrokers::create_writer(const EndpointSpec& spec) {
  auto made = std::make_unique<SettlingWriter>(*this, dilated(spec));
  marks_.push_back(writers_.broker.create_writer(string_spec("/mark")));
  settle_graph();
  return made;
}

std::unique_ptr<Reader> MirroredBrokers::create_reader(const EndpointSpec& spec, Taking taking,
                                                       ReadyListener* listener) {
  return std::make_unique<SettlingReader>(*this, dilated(spec), taking, listener);
}

std::uint64_t MirroredBrokers::copies_at(const std::string& topic) const {
  std::vector<runtime::StreamReport> streams;
  writers_.broker.report(streams);
  const auto found = std::ranges::find(streams, topic, &runtime::StreamReport::name);
  return found == streams.end() ? 0 : found->copies;
}

MonotonicTime MirroredBrokers::watch(MonotonicTime now) {
  const MonotonicTime at = clock_.dilated(now);
  const MonotonicTime due = std::min(writers_.broker.watch(at), readers_.broker.watch(at));
  // A mirror handles due deadlines at the end of a turn. The turn of the first fence is over when the second fence arrives.
  for (std::size_t i = 0; i < fences_.size(); ++i) send_fence();
  return clock_.first(due);
}

}  // namespace nacelle::test
