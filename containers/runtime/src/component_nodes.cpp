// SPDX-License-Identifier: Apache-2.0
// The nodes of a component: the component itself, and nodes that it makes beside it (docs/adr/0035).
#include <fmt/format.h>

#include <algorithm>

#include "container_impl.hpp"
#include "host.hpp"
#include "nacelle/base/name_fault.hpp"

namespace nacelle::runtime {

std::vector<std::shared_ptr<NodeRuntime>> Record::runtimes() const {
  std::vector<std::shared_ptr<NodeRuntime>> all;
  if (runtime) all.push_back(runtime);
  auto beside = others.lock();
  for (const auto& other : *beside) all.push_back(other->runtime);
  return all;
}

bool Record::is_actuator() const {
  bool any = false;
  for_each_node([&](const NodeRuntime& each) { any = any || each.is_actuator(); });
  return any;
}

/// The host of the component itself.
class Container::Impl::OwnHost final : public Host {
 public:
  OwnHost(Record& record, SimClock* sim_clock) : Host(record.runtime, sim_clock), record_(record) {}
  void set_parameters(ParameterStore& parameters) override { record_.parameters = &parameters; }

 private:
  Record& record_;
};

/// The host of a node beside it, which ends with the node.
class Container::Impl::OtherHost final : public Host {
 public:
  OtherHost(Impl& container, Record& record, std::shared_ptr<NodeRecord> node, SimClock* sim_clock)
      : Host(node->runtime, sim_clock), container_(container), record_(record), node_(std::move(node)) {}
  ~OtherHost() override { container_.end_other(record_, node_); }
  void set_parameters(ParameterStore& parameters) override {
    {
      const LockGuard lock(node_->offering);
      node_->parameters = &parameters;
    }
    container_.begin_other(record_, node_);
  }

 private:
  Impl& container_;
  Record& record_;
  const std::shared_ptr<NodeRecord> node_;
};

/// The options of each node of a component carry it, so that a node which the component makes later belongs to it, too.
class Container::Impl::ComponentContext final : public Context {
 public:
  ComponentContext(Impl& container, Record& record, Executor& executor, bool uses_sim_time)
      : container_(container), record_(record), executor_(executor), uses_sim_time_(uses_sim_time) {}
  [[nodiscard]] std::unique_ptr<NodeHost> create_host(const NodeIdentity& identity) override;

 private:
  void reserve(const std::string& name) NACELLE_REQUIRES(container_.mutex);

  Impl& container_;
  Record& record_;
  Executor& executor_;
  const bool uses_sim_time_;
};

std::unique_ptr<Context> Container::Impl::context_for(Record& record, Executor& executor, bool uses_sim_time) {
  return std::make_unique<ComponentContext>(*this, record, executor, uses_sim_time);
}

void Container::Impl::ComponentContext::reserve(const std::string& name) {
  constexpr const char* kAnotherName = "give this one another name";
  for (const auto& [id, other] : container_.foreign) {
    if (other->info().node != name) continue;
    throw NameTaken({"", fmt::format("a node {} runs in another process already (component {})", name, id),
                     kAnotherName, NameFault::Taken, name});
  }
  if (const auto [taken, is_new] = container_.names.emplace(name, &record_); !is_new) {
    const std::uint64_t id = taken->second->id;
    throw NameTaken({"",
                     id != 0 ? fmt::format("a node {} is loaded already (component {})", name, id)
                             : fmt::format("a node {} is being loaded just now", name),
                     kAnotherName, NameFault::Taken, name});
  }
}

std::unique_ptr<NodeHost> Container::Impl::ComponentContext::create_host(const NodeIdentity& identity) {
  const std::string name = identity.fully_qualified();
  using Text = const std::string&;
  auto& impl = container_;
  auto& record = record_;
  auto runtime = std::make_shared<NodeRuntime>(
      impl.commons, identity, executor_,
      [&impl, &record](Text code, Text text, Text callback) { impl.note_fault(record, code, text, callback); });
  runtime->set_open_faults(
      {[&impl, &record](Text code, Text text, Text callback) { impl.note_open_fault(record, code, text, callback); },
       [&impl, &record](Text code) { impl.note_closed_fault(record, code); }});
  SimClock* const sim_clock = uses_sim_time_ ? &impl.commons.simulated() : nullptr;
  const LockGuard lock(container_.mutex);
  if (record.given_up) throw std::runtime_error("its load has timed out");
  reserve(name);
  runtime->set_image(record.library->image());
  {
    auto known = record.node_names.lock();
    if (std::ranges::find(*known, name) == known->end()) known->push_back(name);
  }
  set_log_origin(name, record.runtime ? record.runtime->identity().fully_qualified() : name);
  if (impl.node_services) impl.node_services->keep_log(name);
  if (!record.runtime) {
    record.runtime = std::move(runtime);
    return std::make_unique<OwnHost>(record, sim_clock);
  }
  auto other = std::make_shared<NodeRecord>();
  other->id = container_.next_other_id++;
  other->runtime = std::move(runtime);
  record.others.lock()->push_back(other);
  return std::make_unique<OtherHost>(impl, record, std::move(other), sim_clock);
}

void Container::Impl::offer(NodeRecord& node, bool has_lifecycle) const {
  const LockGuard lock(node.offering);
  if (node.offer != NodeRecord::Offer::None || node.parameters == nullptr) return;
  node.offer = NodeRecord::Offer::Standing;
  if (node_services) node_services->begin(node, has_lifecycle);
  node.runtime->open();
}

bool Container::Impl::refuse_offer(NodeRecord& node) {
  const LockGuard lock(node.offering);
  return std::exchange(node.offer, NodeRecord::Offer::Over) != NodeRecord::Offer::Over;
}

void Container::Impl::withdraw(NodeRecord& node, bool returned) const {
  if (refuse_offer(node) && node_services) node_services->end(node, returned);
}

// One that the constructor makes waits for the end of the load: no callback runs beside a constructor.
void Container::Impl::begin_other(Record& record, const std::shared_ptr<NodeRecord>& node) {
  {
    const LockGuard lock(mutex);
    if (!records.contains(record.id)) return;
  }
  // After the callback that makes it: its constructor has ended then.
  record.runtime->post("begin of another node", patience, [this, made = std::weak_ptr(node)] {
    if (const auto other = made.lock()) offer(*other, false);
  });
  note_change();
}

void Container::Impl::end_other(Record& record, const std::shared_ptr<NodeRecord>& node) {
  const std::string name = node->runtime->identity().fully_qualified();
  std::erase(*record.others.lock(), node);
  const bool was_there = refuse_offer(*node);  // first: an offer that is on its way would open what is closed here
  if (!node->runtime->close(deadline().now()))
    log.error("{}: a callback of its node {} has not returned, and the node is destroyed", record.plugin, name);
  if (was_there && node_services) node_services->end(*node, true);
  {
    const LockGuard lock(mutex);
    if (const auto found = names.find(name); found != names.end() && found->second == &record) {
      names.erase(found);
      forget_log_origin(name);
    }
  }
  note_change();
}

}  // namespace nacelle::runtime
