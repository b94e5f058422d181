// SPDX-License-Identifier: Apache-2.0
#include "isolation/isolated_process.hpp"

#include <fcntl.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "isolation/carriers.hpp"
#include "isolation/isolated_words.hpp"
#include "loading/load_request.hpp"
#include "loading/plan_json.hpp"
#include "nacelle/base/guarded.hpp"
#include "nacelle/base/json_text.hpp"
#include "nacelle/base/log.hpp"
#include "nacelle/base/problem_json.hpp"
#include "nacelle/msgs/type_library.hpp"
#include "nacelle/runtime/crash_record.hpp"
#include "nacelle/transport_local/link.hpp"

namespace nacelle::isolation {
namespace {

using nlohmann::json;

constexpr Duration kLeaveLimit = 3s;  // as the container's own, for a component that hangs on its way down

class IsolatedProcess {
 public:
  IsolatedProcess(int socket, const std::string& name, const std::string& carrier, const loading::ProgramPlaces& places,
                  const Clock& clock)
      : log_("isolated"), types_(places.message_folders), event_(::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)) {
    runtime::ContainerOptions options;
    options.name = name;
    options.component_path = places.component_folders;
    options.node_interfaces = runtime::NodeInterfaces::Isolated;
    container_ = std::make_unique<runtime::Container>(std::move(options), clock);
    if (!carrier.empty()) {
      auto started = start_carrier(carrier);
      if (!started) log_.warn("streams go over a socket: {}", started.error().text());
      if (started) carrier_ = std::move(started).value();
    }
    LinkOptions link;
    link.peer = "the container";
    link.carrier = carrier_.get();
    link.services = &container_->service_graph();
    link.private_node = container_->node();
    link.find_type = [this](const std::string& type_name) -> const msgs::MessageType* {
      auto type = types_.message(type_name);
      return type ? type.value() : nullptr;
    };
    link.on_note = [this](std::string note) {
      if (obeys_at_once(note)) return;
      notes_.lock()->push_back(std::move(note));
      wake();
    };
    link.on_end = [this, socket](const Problem&) {
      // Ended from here, not by the container: it was closed.
      if (::fcntl(socket, F_GETFD) < 0) end_without_descriptors();
      over_ = true;
      wake();
    };
    link_ = std::make_unique<Link>(container_->graph(), clock, socket, std::move(link));
    container_->on_fault([this](const runtime::ComponentInfo& info) {
      const auto faults = container_->faults();
      link_->send_note(
          json{{"fault", info_to_json(info)}, {"callback", faults.empty() ? "" : faults.back().callback}}.dump());
    });
    container_->on_open_fault([this](const runtime::FaultEvent& event) {
      json told{{"node", event.node}, {"code", event.code}, {"text", event.text}, {"callback", event.callback}};
      told["when_ns"] = event.when.nanoseconds();
      if (event.lasted) told["lasted_ns"] = event.lasted->count();
      link_->send_note(json{{"open_fault", std::move(told)}}.dump());
    });
    container_->on_state([this](const runtime::StateChange& change) {
      link_->send_note(json{{"state",
                             {change.node, static_cast<unsigned>(change.from), static_cast<unsigned>(change.to),
                              change.when.nanoseconds()}}}
                           .dump());
    });
    // They are read on the main thread: this callback may not ask the container.
    container_->on_change([this] {
      changed_ = true;
      wake();
    });
    link_->start();
  }
  ~IsolatedProcess() {
    static_cast<void>(end());
    ::close(event_);
  }

  /// Returns false if a thread still hangs in the component: the process then has to exit without destructors.
  [[nodiscard]] bool end() {
    if (!container_) return true;
    container_->give_up_transitions_after(kLeaveLimit);
    // The component first: its last messages may still be on their way when it says goodbye.
    container_->on_fault({});
    container_->on_open_fault({});
    container_->on_change({});
    for (const auto& info : container_->list()) static_cast<void>(container_->unload(info.id));
    container_->on_state({});
    const bool all_returned = container_->abandoned() == 0;
    link_.reset();
    container_.reset();
    return all_returned;
  }

  /// Serves the container's requests until the container or a signal ends it.
  void run(const process::StopSignal& stop) {
    while (!over_ && !stop.is_raised()) {
      std::array<pollfd, 2> waits{pollfd{stop.descriptor(), POLLIN, 0}, pollfd{event_, POLLIN, 0}};
      ::poll(waits.data(), waits.size(), -1);
      // Closed, or another file has the number now.
      if (((waits[0].revents | waits[1].revents) & POLLNVAL) != 0) end_without_descriptors();
      if (waits[0].revents != 0 && !stop.is_raised()) end_without_descriptors();
      std::uint64_t count = 0;
      static_cast<void>(!::read(event_, &count, sizeof count));
      std::vector<std::string> notes;
      std::swap(*notes_.lock(), notes);
      for (const auto& note : notes) {
        if (over_) return;
        serve(note);
      }
      if (changed_.exchange(false)) tell_changes();
    }
  }

 private:
  void wake() const {
    const std::uint64_t one = 1;
    // The main thread sleeps on a descriptor that no one can signal any more.
    if (::write(event_, &one, sizeof one) < 0 && errno == EBADF) end_without_descriptors();
  }

