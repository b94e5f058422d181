// SPDX-License-Identifier: Apache-2.0
#include "cli/whom.hpp"

#include <charconv>

#include "nacelle/base/network_names.hpp"
#include "remote/remote_requests.hpp"

namespace nacelle::cli {
namespace {

std::optional<int> domain_of(const std::string& text) {
  int number = -1;
  const auto read = std::from_chars(text.data(), text.data() + text.size(), number);
  if (read.ec != std::errc{} || read.ptr != text.data() + text.size() || number < 0 || number > kMostDomain)
    return std::nullopt;
  return number;
}

std::string wrong_domain(const std::string& text) {
  if (domain_of(text)) return {};
  return "'" + text + "' is not a domain: give a number from 0 to " + std::to_string(kMostDomain);
}

}  // namespace

struct Whom::Remote {
  bool is_wanted = false;
  std::string domain, network;
  double spin_time_s = 1.0;
  std::unique_ptr<remote::RemoteRequests> requests;  // once it was asked
};

Whom::Whom() : remote_(std::make_shared<Remote>()) {}

void Whom::add_options(Command& command) {
  command.flag("--remote", remote_->is_wanted, "query the nodes of ROS 2's network; needs no local container");
  command.option("--domain", remote_->domain, "domain of the network (default: ROS_DOMAIN_ID)")
      .value("N")
      .checked(wrong_domain);
  command
      .option("--network", remote_->network,
              "local: only this machine, for robots that are not exported (default: export)")
      .one_of({"local", "export"});
  command.option("--spin-time", remote_->spin_time_s, "how long to wait for discovery")
      .value("SECONDS")
      .within(0.0, 60.0)
      .with_default();
}

bool Whom::is_remote() const { return remote_->is_wanted; }

std::string Whom::command(const std::string& words) const {
  return "`nacelle " + words + (is_remote() ? " --remote`" : "`");
}

std::optional<Problem> Whom::misuse() const {
  if (remote_->is_wanted || (remote_->domain.empty() && remote_->network.empty())) return std::nullopt;
  return Problem{remote_->domain.empty() ? "--network" : "--domain", "has an effect only with --remote",
                 "give --remote too"};
}

Result<control::Client, Problem> Whom::connect_remotely(std::vector<std::filesystem::path> message_folders) const {
  if (!remote_->requests) {
    remote::RemoteOptions options;
    options.domain = domain_of(remote_->domain);
    if (remote_->network == "local") options.mode = launch::NetworkMode::Local;
    if (remote_->network == "export") options.mode = launch::NetworkMode::Export;
    options.spin_time = from_seconds(remote_->spin_time_s);
    options.message_folders = std::move(message_folders);
    auto requests = remote::RemoteRequests::open(options);
    if (!requests) return err(requests.error());
    remote_->requests = std::move(requests).value();
  }
  return remote_->requests->connect();
}

}  // namespace nacelle::cli
