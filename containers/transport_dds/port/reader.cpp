// SPDX-License-Identifier: Apache-2.0
#include "transport_dds/port/reader.hpp"

#include <algorithm>
#include <array>

#include "nacelle/base/guarded.hpp"
#include "transport_dds/port/core.hpp"
#include "transport_dds/port/cyclone_log.hpp"
#include "transport_dds/port/cyclone_qos.hpp"
#include "transport_dds/port/endpoint_end.hpp"
#include "transport_dds/port/sample_ring.hpp"

namespace nacelle::transport_dds {
namespace {

/// A message in the queue. The thread that takes it looks up its writer.
struct Waiting {
  Payload payload;
  WallTime source_time;
  std::uint64_t writer_handle = 0;
};
using Ring = SampleRing<Waiting>;

constexpr std::size_t kMostKnownWriters = 64;

Ring ring_for(const EndpointOptions& options) {
  const bool keeps_all = options.qos.history == DdsHistory::KeepAll;
  const auto depth = static_cast<std::size_t>(std::max(options.qos.depth, 1));
  return Ring{keeps_all ? options.most_waiting : std::max(depth, options.least_depth)};
}

}  // namespace

struct Reader::Impl {
  explicit Impl(const EndpointOptions& options)
      : queue(std::in_place, ring_for(options)), overwrites(options.qos.history == DdsHistory::KeepLast) {}
  ~Impl() {
    if (topic.type != nullptr) end_endpoint(reader, gid, *topic.type);
    // No listener runs any more. The thread sanitizer does not see that in Cyclone's own locks, but in this one.
    static_cast<void>(queue.lock());
  }

  BlobTopic topic;
  EndpointListener* listener = nullptr;
  Guarded<ReaderStatus> status;
  Guarded<Ring> queue;
  const bool overwrites;
  std::atomic<std::uint64_t> received{0}, taken{0}, overwritten{0}, full{0};
  std::vector<std::pair<std::uint64_t, Gid>> known_writers;  // of take()
  Entity reader;                                             // its listeners touch the other members
  Gid gid;

