// SPDX-License-Identifier: Apache-2.0
#include "look/component/service_list.hpp"

#include <algorithm>

#include "nacelle/msgs/message_type.hpp"

namespace nacelle::look {
namespace {

ServiceInfo info_of(std::uint32_t id, const ServiceList::Service& service) {
  constexpr std::string_view kSuffix = "_Request";
  std::string type = service.request->name;
  if (type.ends_with(kSuffix)) type.resize(type.size() - kSuffix.size());
  return {id, service.name, std::move(type), service.request->definition, service.response->definition};
}

}  // namespace

ServiceList::ServiceList(GenericServices services, std::function<void()> on_change) : on_change_(std::move(on_change)) {
  watch_ = services.watch(*this);
}

ServiceList::~ServiceList() { watch_.reset(); }

void ServiceList::on_made(const ServiceEndInfo& end) noexcept {
  if (end.is_server) note({end.id, end});
}

void ServiceList::note(Change change) noexcept {
  bool is_first = false;
  {
    const LockGuard lock{mutex_};
    is_first = changes_.empty();
    changes_.push_back(std::move(change));
  }
  if (is_first) on_change_();
}

ServiceList::Changes ServiceList::take_changes() {
  std::vector<Change> now;
  {
    const LockGuard lock{mutex_};
    std::swap(now, changes_);
  }
  Changes changes;
  for (Change& change : now) {
    if (change.made) {
      auto same = std::find_if(services_.begin(), services_.end(), [&](const auto& entry) {
        return entry.second.name == change.made->name && entry.second.request == change.made->request;
      });
      if (same == services_.end()) {
        same =
            services_
                .emplace(++last_service_, Service{change.made->name, change.made->request, change.made->response, {}})
                .first;
      }
      same->second.servers.insert(change.id);
      servers_.insert_or_assign(change.id, std::move(*change.made));
      continue;
    }
    if (servers_.erase(change.id) == 0) continue;  // a client
    for (auto& [id, service] : services_) service.servers.erase(change.id);
  }
  // One that came and went in one go was never announced.
  std::erase_if(services_, [&](const auto& entry) {
    if (!entry.second.servers.empty()) return false;
    if (announced_.erase(entry.first) != 0) changes.gone.push_back(entry.first);
    return true;
  });
  for (const auto& [id, service] : services_) {
    if (announced_.insert(id).second) changes.made.push_back(info_of(id, service));
  }
  return changes;
}

std::vector<ServiceInfo> ServiceList::services() const {
  std::vector<ServiceInfo> all;
  for (const auto& [id, service] : services_) all.push_back(info_of(id, service));
  return all;
}

void ServiceList::add_to(ConnectionGraph& graph) const {
  for (const auto& [id, server] : servers_) graph.services[server.name].insert(server.node);
}

const ServiceList::Service* ServiceList::find(std::uint32_t id) const {
  const auto found = services_.find(id);
  return found == services_.end() ? nullptr : &found->second;
}

std::vector<std::string> ServiceList::nodes_with(const std::string& service) const {
  std::vector<std::string> nodes;
  for (const auto& [id, one] : services_) {
    if (one.name.ends_with("/" + service)) nodes.push_back(one.name.substr(0, one.name.size() - service.size() - 1));
  }
  return nodes;
}

}  // namespace nacelle::look
