// SPDX-License-Identifier: Apache-2.0
#include "session/session.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <exception>
#include <thread>
#include <utility>

#include "answers/interface_services.hpp"
#include "answers/loader.hpp"
#include "answers/own_container.hpp"
#include "control/socket_path.hpp"
#include "loading/load_request.hpp"
#include "nacelle/base/printable.hpp"
#include "nacelle/base/reversed.hpp"
#include "nacelle/node/container_facts.hpp"
#include "nacelle/runtime/crash_record.hpp"
#include "networking/network_wish.hpp"
#include "networking/remote_topics.hpp"
#include "requests/request_server.hpp"
#include "session/bring_up_fault.hpp"
#include "session/comeback.hpp"
#include "session/run_texts.hpp"
#include "transport_dds/wire/remote_graph.hpp"

namespace nacelle::session {
namespace {

// The report's steady state begins so long after the last activation.
constexpr Duration kSettling = 2s;
// A stop signal that the main thread has not obeyed by then finds it in a component's hands.
constexpr Duration kMainThreadLimit = 1s;

}  // namespace

void leave_at_once() noexcept {
  static_cast<void>(runtime::write_all_safe_stops());
  process::kill_all_programs();
}

Session::Session(launch::Plan plan, SessionOptions options, const Clock& clock, process::StopSignal& stop)
    : plan_(std::move(plan)),
      options_(std::move(options)),
      clock_(clock),
      stop_(stop),
      on_terminal_(::isatty(STDERR_FILENO) == 1),
      service_manager_(options_.service_manager != nullptr ? *options_.service_manager : no_manager_) {
  report_.seed = options_.seed;
}

Session::~Session() { end(); }

std::shared_ptr<NetworkFacts> Session::network_facts() const {
  return std::static_pointer_cast<NetworkFacts>(container_->shared_object(kNetworkFactsName));
}

std::shared_ptr<ContainerFacts> Session::facts() const {
  return std::static_pointer_cast<ContainerFacts>(container_->shared_object(kContainerFactsName));
}

void Session::end() {
  lookout_.reset();
  request_server_.reset();
  answers_.reset();
  manager_.reset();
  server_.reset();
  supervision_.reset();
  service_.reset();
  emergency_stops_.reset();
  if (container_) network_facts()->read_remote_by({});
  network_.reset();
  loader_.reset();
  if (container_) facts()->read_texts_by({});
  container_.reset();
  for (auto& program : reversed(programs_)) program->stop(clock_);
}

void Session::say(const std::string& line) const {
  std::fprintf(stderr, on_terminal_ && !options_.verbose ? "\r\033[K%s\n" : "%s\n", printable_entry(line).c_str());
}

void Session::progress(const std::string& line) const {
  if (options_.verbose) {
    std::fprintf(stderr, "%s\n", printable_entry(line).c_str());
  } else if (on_terminal_) {
    std::fprintf(stderr, "\r\033[K%s", printable_line(line).c_str());
    std::fflush(stderr);
  }
}

int Session::run() {
  const int code = guarded_run();
  if (lost_descriptors_) {
    // Other files may have the closed numbers by now, and threads whose events are closed cannot be joined: no destructors.
    std::fflush(nullptr);
    ::_exit(code);
  }
  if (container_ && container_->abandoned() != 0) {
    // Threads that hang in components use what destructors at exit would take away from under them.
    end();
    std::fflush(nullptr);
    ::_exit(code);
  }
  return code;
}

int Session::fail(Problem problem) {
  say("nacelle: " + problem.text());
  failure_ = std::move(problem);
  return 1;
}

int Session::guarded_run() {
  try {
    return run_robot();
  } catch (const std::exception& failure) {
    // The process has no descriptors, threads or memory left. The destructors clean up.
    static_cast<void>(runtime::write_all_safe_stops());
    return fail(Problem{"container", failure.what(), "raise what the process may have: `ulimit -n`, `ulimit -u`",
                        BringUpFault::OutOfResources});
  }
}

int Session::run_robot() {
  for (const auto& message : plan_.messages) say(message.text);
  for (const auto& unused : plan_.unused_sections) {
    say(fmt::format("{}: the parameters for '{}' are used by no node", unused.where.text(), unused.pattern));
  }
  auto claim = control::SocketClaim::take(control::socket_places_from_environment(), options_.container_name);
  if (!claim) return fail(claim.error());
  if (auto looked = look_at_state_file(); !looked) return fail(looked.error());
  const runtime::CrashHandler crashes{crash_file_of(state_->path()), options_.container_name};
  // check_the_plan() reports mistakes in them with the rest.
  const auto asked = loading::container_options_of(plan_.container.parameters, plan_.container.where);
  runtime::ContainerOptions container_options = asked ? *asked : runtime::ContainerOptions{};
  container_options.name = options_.container_name;
  container_options.name_space = plan_.container.namespace_;
  container_options.component_path = options_.places.component_folders;
  container_options.node_interfaces = runtime::NodeInterfaces::All;
  container_ = std::make_unique<runtime::Container>(std::move(container_options), clock_);
  facts()->read_texts_by([this] {
    std::vector<RunText> texts = options_.files;
    texts.push_back(parameters_text(*container_));
    return texts;
  });
  watchdog_.emplace(
      service_manager_, [this] { return why_not_feed(); }, clock_, [this](const std::string& line) { say(line); });
  container_->call_while_waiting([this, main = std::this_thread::get_id()] {
    if (std::this_thread::get_id() == main) watchdog_->work();
  });
  network_ = std::make_unique<networking::Network>(
      plan_.network, networking::ros_environment(), container_->graph(), container_->service_graph(), clock_,
      [this](const std::string& line) { say(line); },
      std::static_pointer_cast<ClockSkews>(container_->shared_object(kClockSkewsName)));
  network_facts()->read_remote_by([this](std::uint64_t& version) {
    std::vector<RemoteTopic> topics;
    network_->look([&](const transport_dds::RemoteGraph& graph) {
      if (std::exchange(version, graph.version()) != graph.version()) topics = networking::remote_topics_of(graph);
    });
    return topics;
  });
  network_->protect_services_of(container_->node());
  if (auto joined = network_->start(); !joined) return fail(joined.error());
  supervision_ = std::make_unique<Supervision>(
      SupervisedRun{*this, clock_, fault_bell_, [this](const std::string& line) { say(line); }, left_out_, *crashes_});
  lookout_ = std::make_unique<Lookout>(
      stop_, [this] { return is_going_up_ ? Duration::zero() : kMainThreadLimit; },
      [this] {
        container_->stop_what_moves();
        container_->give_up_transitions_after(kShutdownStepLimit);
      });
  for (const auto& node : held_actuators_) supervision_->note_actuator(node);
  service_ = std::make_unique<RobotService>(
      *container_, options_.places.message_folders,
      [](void* stop) { static_cast<process::StopSignal*>(stop)->raise_by_request(); }, &stop_, fault_bell_);
  emergency_stops_ = std::make_unique<EmergencyStops>(*container_);
  if (auto set = set_held_stops(); !set) return fail(set.error());
  if (!options_.transitions_file.empty()) {
    auto log = TransitionLog::open(options_.transitions_file, clock_);
    if (!log) return fail(log.error());
    transitions_ = std::move(log).value();
  }
  server_ = std::make_unique<control::ControlServer>(std::move(claim).value(), *service_, clock_);

  loader_ = std::make_unique<answers::Loader>(*this);
  answers_ = std::make_unique<answers::InterfaceServices>(*this);
  request_server_ = std::make_unique<requests::RequestServer>(
      std::make_unique<answers::OwnContainer>(*this),
      requests::RequestLimits{.guests = control::most_guests(), .idle = control::kIdleLimit});

  tell_service_manager("", fmt::format("bringing up {} components", plan_.components.size()));
  auto up = guarded_bring_up();
  is_going_up_ = false;
  if (!up) {
    undoing_ = true;
    fail(up.error());  // printed at once: taking things down may take a while
  } else if (const auto failure = serve()) {
    fail(*failure);
  }
  // A fault that came just before the signal has been found, and perhaps not been dealt with yet.
  const bool stopped_by_a_fault = supervision_->has_stopped_the_robot() || !supervision_->why_to_stop().empty();
  request_server_.reset();
  loader_->close();
  take_down();
  if (!undoing_ && !write_report()) return 1;
  return failure_ || stopped_by_a_fault ? 1 : 0;
}

Result<void, Problem> Session::look_at_state_file() {
  if (options_.state_file.empty()) {
    auto folder = control::folder_for_socket(control::socket_places_from_environment());
    if (!folder) return err(folder.error());
    options_.state_file = folder.value() + "/" + options_.container_name + ".composition";
  }
  state_ = std::make_unique<CompositionFile>(options_.state_file);
  const std::string crash_file = crash_file_of(state_->path());
  const auto crash = read_crash(crash_file);
  crashes_ = std::make_unique<EarlyCrashes>(state_->path() + ".crashes");
  crashes_->begin(options_.resume, crash);
  if (!options_.resume) return {};
  if (crashes_->last_run_crashed())
    say(fmt::format("nacelle: the last run crashed: {} (all of it: {})", crash->text, crash_file));
  auto held = read_composition(state_->path());
  if (!held) return err(held.error());
  if (!held.value()) {
    say(fmt::format("nacelle: nothing to resume: there is no {}; starting from the launch file", state_->path()));
    leave_out_what_crashes();
    return {};
  }
  if (held.value()->container != options_.container_name) {
    return err(Problem{state_->path(), "holds the container '" + held.value()->container + "', not this one",
                       "start that one with --name " + held.value()->container + ", or give another --state FILE"});
  }
  for (const auto& component : held.value()->components) {
    if (component.actuator) held_actuators_.push_back(component.plan.full_name());
  }
  held_stops_ = held.value()->emergency_stops;
  is_resumed_ = true;
  plan_ = resumed(std::move(plan_), *held.value(), state_->path());
  for (const auto& component : held.value()->components) {
    const auto* const now = plan_.find(component.plan.full_name());
    if (component.actuator && now != nullptr && now->target == launch::TargetState::Inactive)
      resting_.push_back(component.plan.full_name());
  }
  leave_out_what_crashes();
  say(fmt::format("nacelle: resuming {} components from {}", plan_.components.size(), state_->path()));
  return {};
}

void Session::leave_out_what_crashes() {
  const auto is_left_out = [this](const std::string& node) { return crashes_->is_left_out(node); };
  for (const auto& component : plan_.components) {
    const std::string node = component.full_name();
    if (!is_left_out(node)) continue;
    left_out_.push_back({component, std::ranges::find(held_actuators_, node) != held_actuators_.end()});
    say(fmt::format(
        "nacelle: left out: {}: {}; to try it again, load it (`nacelle component load {} --name {}`) or start "
        "without --resume",
        node, crashes_->reason(node), component.plugin, component.name));
  }
  if (left_out_.empty()) return;
  is_resumed_ = true;
  std::erase_if(plan_.components, [&](const auto& component) { return is_left_out(component.full_name()); });
  std::erase_if(resting_, is_left_out);
  for (auto& component : plan_.components)
    std::erase_if(component.after, [&](const auto& condition) { return is_left_out(condition.node); });
}

void Session::say_what_rests() const {
  for (const auto& node : resting_) {
    say(
        fmt::format("nacelle: {} moves something, so it was restored as inactive on purpose; "
                    "`nacelle lifecycle set {} activate` activates it",
                    node, node));
  }
}

// An emergency stop is latched: neither the end of its publisher nor that of the container releases it.
Result<void, Problem> Session::set_held_stops() {
  for (const auto& topic : held_stops_) {
    if (auto set = service_->set_emergency_stop(topic); !set)
      return err(Problem{topic, "the emergency stop was set before the crash, and cannot be set again: " + set.error(),
                         "start without --resume"});
    say(fmt::format("nacelle: the emergency stop {} was set and still is; `nacelle estop release` releases it", topic));
  }
  return {};
}

void Session::keep_composition() {
  if (service_->phase() != Phase::Running) return;
  static_cast<void>(emergency_stops_->look());
  auto kept = state_->write(composition_of(*this, *supervision_, left_out_));
  if (!kept && !told_of_state_) say("nacelle: " + kept.error().text());
  told_of_state_ = !kept;
}

void Session::composition_changed() {
  service_->set_nodes(container_->list());
  supervision_->publish();
  static_cast<void>(emergency_stops_->look());  // from the first reader on
  if (service_->phase() != Phase::Running) return;
  keep_composition();
  steady_.reset();
  steady_from_ = clock_.now() + kSettling;
}

nacelle_interfaces::srv::GetFaults::Response Session::faults() const {
  auto faults = supervision_->report();
  const std::string file = crash_file_of(options_.state_file);
  if (const auto crash = read_crash(file)) {
    faults.last_crash = fmt::format("{} (all of it: {})", crash->text, file);
    faults.last_crash_file = file;
  }
  return faults;
}

Result<void, Problem> Session::guarded_bring_up() {
  try {
    return bring_up();
  } catch (const std::exception& failure) {
    return err(Problem{"bring-up", failure.what(), "raise what the process may have: `ulimit -n`, `ulimit -u`",
                       BringUpFault::OutOfResources});
  }
}

}  // namespace nacelle::session
