// SPDX-License-Identifier: Apache-2.0
#include "transport_dds/port/participant.hpp"

#include <algorithm>
#include <string_view>

#include "transport_dds/port/core.hpp"
#include "transport_dds/port/cyclone_log.hpp"
#include "transport_dds/port/cyclone_qos.hpp"
#include "transport_dds/port/this_machine.hpp"
#include "transport_dds/wire/network_fault.hpp"

namespace nacelle::transport_dds {
namespace {

// A writer waits for acknowledgements when more than WhcHigh is outstanding, for ever with ROS 2's QoS. A KEEP_LAST
// history bounds that by itself, and KEEP_ALL is bounded by EndpointOptions::most_out. A message of megabytes comes in
// one burst: packets that do not fit into the socket's buffer are sent again, much later. The kernel gives as much as
// net.core.rmem_max allows. A writer that ends waits a moment for readers to acknowledge, each for itself: a peer that
// has fallen silent must not hold up the end of all.
constexpr const char* kBefore =
    "<Internal><Watermarks><WhcHigh>1 GB</WhcHigh></Watermarks><SocketReceiveBufferSize max=\"8 MiB\"/>"
    "<WriterLingerDuration>100 ms</WriterLingerDuration></Internal>";
// Not available with Debian's 0.10: of several receiving threads all but one wait in recv(), and are woken by a packet
// to this machine's own address: once that address is gone they never end, and the participant's end never returns.
constexpr const char* kAfter =
    "<SharedMemory><Enable>false</Enable></SharedMemory>"
    "<Internal><MultipleReceiveThreads>false</MultipleReceiveThreads></Internal>";
// The monitor port would give every caller all information.
constexpr const char* kAtHome = "<Internal><MonitorPort>-1</MonitorPort></Internal>";
// Each attempt fails only if another participant announces itself within about a millisecond.
constexpr int kMostBeginnings = 5;

// As rmw_cyclonedds does. The plugins' names are without folder and ending: Debian's Cyclone knows where they lie.
void set_security(dds_qos_t* qos, const SecurityFiles& files) {
  const auto set = [qos](const char* name, const std::string& value) { dds_qset_prop(qos, name, value.c_str()); };
  set("dds.sec.auth.identity_ca", "file:" + files.identity_ca);
  set("dds.sec.auth.identity_certificate", "file:" + files.certificate);
  set("dds.sec.auth.private_key", "file:" + files.private_key);
  set("dds.sec.access.permissions_ca", "file:" + files.permissions_ca);
  set("dds.sec.access.governance", "file:" + files.governance);
  set("dds.sec.access.permissions", "file:" + files.permissions);
  set("dds.sec.auth.library.path", "dds_security_auth");
  set("dds.sec.auth.library.init", "init_authentication");
  set("dds.sec.auth.library.finalize", "finalize_authentication");
  set("dds.sec.crypto.library.path", "dds_security_crypto");
  set("dds.sec.crypto.library.init", "init_crypto");
  set("dds.sec.crypto.library.finalize", "finalize_crypto");
  set("dds.sec.access.library.path", "dds_security_ac");
  set("dds.sec.access.library.init", "init_access_control");
  set("dds.sec.access.library.finalize", "finalize_access_control");
}

/// What Cyclone's words mean: the one place where they are read.
ProblemCode code_of(const std::string& said, dds_return_t error) {
  const auto has = [&](const char* words) { return said.find(words) != std::string::npos; };
  if (error == DDS_RETCODE_PRECONDITION_NOT_MET) return NetworkFault::DomainInUse;
  if (has("participant index")) return NetworkFault::NoParticipantIndex;
  if (has("selected twice")) return NetworkFault::InterfaceTwice;
  if (has("nterface")) return NetworkFault::NoSuchInterface;
  if (has("config") || has("element")) return NetworkFault::BadConfiguration;
  return {};
}

std::string way_out_of(const ProblemCode& code, std::uint32_t domain) {
  if (code == NetworkFault::DomainInUse)
    return "this process has joined domain " + std::to_string(domain) +
           " already: one participant serves all its nodes";
  if (code == NetworkFault::NoParticipantIndex)
    return "too many processes of this domain run on this host: end some, or raise Discovery/MaxAutoParticipantIndex";
  if (code == NetworkFault::NoSuchInterface || code == NetworkFault::InterfaceTwice)
    return "see `ip address` for the interfaces that are there";
  if (code == NetworkFault::BadConfiguration)
    return "correct the configuration (CYCLONEDDS_URI, or `network:` in the launch file)";
  return {};
}

Problem problem_of(const ParticipantOptions& options, const CapturedLog& log, dds_return_t error) {
  const std::string what = log.text().empty() ? error_name(error) : log.text();
  const ProblemCode code = code_of(what, error);
  return {"DDS domain " + std::to_string(options.domain_id), what, way_out_of(code, options.domain_id), code};
}

Result<Entity, Problem> make_domain(const ParticipantOptions& options, const std::string& config,
                                    const CapturedLog& log) {
  for (int i = 0; i < kMostBeginnings; ++i) {
    Entity domain{dds_create_domain(options.domain_id, config.c_str())};
    if (!domain) return err(problem_of(options, log, domain.get()));
    if (!options.stays_on_this_machine) return domain;
    const auto home = keep_domain_to_this_machine(domain.get(), options.domain_id);
    if (!home) return err(home.error());
    if (home.value() == Home::Alone) return domain;
  }
  return err(Problem{"DDS domain " + std::to_string(options.domain_id),
                     "it could receive messages of other machines before it is restricted to this one",
                     "take another domain"});
}

/// Returns the peers that Cyclone cannot contact, from its messages at the creation of the domain ("add_peer_addresses: laptop:
/// unknown address"). It asks the resolver only then.
std::vector<Problem> peers_not_asked(std::string_view said) {
  constexpr std::string_view kBegin = "add_peer_addresses: ";
  std::vector<Problem> found;
  while (!said.empty()) {
    const std::size_t end = std::min(said.find("; "), said.size());
    const std::string_view line = said.substr(0, end);
    said.remove_prefix(std::min(end + 2, said.size()));
    const std::size_t why = line.rfind(": ");
    if (!line.starts_with(kBegin) || why < kBegin.size()) continue;
    const std::string peer{line.substr(kBegin.size(), why - kBegin.size())}, what{line.substr(why + 2)};
    found.push_back({"peer " + peer,
                     (what == "unknown address" ? "this name has no address" : what) + ": it is not used as a peer",
                     "correct it, or give an address; names are looked up when the network is joined"});
  }
  return found;
}

}  // namespace

Result<std::unique_ptr<Participant>, Problem> Participant::create(const ParticipantOptions& options) {
  redirect_cyclone_log();
  auto core = std::make_shared<ParticipantCore>();
  core->limits = {options.most_message_bytes, options.most_bytes_of_type};
  std::string config = kBefore;
  if (!options.config.empty()) config += "," + options.config;
  config += std::string(",") + kAfter;
  if (options.stays_on_this_machine) config += std::string(",") + kAtHome;
  const CapturedLog log;
  auto domain = make_domain(options, config, log);
  if (!domain) return err(domain.error());
  core->domain = std::move(domain).value();
  core->remarks = peers_not_asked(log.text());
  if (options.is_trial) dds_domain_set_deafmute(core->domain.get(), true, true, DDS_INFINITY);
  const CycloneQos qos{dds_create_qos()};
  dds_qset_userdata(qos.get(), options.user_data.data(), options.user_data.size());
  if (options.security) set_security(qos.get(), *options.security);
  core->participant = Entity{dds_create_participant(options.domain_id, qos.get(), nullptr)};
  if (!core->participant) return err(problem_of(options, log, core->participant.get()));
  core->gid = gid_of(core->participant.get());
  return std::unique_ptr<Participant>(new Participant(std::move(core)));
}

Participant::Participant(std::shared_ptr<ParticipantCore> core) : core_(std::move(core)) {}
Participant::~Participant() = default;
Gid Participant::gid() const { return core_->gid; }
std::vector<Problem> Participant::remarks() const { return core_->remarks; }
void Participant::set_mute(bool mute) { dds_domain_set_deafmute(core_->participant.get(), false, mute, DDS_INFINITY); }

Problem problem_of(const std::string& what, const EndpointOptions& options, const CapturedLog& log,
                   dds_return_t error) {
  if (error == DDS_RETCODE_NOT_ALLOWED_BY_SECURITY) {
    return {what + " " + options.topic, "the permissions of the own enclave forbid it",
            "allow it with `nacelle security create-permission`, see docs/security.md"};
  }
  const std::string type = what == "DDS topic" ? " (" + options.type + ")" : "";
  return {what + " " + options.topic + type, log.text().empty() ? error_name(error) : log.text(), ""};
}

Result<BlobTopic, Problem> make_topic(std::shared_ptr<ParticipantCore> core, const EndpointOptions& options) {
  ddsi_sertype* type = make_blob_type(options.type, options.structure, core->limits);
  const CapturedLog log;
  BlobTopic out;
  out.topic = Entity{
      dds_create_topic_sertype(core->participant.get(), options.topic.c_str(), &type, nullptr, nullptr, nullptr)};
  if (!out.topic) {
    ddsi_sertype_unref(type);
    return err(problem_of("DDS topic", options, log, out.topic.get()));
  }
  out.core = std::move(core);
  out.type = static_cast<const BlobType*>(type);
  return out;
}

std::vector<MatchedPeer> matched_peers(dds_entity_t endpoint, bool are_writers) {
  const auto list = are_writers ? dds_get_matched_publications : dds_get_matched_subscriptions;
  const auto ask = are_writers ? dds_get_matched_publication_data : dds_get_matched_subscription_data;
  std::vector<dds_instance_handle_t> handles;
  // Their number may grow between the two calls; then those that are new come with the next status.
  const dds_return_t count = list(endpoint, nullptr, 0);
  if (count <= 0) return {};
  handles.resize(static_cast<std::size_t>(count));
  const dds_return_t got = list(endpoint, handles.data(), handles.size());
  handles.resize(static_cast<std::size_t>(std::clamp(got, 0, count)));
  std::vector<MatchedPeer> out;
  for (const dds_instance_handle_t handle : handles) {
    dds_builtintopic_endpoint_t* const found = ask(endpoint, handle);
    if (found == nullptr) continue;  // gone meanwhile
    out.push_back({to_endpoint(*found, are_writers), handle});
    dds_builtintopic_free_endpoint(found);
  }
  return out;
}

}  // namespace nacelle::transport_dds
