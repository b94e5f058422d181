// SPDX-License-Identifier: Apache-2.0
#include "nacelle/qos/compatibility.hpp"

#include <algorithm>

#include "nacelle/qos/text.hpp"

namespace nacelle {
namespace {

// A policy with two values that can clash: the publisher's weak one against the subscription's strong one.
// system_default and unknown may be either, so they warn where the other side would make one of them an error.
template <typename Policy>
Verdict enum_verdict(Policy offered, Policy requested, Policy weak, Policy strong) {
  const auto open = [](Policy p) { return p == Policy::SystemDefault || p == Policy::Unknown; };
  if (offered == weak && requested == strong) return Verdict::Error;
  const bool may_be_weak = offered == weak || open(offered);
  const bool may_be_strong = requested == strong || open(requested);
  return may_be_weak && may_be_strong ? Verdict::Warning : Verdict::Ok;
}

Verdict duration_verdict(Duration offered, Duration requested) {
  if (offered == kBestAvailableDuration || requested == kBestAvailableDuration) return Verdict::Ok;
  if (requested == Duration::zero()) return Verdict::Ok;  // infinite: nothing is asked for
  return offered == Duration::zero() || requested < offered ? Verdict::Error : Verdict::Ok;
}

Verdict reliability_verdict(const QoS& o, const QoS& r) {
  return enum_verdict(o.reliability(), r.reliability(), Reliability::BestEffort, Reliability::Reliable);
}
Verdict durability_verdict(const QoS& o, const QoS& r) {
  return enum_verdict(o.durability(), r.durability(), Durability::Volatile, Durability::TransientLocal);
}
Verdict liveliness_verdict(const QoS& o, const QoS& r) {
  return enum_verdict(o.liveliness(), r.liveliness(), Liveliness::Automatic, Liveliness::ManualByTopic);
}
Verdict deadline_verdict(const QoS& o, const QoS& r) { return duration_verdict(o.deadline(), r.deadline()); }
Verdict lease_verdict(const QoS& o, const QoS& r) {
  return duration_verdict(o.liveliness_lease_duration(), r.liveliness_lease_duration());
}

std::string change_of_enum(const std::string& policy, const std::string& weak, const std::string& strong, Verdict v) {
  const std::string change =
      "request " + policy + " " + weak + " in the subscription, or offer " + strong + " in the publisher";
  return v == Verdict::Error ? change : "name the value on both sides: " + change;
}

std::string change_of_duration(const std::string& policy, Duration offered, Duration requested) {
  const std::string offer = "offer at most " + to_text(requested) + " in the publisher";
  if (offered == Duration::zero()) return "request no " + policy + " in the subscription, or " + offer;
  return "request a " + policy + " of at least " + to_text(offered) + " in the subscription, or " + offer;
}

bool any_liveliness_manual(std::span<const QoS> all) {
  return std::any_of(all.begin(), all.end(), [](const QoS& q) { return q.liveliness() == Liveliness::ManualByTopic; });
}

// Infinite only if it is infinite for all; else the extreme of those given.
template <typename Get, typename Better>
Duration extreme(std::span<const QoS> all, Get get, Better better) {
  Duration chosen{};
  for (const QoS& q : all) {
    const Duration d = get(q);
    if (d == Duration::zero()) continue;
    if (chosen == Duration::zero() || better(d, chosen)) chosen = d;
  }
  return chosen;
}

}  // namespace

std::string Clash::text() const {
  return policy + ": the publisher offers " + offered + ", the subscription requests " + requested + "; " + change;
}

std::string Clash::between(const std::string& publisher, const std::string& subscription) const {
  return publisher + " publishes with " + policy + " " + offered + ", " + subscription + " asks for " + requested +
         ": it gets nothing from it";
}

std::string Compatibility::text() const {
  if (clashes.empty()) return "ok";
  std::string all;
  for (const auto& clash : clashes) {
    if (!all.empty()) all += '\n';
    all += (clash.severity == Verdict::Error ? "error: " : "warning: ") + clash.text();
  }
  return all;
}

Verdict verdict_of(const QoS& o, const QoS& r) {
  return std::max({reliability_verdict(o, r), durability_verdict(o, r), deadline_verdict(o, r),
                   liveliness_verdict(o, r), lease_verdict(o, r)});
}

Compatibility check(const QoS& o, const QoS& r) {
  Compatibility answer{verdict_of(o, r), {}};
  if (answer.verdict == Verdict::Ok) return answer;
  // Only the worst is reported: a warning beside an error would lead to the wrong line first.
  const auto add = [&answer](Verdict severity, std::string policy, std::string offered, std::string requested,
                             auto change) {
    if (severity != answer.verdict) return;
    answer.clashes.push_back({severity, std::move(policy), std::move(offered), std::move(requested), change(severity)});
  };
  add(reliability_verdict(o, r), "reliability", to_text(o.reliability()), to_text(r.reliability()),
      [](Verdict v) { return change_of_enum("reliability", "best_effort", "reliable", v); });
  add(durability_verdict(o, r), "durability", to_text(o.durability()), to_text(r.durability()),
      [](Verdict v) { return change_of_enum("durability", "volatile", "transient_local", v); });
  add(deadline_verdict(o, r), "deadline", policy_duration_text(o.deadline()), policy_duration_text(r.deadline()),
      [&](Verdict) { return change_of_duration("deadline", o.deadline(), r.deadline()); });
  add(liveliness_verdict(o, r), "liveliness", to_text(o.liveliness()), to_text(r.liveliness()),
      [](Verdict v) { return change_of_enum("liveliness", "automatic", "manual_by_topic", v); });
  const Duration offered_lease = o.liveliness_lease_duration();
  const Duration requested_lease = r.liveliness_lease_duration();
  add(lease_verdict(o, r), "liveliness_lease_duration", policy_duration_text(offered_lease),
      policy_duration_text(requested_lease),
      [&](Verdict) { return change_of_duration("liveliness lease", offered_lease, requested_lease); });
  return answer;
}

QoS best_available_for_subscription(QoS subscription, std::span<const QoS> publishers) {
  const auto all = [publishers](auto has) { return std::all_of(publishers.begin(), publishers.end(), has); };
  if (subscription.reliability() == Reliability::BestAvailable) {
    const bool reliable = all([](const QoS& q) { return q.reliability() == Reliability::Reliable; });
    subscription.reliability(reliable ? Reliability::Reliable : Reliability::BestEffort);
  }
  if (subscription.durability() == Durability::BestAvailable) {
    const bool kept = all([](const QoS& q) { return q.durability() == Durability::TransientLocal; });
    subscription.durability(kept ? Durability::TransientLocal : Durability::Volatile);
  }
  if (subscription.liveliness() == Liveliness::BestAvailable) {
    // Of no publishers "all" is true of anything; automatic asks for least.
    const bool manual =
        !publishers.empty() && all([](const QoS& q) { return q.liveliness() == Liveliness::ManualByTopic; });
    subscription.liveliness(manual ? Liveliness::ManualByTopic : Liveliness::Automatic);
  }
  const auto largest = [](Duration a, Duration b) { return a > b; };
  const auto deadline_of = [](const QoS& q) { return q.deadline(); };
  const auto lease_of = [](const QoS& q) { return q.liveliness_lease_duration(); };
  if (subscription.deadline() == kBestAvailableDuration) {
    subscription.deadline(extreme(publishers, deadline_of, largest));
  }
  if (subscription.liveliness_lease_duration() == kBestAvailableDuration) {
    subscription.liveliness_lease_duration(extreme(publishers, lease_of, largest));
  }
  return subscription;
}

QoS best_available_for_publisher(QoS publisher, std::span<const QoS> subscriptions) {
  if (publisher.reliability() == Reliability::BestAvailable) publisher.reliable();
  if (publisher.durability() == Durability::BestAvailable) publisher.transient_local();
  if (publisher.liveliness() == Liveliness::BestAvailable) {
    publisher.liveliness(any_liveliness_manual(subscriptions) ? Liveliness::ManualByTopic : Liveliness::Automatic);
  }
  const auto smallest = [](Duration a, Duration b) { return a < b; };
  if (publisher.deadline() == kBestAvailableDuration) {
    publisher.deadline(extreme(
        subscriptions, [](const QoS& q) { return q.deadline(); }, smallest));
  }
  if (publisher.liveliness_lease_duration() == kBestAvailableDuration) {
    publisher.liveliness_lease_duration(extreme(
        subscriptions, [](const QoS& q) { return q.liveliness_lease_duration(); }, smallest));
  }
  return publisher;
}

}  // namespace nacelle