  /// The component closed descriptors that it does not own. Destructors would wait for threads that cannot be woken.
  [[noreturn]] static void end_without_descriptors() {
    static_cast<void>(runtime::write_all_safe_stops());
    std::fputs(
        "nacelle: a component closed file descriptors of its process; find its call of closefrom() or a descriptor "
        "that is closed twice\n",
        stderr);
    ::_exit(1);
  }

  // Runs on the link's thread, concurrently with the component: a stop does not wait for a transition to return.
  bool obeys_at_once(const std::string& note) const {
    const json order = parse_json_or_discard(note);
    if (!order.is_object() || !order.contains("do")) return false;
    if (order["do"] == "stop") {
      container_->stop_what_moves();
      return true;
    }
    if (order["do"] == "limit" && order.value("ns", json{}).is_number_integer()) {
      container_->give_up_transitions_after(Duration{order["ns"].get<Duration::rep>()});
      return true;
    }
    return false;
  }

  void serve(const std::string& note) {
    json answer;
    try {
      const auto parsed = parse_json(note);
      if (!parsed) throw std::invalid_argument(parsed.error().text());
      const json& request = parsed.value();
      answer["answer"] = request.at("call");
      const std::string what = request.at("do");
      if (what == "load") {
        load(loading::plan_from_json(request.at("plan")), request.value("collect", false), answer);
      } else if (what == "trigger") {
        trigger(static_cast<Transition>(request.at("transition").get<std::uint8_t>()), answer);
      } else if (what == "unload") {
        static_cast<void>(container_->unload(id_));
        answer["success"] = true;
      } else {
        answer["reason"] = "it does not know the request '" + what + "'";
      }
    } catch (const std::exception& e) { answer["reason"] = std::string("a request that it cannot read: ") + e.what(); }
    link_->send_note(answer.dump());
  }

  // The container keeps what was set at run time, for a restart.
  void tell_changes() {
    const auto request = container_->request_of(id_);
    if (!request) return;
    std::vector<std::string> other_nodes;
    for (const auto& info : container_->list()) other_nodes = info.other_nodes;
    if (request->parameters == told_parameters_ && other_nodes == told_nodes_) return;
    told_parameters_ = request->parameters;
    told_nodes_ = std::move(other_nodes);
    json note;
    note["parameters"] = loading::parameters_to_json(loading::parameters_of(*request));
    note["other_nodes"] = told_nodes_;
    link_->send_note(note.dump());
  }

  void load(const launch::ComponentPlan& plan, bool collect, json& answer) {
    runtime::LoadRequest wanted = loading::load_request_of(plan);
    if (collect) wanted.faults = std::make_shared<ParameterFaults>();
    auto loaded = container_->load(wanted);
    if (!loaded) return fail(loaded.error(), answer);
    id_ = loaded.value().id;
    told_parameters_ = wanted.parameters;
    told_nodes_ = loaded.value().other_nodes;
    if (const auto problem = tied()) {
      static_cast<void>(container_->unload(id_));
      return fail(*problem, answer);
    }
    answer["info"] = info_to_json(loaded.value());
    if (collect) answer["faults"] = faults_to_json(*wanted.faults->lock());
    answer["success"] = true;
  }

  void trigger(Transition transition, json& answer) {
    const TransitionOutcome outcome = container_->trigger(id_, transition);
    if (!outcome.success) {
      answer["reason"] = outcome.reason;
    } else if (const auto problem = tied(); problem && transition == Transition::Configure) {
      static_cast<void>(container_->trigger(id_, Transition::Cleanup));
      fail(*problem, answer);
    } else {
      answer["success"] = true;
    }
    for (const auto& info : container_->list()) {
      if (info.id == id_) answer["info"] = info_to_json(info);
    }
  }

  /// What the component needs and only finds among components of its own process.
  [[nodiscard]] std::optional<Problem> tied() const {
    const auto ties = container_->ties();
    if (ties.empty()) return std::nullopt;
    std::string node;
    for (const auto& info : container_->list()) node = info.node;
    return Problem{"component " + node, "cannot be isolated: it " + join(ties, ", it ") + ", which ends at its process",
                   "leave isolate: process out"};
  }

  static void fail(const Problem& problem, json& answer) {
    answer["success"] = false;
    answer["problem"] = problem;
  }

  const Logger log_;
  msgs::TypeLibrary types_;  // the link's thread's
  const int event_;
  std::atomic<bool> over_{false}, changed_{false};
  Guarded<std::vector<std::string>> notes_;
  std::unique_ptr<Carrier> carrier_;  // outlives the link
  std::unique_ptr<runtime::Container> container_;
  std::unique_ptr<Link> link_;
  std::uint64_t id_ = 0;
  decltype(runtime::LoadRequest::parameters) told_parameters_;  // as the container knows them
  std::vector<std::string> told_nodes_;
};

}  // namespace

int run_isolated(int socket, const std::string& name, const std::string& carrier, const loading::ProgramPlaces& places,
                 const Clock& clock, const process::StopSignal& stop) {
  // The record goes to the container's stderr, which is this process's too.
  const runtime::CrashHandler crashes{"", name};
  IsolatedProcess process{socket, name, carrier, places, clock};
  process.run(stop);
  if (!process.end()) {
    std::fflush(nullptr);
    ::_exit(0);
  }
  return 0;
}

}  // namespace nacelle::isolation
