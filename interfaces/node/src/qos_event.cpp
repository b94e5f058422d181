// SPDX-License-Identifier: Apache-2.0
#include "nacelle/node/qos_event.hpp"

namespace nacelle::detail {
namespace {

template <typename Info>
void count(const std::function<void(Info&)>& callback, std::uint64_t now, std::uint64_t before) {
  if (!callback || now == before) return;
  Info info{now, now - before};
  callback(info);
}

void matched(const std::function<void(MatchedInfo&)>& callback, const EndpointStatus& now,
             const EndpointStatus& before) {
  if (!callback || (now.matched_total == before.matched_total && now.matched == before.matched)) return;
  MatchedInfo info{now.matched_total, now.matched_total - before.matched_total, now.matched,
                   static_cast<std::int32_t>(now.matched) - static_cast<std::int32_t>(before.matched)};
  callback(info);
}

QOSOfferedIncompatibleQoSInfo clash(std::uint64_t now, std::uint64_t before, const EndpointStatus& status) {
  return {now, now - before, status.last_policy, status.last_clash};
}

}  // namespace

void EndpointEvents::run(void* context) {
  auto& self = *static_cast<EndpointEvents*>(context);
  EndpointStatus now;
  if (!self.read(now)) return;  // the endpoint is being made; watch() comes back to this
  self.compare(now, self.last_);
  self.last_ = std::move(now);
}

void PublisherEvents::watch(const Writer& writer) {
  writer_ = &writer;
  listener()->on_status();
}

bool PublisherEvents::read(EndpointStatus& status) const {
  const Writer* const writer = writer_;
  if (writer == nullptr) return false;
  status = writer->status();
  return true;
}

void PublisherEvents::compare(const EndpointStatus& now, const EndpointStatus& before) {
  count(callbacks_.deadline_callback, now.deadline_missed, before.deadline_missed);
  count(callbacks_.liveliness_callback, now.liveliness_lost, before.liveliness_lost);
  matched(callbacks_.matched_callback, now, before);
  if (callbacks_.incompatible_qos_callback && now.incompatible_qos != before.incompatible_qos) {
    auto info = clash(now.incompatible_qos, before.incompatible_qos, now);
    callbacks_.incompatible_qos_callback(info);
  }
  if (callbacks_.incompatible_type_callback && now.incompatible_type != before.incompatible_type) {
    auto info = clash(now.incompatible_type, before.incompatible_type, now);
    callbacks_.incompatible_type_callback(info);
  }
}

void SubscriptionEvents::watch(const Reader& reader) {
  reader_ = &reader;
  listener()->on_status();
}

bool SubscriptionEvents::read(EndpointStatus& status) const {
  const Reader* const reader = reader_;
  if (reader == nullptr) return false;
  status = reader->status();
  return true;
}

void SubscriptionEvents::compare(const EndpointStatus& now, const EndpointStatus& before) {
  count(callbacks_.deadline_callback, now.deadline_missed, before.deadline_missed);
  count(callbacks_.message_lost_callback, now.lost, before.lost);
  if (callbacks_.liveliness_callback && (now.alive != before.alive || now.not_alive != before.not_alive)) {
    QOSLivelinessChangedInfo info{
        now.alive, now.not_alive, static_cast<std::int32_t>(now.alive) - static_cast<std::int32_t>(before.alive),
        static_cast<std::int32_t>(now.not_alive) - static_cast<std::int32_t>(before.not_alive)};
    callbacks_.liveliness_callback(info);
  }
  matched(callbacks_.matched_callback, now, before);
  const auto incompatible = [&](const auto& callback, std::uint64_t total, std::uint64_t total_before) {
    if (total == total_before) return;
    auto info = clash(total, total_before, now);
    if (callback) {
      callback(info);
    } else {
      logger_.warn("{}", info.text);
    }
  };
  incompatible(callbacks_.incompatible_qos_callback, now.incompatible_qos, before.incompatible_qos);
  incompatible(callbacks_.incompatible_type_callback, now.incompatible_type, before.incompatible_type);
}

}  // namespace nacelle::detail
