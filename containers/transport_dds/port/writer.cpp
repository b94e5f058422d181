// SPDX-License-Identifier: Apache-2.0
#include "transport_dds/port/writer.hpp"

#include "nacelle/base/expect.hpp"
#include "nacelle/base/guarded.hpp"
#include "transport_dds/port/core.hpp"
#include "transport_dds/port/cyclone_log.hpp"
#include "transport_dds/port/cyclone_qos.hpp"
#include "transport_dds/port/endpoint_end.hpp"
#include "transport_dds/port/pacing.hpp"

namespace nacelle::transport_dds {

struct Writer::Impl {
  Impl() = default;
  ~Impl() {
    if (topic.type != nullptr) end_endpoint(writer, gid, *topic.type);
  }

  BlobTopic topic;
  EndpointListener* listener = nullptr;
  std::atomic<std::uint32_t>* matched = nullptr;
  std::uint32_t most_out = 0;
  const std::shared_ptr<OutCount> out = std::make_shared<OutCount>(0);
  std::atomic<std::uint64_t> written{0}, refused{0}, failed{0};
  Guarded<WriterStatus> status;
  Entity writer;  // its listeners touch the other members
  Gid gid;
  std::uint64_t handle = 0;

  template <typename Change>
  static void note(void* self, Change change) noexcept {
    auto& impl = *static_cast<Impl*>(self);
    {
      auto totals = impl.status.lock();
      change(*totals);
      impl.matched->store(totals->matched, std::memory_order_relaxed);
    }
    if (impl.listener != nullptr) impl.listener->on_status();
  }
  [[nodiscard]] static CycloneListener make_listener(Impl& self);
};

CycloneListener Writer::Impl::make_listener(Impl& self) {
  CycloneListener out{dds_create_listener(&self)};
  dds_lset_publication_matched(out.get(), [](dds_entity_t, const dds_publication_matched_status_t now, void* impl) {
    note(impl, [&](WriterStatus& totals) {
      totals.matched = now.current_count;
      totals.matched_total = now.total_count;
    });
  });
  dds_lset_offered_incompatible_qos(out.get(),
                                    [](dds_entity_t, const dds_offered_incompatible_qos_status_t now, void* impl) {
                                      note(impl, [&](WriterStatus& totals) {
                                        totals.incompatible_qos = now.total_count;
                                        totals.last_policy = static_cast<DdsPolicy>(now.last_policy_id);
                                      });
                                    });
  dds_lset_offered_deadline_missed(
      out.get(), [](dds_entity_t, const dds_offered_deadline_missed_status_t now, void* impl) {
        note(impl, [&](WriterStatus& totals) { totals.deadline_missed = now.total_count; });
      });
  dds_lset_liveliness_lost(out.get(), [](dds_entity_t, const dds_liveliness_lost_status_t now, void* impl) {
    note(impl, [&](WriterStatus& totals) { totals.liveliness_lost = now.total_count; });
  });
  return out;
}

Result<std::unique_ptr<Writer>, Problem> Writer::create(std::shared_ptr<ParticipantCore> core,
                                                        const EndpointOptions& options, EndpointListener* listener) {
  auto impl = std::make_unique<Impl>();
  auto topic = make_topic(std::move(core), options);
  if (!topic) return err(topic.error());
  impl->topic = std::move(*topic);
  impl->listener = listener;
  impl->most_out = options.most_out;
  std::unique_ptr<Writer> out{new Writer(std::move(impl))};
  Impl& self = *out->impl_;
  self.matched = &out->matched_;
  const CycloneQos qos = to_cyclone(options.qos, options.user_data, true);
  const CycloneListener told = Impl::make_listener(self);
  const CapturedLog log;
  self.writer =
      Entity{dds_create_writer(self.topic.core->participant.get(), self.topic.topic.get(), qos.get(), told.get())};
  if (!self.writer) return err(problem_of("DDS writer of", options, log, self.writer.get()));
  self.gid = gid_of(self.writer.get());
  dds_instance_handle_t handle = 0;
  if (dds_get_instance_handle(self.writer.get(), &handle) == DDS_RETCODE_OK) self.handle = handle;
  return out;
}

Writer::Writer(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Writer::~Writer() = default;

OutgoingPayload Writer::borrow(std::size_t bytes) {
  Impl& self = *impl_;
  Blob* blob = nullptr;
  if (self.most_out == 0 || self.out->load(std::memory_order_relaxed) < self.most_out)
    blob = self.topic.type->pool->borrow(*self.topic.type, bytes);
  if (blob == nullptr) {
    self.refused.fetch_add(1, std::memory_order_relaxed);
    return {};
  }
  blob->out = self.out;
  self.out->fetch_add(1, std::memory_order_relaxed);
  return OutgoingPayload{blob};
}

Writer::Sent Writer::write(OutgoingPayload payload, WallTime source_time) {
  Impl& self = *impl_;
  Blob* const blob = payload.release();
  NACELLE_EXPECT(blob != nullptr && blob->type == self.topic.type, "a payload that this writer has lent");
  // A reader drops a packet with an unknown representation, and requests it again forever.
  if (blob->size < 4 || blob->data()[0] != 0 || blob->data()[1] > 1) {
    ddsi_serdata_unref(blob);
    self.failed.fetch_add(1, std::memory_order_relaxed);
    return Sent::Failed;
  }
  finish_bytes(*blob);
  blob->timestamp.v = source_time.nanoseconds();
  blob->statusinfo = 0;
  const Pacing pacing{blob->size < kPacedFrom ? nullptr : blob->type};
  const dds_return_t did = dds_forwardcdr(self.writer.get(), blob);  // takes over the reference in every case
  if (did == DDS_RETCODE_OK) {
    self.written.fetch_add(1, std::memory_order_relaxed);
    return Sent::Yes;
  }
  self.failed.fetch_add(1, std::memory_order_relaxed);
  return did == DDS_RETCODE_TIMEOUT ? Sent::Refused : Sent::Failed;
}

void Writer::assert_liveliness() { dds_assert_liveliness(impl_->writer.get()); }

bool Writer::wait_for_acknowledgements(Duration limit) {
  return dds_wait_for_acks(impl_->writer.get(), limit.count()) == DDS_RETCODE_OK;
}

Gid Writer::gid() const { return impl_->gid; }
std::uint64_t Writer::handle() const { return impl_->handle; }
WriterStatus Writer::status() const { return *impl_->status.lock(); }
WriterCounters Writer::counters() const {
  return {impl_->written.load(std::memory_order_relaxed), impl_->refused.load(std::memory_order_relaxed),
          impl_->failed.load(std::memory_order_relaxed)};
}
std::uint32_t Writer::out_count() const { return impl_->out->load(std::memory_order_relaxed); }

std::vector<MatchedPeer> Writer::matched() const { return matched_peers(impl_->writer.get(), false); }

Result<std::unique_ptr<Writer>, Problem> Participant::create_writer(const EndpointOptions& options,
                                                                    EndpointListener* listener) {
  return Writer::create(core_, options, listener);
}

}  // namespace nacelle::transport_dds
