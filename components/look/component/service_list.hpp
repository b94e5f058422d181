// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "look/protocol/server_message.hpp"
#include "nacelle/base/mutex.hpp"
#include "nacelle/node/generic_services.hpp"

namespace nacelle::look {

/// The services of a container, each once. Threads: the server's, but for the ServiceListener's members.
class ServiceList final : private ServiceListener {
 public:
  struct Service {
    std::string name;
    const msgs::MessageType* request = nullptr;
    const msgs::MessageType* response = nullptr;
    std::set<std::uint64_t> servers;
  };
  /// `on_change`: called on any thread, with locks held.
  ServiceList(GenericServices services, std::function<void()> on_change);
  ~ServiceList() override;
  ServiceList(const ServiceList&) = delete;
  ServiceList& operator=(const ServiceList&) = delete;

  struct Changes {
    std::vector<ServiceInfo> made;
    std::vector<std::uint32_t> gone;
  };
  /// Follows what has changed since the last call.
  [[nodiscard]] Changes take_changes();
  [[nodiscard]] std::vector<ServiceInfo> services() const;
  void add_to(ConnectionGraph& graph) const;
  /// Null: there is none with this number.
  [[nodiscard]] const Service* find(std::uint32_t id) const;
  /// The nodes that have a service of this name: "/lidar" for "list_parameters", if there is "/lidar/list_parameters".
  [[nodiscard]] std::vector<std::string> nodes_with(const std::string& service) const;

 private:
  struct Change {
    std::uint64_t id = 0;
    std::optional<ServiceEndInfo> made;  // not set: it is gone
  };
  void on_made(const ServiceEndInfo& end) noexcept override;
  void on_gone(std::uint64_t id) noexcept override { note({id, std::nullopt}); }
  void note(Change change) noexcept;

  const std::function<void()> on_change_;
  std::map<std::uint64_t, ServiceEndInfo> servers_;
  std::map<std::uint32_t, Service> services_;
  std::set<std::uint32_t> announced_;
  std::uint32_t last_service_ = 0;

  Mutex mutex_;
  std::vector<Change> changes_ NACELLE_GUARDED_BY(mutex_);
  std::unique_ptr<ServiceWatchHandle> watch_;  // the last one: it ends the calls of the listener
};

}  // namespace nacelle::look