  template <typename Change>
  static void note(void* self, Change change) noexcept {
    auto& impl = *static_cast<Impl*>(self);
    change(*impl.status.lock());
    if (impl.listener != nullptr) impl.listener->on_status();
  }
  [[nodiscard]] static CycloneListener make_listener(Impl& self);
  void fetch(dds_entity_t from) noexcept;
  void enqueue(Waiting message) noexcept;
  [[nodiscard]] Gid writer_of(std::uint64_t handle);
};

CycloneListener Reader::Impl::make_listener(Impl& self) {
  CycloneListener out{dds_create_listener(&self)};
  dds_lset_data_available(out.get(), [](dds_entity_t from, void* impl) { static_cast<Impl*>(impl)->fetch(from); });
  dds_lset_subscription_matched(out.get(), [](dds_entity_t, const dds_subscription_matched_status_t now, void* impl) {
    note(impl, [&](ReaderStatus& totals) {
      totals.matched = now.current_count;
      totals.matched_total = now.total_count;
    });
  });
  dds_lset_requested_incompatible_qos(out.get(),
                                      [](dds_entity_t, const dds_requested_incompatible_qos_status_t now, void* impl) {
                                        note(impl, [&](ReaderStatus& totals) {
                                          totals.incompatible_qos = now.total_count;
                                          totals.last_policy = static_cast<DdsPolicy>(now.last_policy_id);
                                        });
                                      });
  dds_lset_requested_deadline_missed(
      out.get(), [](dds_entity_t, const dds_requested_deadline_missed_status_t now, void* impl) {
        note(impl, [&](ReaderStatus& totals) { totals.deadline_missed = now.total_count; });
      });
  dds_lset_liveliness_changed(out.get(), [](dds_entity_t, const dds_liveliness_changed_status_t now, void* impl) {
    note(impl, [&](ReaderStatus& totals) {
      totals.alive = now.alive_count;
      totals.not_alive = now.not_alive_count;
    });
  });
  dds_lset_sample_lost(out.get(), [](dds_entity_t, const dds_sample_lost_status_t now, void* impl) {
    note(impl, [&](ReaderStatus& totals) { totals.lost = now.total_count; });
  });
  return out;
}

// On Cyclone's receiving thread, one call at a time.
void Reader::Impl::fetch(dds_entity_t from) noexcept {
  constexpr std::uint32_t kFetchedAtOnce = 16;
  bool any = false;
  for (;;) {
    std::array<ddsi_serdata*, kFetchedAtOnce> blobs{};
    std::array<dds_sample_info_t, kFetchedAtOnce> infos{};
    const dds_return_t count = dds_takecdr(from, blobs.data(), kFetchedAtOnce, infos.data(), DDS_ANY_STATE);
    for (dds_return_t i = 0; i < count; ++i) {
      Payload payload{static_cast<Blob*>(blobs[i])};
      // A sample without data means that a writer has ended, which the status shows too.
      if (!infos[i].valid_data) continue;
      any = true;
      enqueue({std::move(payload), {Duration{infos[i].source_timestamp}}, infos[i].publication_handle});
    }
    if (count < static_cast<dds_return_t>(kFetchedAtOnce)) break;
  }
  if (any && listener != nullptr) listener->on_data();
}

void Reader::Impl::enqueue(Waiting message) noexcept {
  switch (queue.lock()->push(message, overwrites)) {
    case Ring::Pushed::Full: full.fetch_add(1, std::memory_order_relaxed); return;
    case Ring::Pushed::Overwrote: overwritten.fetch_add(1, std::memory_order_relaxed); break;
    case Ring::Pushed::Fine: break;
  }
  received.fetch_add(1, std::memory_order_relaxed);
}

Gid Reader::Impl::writer_of(std::uint64_t handle) {
  for (const auto& [known, writer] : known_writers) {
    if (known == handle) return writer;
  }
  dds_builtintopic_endpoint_t* const found = dds_get_matched_publication_data(reader.get(), handle);
  if (found == nullptr) return {};
  const Gid writer = to_gid(found->key);
  dds_builtintopic_free_endpoint(found);
  if (known_writers.size() == kMostKnownWriters) known_writers.clear();  // those that still write come again
  known_writers.emplace_back(handle, writer);
  return writer;
}

Result<std::unique_ptr<Reader>, Problem> Reader::create(std::shared_ptr<ParticipantCore> core,
                                                        const EndpointOptions& options, EndpointListener* listener) {
  auto impl = std::make_unique<Impl>(options);
  auto topic = make_topic(std::move(core), options);
  if (!topic) return err(topic.error());
  impl->topic = std::move(*topic);
  impl->listener = listener;
  const CycloneQos qos = to_cyclone(options.qos, options.user_data, false);
  const CycloneListener told = Impl::make_listener(*impl);
  const CapturedLog log;
  impl->reader =
      Entity{dds_create_reader(impl->topic.core->participant.get(), impl->topic.topic.get(), qos.get(), told.get())};
  if (!impl->reader) return err(problem_of("DDS reader of", options, log, impl->reader.get()));
  impl->gid = gid_of(impl->reader.get());
  return std::unique_ptr<Reader>(new Reader(std::move(impl)));
}

Reader::Reader(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Reader::~Reader() = default;

std::optional<Sample> Reader::take() {
  Waiting next;
  {
    auto queue = impl_->queue.lock();
    if (queue->empty()) return std::nullopt;
    next = queue->pop();
  }
  impl_->taken.fetch_add(1, std::memory_order_relaxed);
  return Sample{std::move(next.payload), next.source_time, impl_->writer_of(next.writer_handle), next.writer_handle};
}

bool Reader::has_waiting() const { return !impl_->queue.lock()->empty(); }
std::uint32_t Reader::matched_count() const { return impl_->status.lock()->matched; }
Gid Reader::gid() const { return impl_->gid; }
ReaderStatus Reader::status() const { return *impl_->status.lock(); }
ReaderCounters Reader::counters() const {
  return {impl_->received.load(std::memory_order_relaxed), impl_->taken.load(std::memory_order_relaxed),
          impl_->overwritten.load(std::memory_order_relaxed), impl_->full.load(std::memory_order_relaxed),
          impl_->topic.type->pool->refused()};
}
std::vector<MatchedPeer> Reader::matched() const { return matched_peers(impl_->reader.get(), true); }

Result<std::unique_ptr<Reader>, Problem> Participant::create_reader(const EndpointOptions& options,
                                                                    EndpointListener* listener) {
  return Reader::create(core_, options, listener);
}

}  // namespace nacelle::transport_dds
