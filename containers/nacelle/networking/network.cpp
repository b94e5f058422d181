// SPDX-License-Identifier: Apache-2.0
#include "networking/network.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>

#include "nacelle/base/problem_json.hpp"
#include "nacelle/transport_dds/mirror.hpp"
#include "networking/network_wish.hpp"
#include "networking/refused_services.hpp"
#include "transport_dds/wire/cyclone_config.hpp"
#include "transport_dds/wire/network_fault.hpp"

namespace nacelle::networking {
namespace {

using nlohmann::json;
using transport_dds::NetworkMode;

// DHCP and IPv6 give addresses one after the other; discovery is to come within 3 s.
constexpr Duration kRest = 500ms;

// A join fails if the machine has no address yet, or while another process holds a port; it takes milliseconds to fail.
constexpr Duration kFirstRetry = 1s, kLongestRetry = 60s;

// What programs of this machine call it by, carrier or not.
std::vector<NetworkLink> with_an_ipv4_address(std::vector<NetworkLink> links) {
  for (NetworkLink& link : links) {
    link.up = link.on;
    std::erase_if(link.addresses, [](const std::string& address) { return address.find(':') != std::string::npos; });
  }
  std::erase_if(links, [](const NetworkLink& link) { return !link.on || link.addresses.empty(); });
  return links;
}

}  // namespace

#ifdef NACELLE_HAS_DDS
namespace {

/// Options of the network itself. A caller with a graph adds to them.
MirrorOptions options_of(const transport_dds::NetworkSettings& settings) {
  MirrorOptions options;
  options.domain_id = static_cast<std::uint32_t>(settings.domain);
  options.config = transport_dds::cyclone_config(settings);
  if (!settings.security.enclave.empty()) options.enclave = settings.security.enclave;
  if (settings.secured) options.security = settings.secured->files;
  options.stays_on_this_machine = settings.mode == NetworkMode::Local;
  return options;
}

/// `begin(options)`, and again where what Cyclone refuses can be had in another way; `settings` are then those in force.
template <typename Begin>
auto begin_with(transport_dds::NetworkSettings& settings, MirrorOptions& options, const Begin& begin) {
  auto begun = begin(options);
  const auto failed_by = [&](transport_dds::NetworkFault fault) { return !begun && begun.error().code == fault; };
  using transport_dds::NetworkFault, transport_dds::Reach;
  // CYCLONEDDS_URI names interfaces: it has the last word.
  if (settings.discovery == Reach::ThisMachine && failed_by(NetworkFault::InterfaceTwice)) {
    settings.interfaces.clear();
    options.config = transport_dds::cyclone_config(settings);
    begun = begin(options);
  }
  // Multicast needs no numbered port. Only peers that ask by unicast do not find this process then (range LOCALHOST, static peers).
  if (settings.discovery != Reach::Unicast && failed_by(NetworkFault::NoParticipantIndex)) {
    options.config += ",<Discovery><ParticipantIndex>none</ParticipantIndex></Discovery>";
    begun = begin(options);
  }
  return begun;
}

}  // namespace

struct Network::Joined {
  std::unique_ptr<DdsMirror> mirror;
};
#else
struct Network::Joined {};
#endif

Network::Network(launch::NetworkPlan plan, transport_dds::Environment environment, Graph& graph, ServiceGraph& services,
                 const Clock& clock, Say say, std::shared_ptr<ClockSkews> clock_skews)
    : plan_(plan),
      written_(std::move(plan)),
      environment_(std::move(environment)),
      graph_(graph),
      services_(services),
      clock_(clock),
      say_(std::move(say)),
      clock_skews_(std::move(clock_skews)) {}

Network::~Network() = default;

Result<void, Problem> Network::start() {
  const bool wants_it = plan_.mode.value_or(launch::NetworkMode::Off) != launch::NetworkMode::Off;
  if (wants_it && !network_is_built_in()) {
    return err(network_is_not_built_in(
        plan_.mode_by_argument ? Place{std::string("network:=") + launch::to_text(*plan_.mode)} : plan_.where));
  }
  static_cast<void>(join());  // why not: the bring-up's last line
  if (!is_asked_for_) return {};
  for (const auto& remark : settings_.remarks) say_("nacelle: " + remark.text());
  return {};
}

Result<void, Problem> Network::join() {
  why_not_.reset();
  is_asked_for_ = true;
  // Before the settings, which name addresses: what changes from here on is a change.
  std::vector<NetworkLink> links = network_links();
  auto settings = network_in_force(plan_, environment_, clock_);
  if (!settings) {
    settings_ = {};
    settings_.mode = NetworkMode::Off;
    why_not_ = settings.error();
    plan_retry();
    return err(*why_not_);
  }
  settings_ = std::move(*settings);
  if (settings_.mode == NetworkMode::Off) {
    watch_links();
    return {};
  }
#ifdef NACELLE_HAS_DDS
  joined_with_ = of_interest(std::move(links));
  MirrorOptions options = options_of(settings_);
  if (settings_.mode == NetworkMode::Export) options.exports = settings_.exports;
  options.refused = refused_services(node_, settings_);
  options.on_problem = [say = say_](const Problem& problem) { say("nacelle: network: " + problem.text()); };
  options.clock_skews = clock_skews_;
  if (told_) options.on_problem = told_;
  auto mirror = begin_with(settings_, options, [this](const MirrorOptions& with) {
    return DdsMirror::start(graph_, clock_, with, &services_);
  });
  if (mirror) {
    joined_ = std::make_unique<Joined>(Joined{std::move(*mirror)});
    *mirror_.lock() = joined_->mirror.get();
  } else {
    why_not_ = mirror.error();
  }
#else
  is_asked_for_ = plan_.mode.has_value() || !settings_.because_of.empty();
  why_not_ = network_is_not_built_in(settings_.because_of);
#endif
  watch_links();
  plan_retry();
  return why_not_ ? Result<void, Problem>{err(*why_not_)} : Result<void, Problem>{};
}

void Network::leave() {
  *mirror_.lock() = nullptr;
  joined_.reset();
}

Result<void, Problem> Network::show(launch::NetworkMode mode, const std::string& because_of) {
  if (mode != launch::NetworkMode::Off && !network_is_built_in()) return err(network_is_not_built_in(because_of));
  const launch::NetworkPlan before = plan_;
  leave();
  plan_.mode = mode;
  plan_.mode_by_argument = false;
  auto joined = join();
  if (joined) {
    settings_.because_of = because_of;
    return joined;
  }
  const Problem problem = joined.error();
  plan_ = before;
  if (auto back = join(); !back) say_("nacelle: " + network_off_line(back.error()));
  return err(problem);
}

void Network::look(const std::function<void(const transport_dds::RemoteGraph&)>& at) const {
#ifdef NACELLE_HAS_DDS
  auto mirror = mirror_.lock();
  if (*mirror != nullptr) (*mirror)->look(at);
#else
  static_cast<void>(at);
#endif
}

std::uint64_t Network::writer_count() const {
#ifdef NACELLE_HAS_DDS
  if (joined_) return joined_->mirror->stats().writers;
#endif
  return 0;
}

launch::NetworkMode Network::unexported() const {
  const auto settings = network_in_force(written_, environment_, clock_);
  return settings && settings.value().mode == NetworkMode::Off ? launch::NetworkMode::Off : launch::NetworkMode::Local;
}

std::string Network::line() const {
  if (why_not_) return is_asked_for_ ? network_off_line(*why_not_) : std::string{};
  return transport_dds::network_line(settings_);
}

json Network::state() const {
  json state = json_of(settings_);
  state["line"] = line();
  state["running"] = joined_ != nullptr;
  state["problem"] = why_not_ ? json(*why_not_) : json(nullptr);
  state["figures"] = nullptr;
  state["namesakes"] = json::array();  // nodes elsewhere that have the name of one of this robot's
  state["clock_skews"] = json::array();
#ifdef NACELLE_HAS_DDS
  if (joined_) {
    for (const Namesake& one : joined_->mirror->namesakes())
      state["namesakes"].push_back({{"node", one.node},
                                    {"host", one.host},
                                    {"process", one.process},
                                    {"pid", one.pid},
                                    {"participant", one.participant}});
    for (const auto& skew : joined_->mirror->clock_skews())
      state["clock_skews"].push_back({{"host", skew.host()},
                                      {"ahead_s", to_seconds(skew.ahead())},
                                      {"certain", skew.is_certain()},
                                      {"text", skew.text()}});
    const MirrorStats figures = joined_->mirror->stats();
    state["figures"] = {{"writers", figures.writers},
                        {"readers", figures.readers},
                        {"hidden", figures.hidden},
                        {"others", figures.stand_ins},
                        {"sent", figures.encoded},
                        {"bytes_sent", figures.bytes_encoded},
                        {"overtaken", figures.overtaken},
                        {"held_back", figures.held_back},
                        {"refused", figures.refused},
                        {"received", figures.received},
                        {"broken", figures.broken + figures.stray},
                        {"problems", figures.problems},
                        {"clock_questions", figures.clock_questions},
                        {"clock_answers", figures.clock_answers}};
  }
#endif
  return state;
}

Result<std::vector<Problem>, Problem> try_network(transport_dds::NetworkSettings settings) {
#ifdef NACELLE_HAS_DDS
  if (settings.mode != NetworkMode::Off) {
    MirrorOptions options = options_of(settings);
    return begin_with(settings, options, DdsMirror::try_to_join);
  }
#else
  static_cast<void>(settings);
#endif
  return std::vector<Problem>{};
}

// --- addresses that change -------------------------------------------------------------------------------------------

void Network::watch_links() {
  const bool wanted = settings_.mode != NetworkMode::Off || (why_not_ && network_is_built_in());
  if (!wanted) {
    watch_.reset();
    due_.reset();
  } else if (!watch_) {
    watch_ = std::make_unique<LinkWatch>();
    // What has changed between the question and the watch.
    if (of_interest(network_links()) != joined_with_) due_ = clock_.now() + kRest;
  }
}

std::vector<NetworkLink> Network::of_interest(std::vector<NetworkLink> links) const {
  if (settings_.mode == NetworkMode::Local) return with_an_ipv4_address(std::move(links));
  const auto& names = settings_.interfaces;
  std::erase_if(links, [&](const NetworkLink& link) {
    if (link.is_loopback) return settings_.mode == NetworkMode::Export;
    const auto is_named = [&](const std::string& name) {
      return name == link.name || std::find(link.addresses.begin(), link.addresses.end(), name) != link.addresses.end();
    };
    return !link.up || link.addresses.empty() || (!names.empty() && std::none_of(names.begin(), names.end(), is_named));
  });
  return links;
}

void Network::serve(bool told) {
  if (told && watch_) {
    watch_->drain();
    due_ = of_interest(network_links()) == joined_with_ ? std::nullopt : std::optional(clock_.now() + kRest);
  }
  if (retry_ && clock_.now() >= *retry_) return retry();
  if (!due_ || clock_.now() < *due_) return;
  due_.reset();
  if (of_interest(network_links()) == joined_with_) return;
  leave();
  const auto because_of = settings_.because_of;
  if (auto joined = join(); !joined) {
    say_("nacelle: " + network_off_line(joined.error()));
  } else {
    settings_.because_of = because_of;
    say_("nacelle: network: this machine's addresses have changed: rejoined");
  }
}

void Network::plan_retry() {
  retry_.reset();
  if (!why_not_ || !network_is_built_in()) {
    retry_pause_ = Duration::zero();
    return;
  }
  retry_pause_ = retry_pause_ == Duration::zero() ? kFirstRetry : std::min(2 * retry_pause_, kLongestRetry);
  retry_ = clock_.now() + retry_pause_;
}

void Network::retry() {
  const std::string before = why_not_ ? why_not_->text() : std::string{};
  const auto because_of = settings_.because_of;
  if (auto joined = join(); joined) {
    if (!because_of.empty()) settings_.because_of = because_of;
    say_("nacelle: " + line());
  } else if (joined.error().text() != before) {
    say_("nacelle: " + network_off_line(joined.error()));
  }
}

// A small computer without a clock battery starts years in the past, and gets the time later.
void Network::note_clock_jump() {
  if (joined_ || !why_not_ || !network_is_built_in()) return;
  if (auto joined = join(); joined && joined_) say_("nacelle: " + line());
}

}  // namespace nacelle::networking
