// SPDX-License-Identifier: Apache-2.0
#include "look/component/look_component.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <utility>

#include "look/component/page_files.hpp"
#include "nacelle/msgs/type_library.hpp"
#include "nacelle/node/container_facts.hpp"

namespace nacelle::look {
namespace {

ParameterDescriptor fixed(std::string description) {
  return {std::move(description), "", true, false, std::nullopt, std::nullopt};
}
ParameterDescriptor counted(std::string description, std::int64_t from, std::int64_t to) {
  return {std::move(description), "", true, false, IntegerRange{from, to, 0}, std::nullopt};
}

std::string machine() {
  std::array<char, 256> name{};
  return ::gethostname(name.data(), name.size() - 1) == 0 ? name.data() : "";
}

/// Where packages of ROS and those that came with this program have their folders.
std::vector<std::string> usual_asset_folders() {
  std::vector<std::string> folders;
  const char* const prefixes = std::getenv("AMENT_PREFIX_PATH");  // NOLINT(concurrency-mt-unsafe): nothing sets it
  std::string left = prefixes == nullptr ? "" : prefixes;
  while (!left.empty()) {
    const std::string prefix = left.substr(0, left.find(':'));
    if (!prefix.empty()) folders.push_back(prefix + "/share");
    left.erase(0, prefix.size() + 1);
  }
  // /usr/share of /usr/lib/aarch64-linux-gnu/nacelle
  for (auto folder = msgs::TypeLibrary::own_folder(); folder.has_relative_path(); folder = folder.parent_path()) {
    if (folder.filename() == "lib") folders.push_back((folder.parent_path() / "share").string());
  }
  return folders;
}

}  // namespace

LookComponent::LookComponent(const NodeOptions& options) : LifecycleNode("look", options) {
  options_.web.address = declare_parameter("address", "127.0.0.1",
                                           fixed("Where it listens; 0.0.0.0: on every interface of this machine."));
  options_.web.port = static_cast<std::uint16_t>(
      declare_parameter<std::int64_t>("port", 8080, counted("Where it listens; 0: on one that is free.", 0, 65535)));
  options_.web.most_viewers = static_cast<std::uint32_t>(
      declare_parameter<std::int64_t>("max_clients", 100, counted("Viewers at a time.", 1, 1000)));
  options_.bytes_per_second =
      125 * static_cast<std::uint64_t>(declare_parameter<std::int64_t>(
                "max_kbit_per_s", 16000,
                counted("Messages to each viewer; 0: as fast as its connection takes them.", 0, 10'000'000)));
  options_.access.allowed_hosts = declare_parameter<std::vector<std::string>>(
      "allowed_hosts", {}, fixed("Other names of this machine that may stand in a browser's address bar."));
  for (const char* const suffix : {"", ".local"}) options_.access.allowed_hosts.push_back(machine() + suffix);
  options_.access.allowed_origins = declare_parameter<std::vector<std::string>>(
      "allowed_origins", {"https://app.foxglove.dev"}, fixed("Other viewers' pages that may connect."));
  options_.asset_folders = declare_parameter<std::vector<std::string>>(
      "asset_folders", {},
      fixed("Folders in which packages have theirs, beside ROS's: for meshes of a robot's description."));
  for (const std::string& folder : usual_asset_folders()) options_.asset_folders.push_back(folder);
  declare_parameter(
      "link_file", "",
      ParameterDescriptor{"The file with the links. Empty: one in the user's folder under /run, which is named here "
                          "while the server is active.",
                          "", false, false, std::nullopt, std::nullopt});
  // A file that it names is replaced: that is for the robot's owner to say, not for a caller on the network.
  guard_ = add_on_set_parameters_callback([this](const std::vector<Parameter>& wishes) -> SetParametersResult {
    const bool names_file =
        std::any_of(wishes.begin(), wishes.end(), [](const Parameter& one) { return one.get_name() == "link_file"; });
    if (names_file && !names_file_) return {false, "link_file can be set in a launch file only"};
    return {true, ""};
  });
  const auto facts = shared_object<ContainerFacts>(kContainerFactsName, &make_container_facts);
  options_.container = facts->name;
  options_.name = facts->name.empty() ? machine() : facts->name.substr(1);
  options_.has_sim_time = get_parameter("use_sim_time").as_bool();
}

LookComponent::~LookComponent() { server_.reset(); }

std::string LookComponent::links(std::uint16_t port, const Access::Options& access) const {
  const std::string host =
      options_.web.address == "0.0.0.0" || options_.web.address.empty() ? machine() : options_.web.address;
  const auto link = [&](const std::string& token) { return fmt::format("http://{}:{}/#token={}", host, port, token); };
  const auto socket = [&](const std::string& token) { return fmt::format("ws://{}:{}/?token={}", host, port, token); };
  return nlohmann::json{{"operate", link(access.operate_token)},
                        {"view", link(access.view_token)},
                        {"foxglove", socket(access.operate_token)},
                        {"foxglove_view", socket(access.view_token)},
                        {"process", ::getpid()}}
             .dump() +
         "\n";
}

CallbackReturn LookComponent::on_activate(const State&) {
  LookServer::Options options = options_;
  for (std::string* const token : {&options.access.view_token, &options.access.operate_token}) {
    auto made = random_token();
    if (!made) return refuse(made.error());
    *token = std::move(*made);
  }
  options.web.files = page_files();
  const Access::Options access = options.access;
  auto server =
      LookServer::start(*this, {host(), get_fully_qualified_name()}, GenericServices{host()}, std::move(options));
  if (!server) return refuse(server.error());
  std::string path = get_parameter("link_file").as_string();
  if (path.empty()) path = LinkFile::path_for(get_fully_qualified_name());
  auto file = LinkFile::write(path, links((*server)->port(), access));
  if (!file) return refuse(file.error());
  names_file_ = true;
  set_parameter({"link_file", path});
  names_file_ = false;
  link_file_.emplace(std::move(*file));
  server_ = std::move(*server);
  get_logger().info("the robot can be seen at {}, port {}: `nacelle look` prints the link", options_.web.address,
                    server_->port());
  return CallbackReturn::SUCCESS;
}

CallbackReturn LookComponent::on_deactivate(const State&) {
  server_.reset();
  link_file_.reset();
  return CallbackReturn::SUCCESS;
}

CallbackReturn LookComponent::on_error(const State& state) { return on_deactivate(state); }

}  // namespace nacelle::look
