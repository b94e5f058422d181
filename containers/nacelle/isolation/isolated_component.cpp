// SPDX-License-Identifier: Apache-2.0
#include "isolation/isolated_component.hpp"

#include <fmt/format.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "isolation/isolated_words.hpp"
#include "loading/load_request.hpp"
#include "loading/plan_json.hpp"
#include "nacelle/base/json_text.hpp"
#include "nacelle/base/problem_json.hpp"

namespace nacelle::isolation {
namespace {

using nlohmann::json;

// Beyond what the process itself grants a transition.
constexpr Duration kPatience = 1s;
constexpr Duration kEndLimit = 3s;
constexpr Duration kTurn = 100ms;

}  // namespace

Result<std::shared_ptr<IsolatedComponent>, Problem> IsolatedComponent::start(const launch::ComponentPlan& plan,
                                                                             const loading::ProgramPlaces& places,
                                                                             runtime::Container& container,
                                                                             Carrier* carrier, const Clock& clock,
                                                                             ParameterFaults* faults) {
  auto made = std::make_shared<IsolatedComponent>(plan, places, container, carrier, clock);
  if (auto spawned = made->spawn(); !spawned) return err(spawned.error());
  made->give_up_transitions_after(container.options().transition_timeout);
  auto loaded = made->call({{"do", "load"}, {"plan", loading::plan_to_json(plan)}, {"collect", faults != nullptr}});
  if (!loaded) return err(loaded.error());
  if (faults != nullptr) {
    for (auto& fault : faults_from_json(loaded.value().value("faults", json::array())))
      faults->lock()->push_back(std::move(fault));
  }
  return made;
}

IsolatedComponent::IsolatedComponent(const launch::ComponentPlan& plan, const loading::ProgramPlaces& places,
                                     runtime::Container& container, Carrier* carrier, const Clock& clock)
    : plan_(plan),
      places_(places),
      container_(container),
      carrier_(carrier),
      clock_(clock),
      limit_(container.options().transition_timeout),
      types_(places.message_folders),
      request_(loading::load_request_of(plan)) {
  info_.node = plan.full_name();
  info_.plugin = plan.plugin;
}

IsolatedComponent::~IsolatedComponent() { end_process(); }

Result<void, Problem> IsolatedComponent::spawn() {
  const std::string where = "component " + plan_.full_name();
  int ends[2];
  if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) != 0)
    return err(Problem{where, std::string("no socket for its process: ") + std::strerror(errno), ""});
  process::ProgramSpec spec;
  spec.label = plan_.full_name();
  spec.path = places_.program;
  spec.arguments = {"isolated", "--name", plan_.full_name(), "--parent", std::to_string(::getpid())};
  if (carrier_ != nullptr) spec.arguments.insert(spec.arguments.end(), {"--carrier", carrier_->name()});
  spec.inherited_descriptor = ends[1];
  auto program = process::ForeignProgram::start(spec);
  ::close(ends[1]);
  if (!program) {
    ::close(ends[0]);
    return err(program.error());
  }
  const auto pid = program.value()->pid();
  {
    const LockGuard lock(process_mutex_);
    program_ = std::move(program).value();
  }
  LinkOptions options;
  options.peer = fmt::format("the process of {} ({})", plan_.full_name(), pid);
  options.carrier = carrier_;
  options.mirror_all = true;  // so that reports, checks and tools see its streams
  options.service_hub = &container_.service_graph();
  options.find_type = [this](const std::string& name) -> const msgs::MessageType* {
    auto type = types_.message(name);
    return type ? type.value() : nullptr;
  };
  options.on_note = [this](const std::string& note) { on_note(note); };
  options.on_end = [this](const Problem& problem) { on_end(problem); };
  {
    const LockGuard lock(mutex_);
    process_ = pid;
  }
  link_ = std::make_unique<Link>(container_.graph(), clock_, ends[0], std::move(options));
  link_->start();
  return {};
}

// --- questions and answers ----------------------------------------------------------------------------------------------

Result<json, Problem> IsolatedComponent::call(json request) {
  const LockGuard one(calling_);
  UniqueLock lock(mutex_);
  const Problem over{"component " + plan_.full_name(), "its process is gone: " + how_, "unload it, and load it anew"};
  if (gone_ || closing_) return err(over);
  request["call"] = next_call_;
  answer_.reset();
  link_->send_note(request.dump());
  const auto is_over = [&]() NACELLE_REQUIRES(mutex_) { return gone_ || answer_ != nullptr; };
  const MonotonicTime began = clock_.now(), latest = began + limit_ + kPatience;
  // The limit may get shorter meanwhile: a shutdown waits less long.
  const auto deadline = [&]() NACELLE_REQUIRES(mutex_) {
    return limited_at_ > began ? std::min(latest, limited_at_ + limit_ + kPatience) : latest;
  };
  for (MonotonicTime now = began; !is_over() && now < deadline(); now = clock_.now()) {
    answered_.wait_for(lock.raw(), std::min<Duration>(deadline() - now, kTurn));
    lock.unlock();
    container_.note_waiting();
    lock.lock();
  }
  const bool came = is_over();
  ++next_call_;
  if (answer_ == nullptr) {
    return err(
        Problem{over.where,
                came ? "its process ended: " + how_
                     : fmt::format("its process has not answered within {:.1f} s", to_seconds(clock_.now() - began)),
                came ? "see its output above" : "unload it: its process is ended then"});
  }
  const json answer = *answer_;
  if (!answer.value("success", false)) {
    auto problem = answer.value("problem", json::object()).get<Problem>();
    if (problem.where.empty()) problem.where = over.where;
    if (problem.what.empty()) problem.what = answer.value("reason", "it failed");
    return err(std::move(problem));
  }
  return answer;
}

// On the link's thread. The process is this very program, but nothing it says may bring the container down.
void IsolatedComponent::on_note(const std::string& note) {
  try {
    const auto parsed = parse_json(note);
    if (!parsed) throw std::invalid_argument(parsed.error().text());
    const json& said = parsed.value();
    UniqueLock lock(mutex_);
    if (said.contains("fault")) {
      info_ = info_from_json(said["fault"]);
      const runtime::ComponentInfo faulted = info_;
      lock.unlock();
      tell_fault(faulted, said.value("callback", ""));
      return;
    }
    if (said.contains("open_fault")) {
      lock.unlock();
      return on_open_fault(said["open_fault"]);
    }
    if (said.contains("parameters")) {
      request_.parameters.clear();
      for (auto& parameter : loading::parameters_from_json(said["parameters"]))
        request_.parameters.insert_or_assign(std::move(parameter.name), std::move(parameter.value));
      info_.other_nodes = said.at("other_nodes").get<std::vector<std::string>>();
      lock.unlock();
      return container_.tell_change();
    }
    if (said.contains("state")) {
      const json& change = said["state"];
      info_.state = static_cast<StateId>(change.at(2).get<std::uint8_t>());
      lock.unlock();
      container_.tell_state({change.at(0).get<std::string>(), static_cast<StateId>(change.at(1).get<std::uint8_t>()),
                             static_cast<StateId>(change.at(2).get<std::uint8_t>()),
                             WallTime{Duration{change.at(3).get<std::int64_t>()}}});
      return;
    }
    if (said.contains("info")) info_ = info_from_json(said["info"]);
    // An answer to an abandoned question only updates the state.
    if (said.at("answer").get<std::uint64_t>() != next_call_) return;
    answer_ = std::make_unique<json>(said);
    answered_.notify_all();
  } catch (const std::exception& e) {
    Logger{"session"}.error("the process of {} said something unknown: {}", plan_.full_name(), e.what());
  }
}

void IsolatedComponent::on_open_fault(const json& told) {
  runtime::FaultEvent event{0,
                            told.at("node").get<std::string>(),
                            told.at("code").get<std::string>(),
                            told.at("text").get<std::string>(),
                            told.at("callback").get<std::string>(),
                            WallTime{Duration{told.at("when_ns").get<std::int64_t>()}}};
  event.is_open_fault = true;
  if (told.contains("lasted_ns")) event.lasted = Duration{told["lasted_ns"].get<std::int64_t>()};
  {
    const LockGuard lock(mutex_);
    std::erase_if(info_.open_faults, [&](const FaultReason& fault) { return fault.code == event.code; });
    if (!event.lasted) info_.open_faults.push_back({event.code, event.text});
  }
  container_.tell_open_fault(event);
}

void IsolatedComponent::on_end(const Problem& problem) {
  std::string how;
  {
    const LockGuard lock(process_mutex_);
    if (!program_ || is_closing()) return;
    // A process closes its sockets a moment before its end can be waited for. A process that closed ours and continues is useless.
    if (program_->wait_for_end(1s, clock_)) {
      how = program_->ended();
    } else {
      how = problem.what + "; it was " + program_->stop(clock_);
    }
  }
  runtime::ComponentInfo faulted;
  {
    const LockGuard lock(mutex_);
    gone_ = true;
    how_ = how;
    process_ = 0;
    info_.state = info_.managed ? StateId::Finalized : StateId::Unknown;
    info_.fault = {"PROCESS_ENDED", fmt::format("its process {}", how)};
    info_.open_faults.clear();
    faulted = info_;
    answered_.notify_all();
  }
  tell_fault(faulted, "");
}

// Called at once, on the thread that finds the fault, as within the container. Supervision does the rest.
void IsolatedComponent::tell_fault(const runtime::ComponentInfo& faulted, const std::string& callback) {
  if (plan_.on_fault.stops_robot(faulted.actuator)) container_.stop_what_moves();
  container_.tell_fault(faulted, callback);
}

// --- as any other component ---------------------------------------------------------------------------------------------

runtime::ComponentInfo IsolatedComponent::info() const {
  const LockGuard lock(mutex_);
  runtime::ComponentInfo now = info_;
  now.isolated = true;
  now.process = process_;
  return now;
}

runtime::LoadRequest IsolatedComponent::request() const {
  const LockGuard lock(mutex_);
  return request_;
}

TransitionOutcome IsolatedComponent::trigger(Transition transition) {
  auto answer = call({{"do", "trigger"}, {"transition", static_cast<unsigned>(transition)}});
  const StateId state = info().state;
  if (!answer) return {false, state, answer.error().what};
  return {true, state, {}};
}

// What needs no answer, and is not to wait behind a question.
void IsolatedComponent::tell(const json& order) {
  const LockGuard lock(mutex_);
  if (!gone_ && !closing_ && link_) link_->send_note(order.dump());
}

void IsolatedComponent::stop_what_moves() { tell({{"do", "stop"}}); }

void IsolatedComponent::give_up_transitions_after(Duration limit) {
  {
    const LockGuard lock(mutex_);
    limit_ = limit;
    limited_at_ = clock_.now();
    answered_.notify_all();  // a call that waits for a process that does not answer waits no longer than this
  }
  tell({{"do", "limit"}, {"ns", limit.count()}});
}

runtime::UnloadOutcome IsolatedComponent::unload() {
  // The component stops its hardware itself. Its process ends after any answer.
  static_cast<void>(call({{"do", "unload"}}));
  end_process();
  return {true, {}};
}

bool IsolatedComponent::is_closing() const {
  const LockGuard lock(mutex_);
  return closing_;
}

void IsolatedComponent::end_process() {
  {
    const LockGuard lock(process_mutex_);
    const LockGuard state(mutex_);
    closing_ = true;
  }
  link_.reset();
  const LockGuard lock(process_mutex_);
  if (!program_) return;
  // It leaves by itself when the socket is closed.
  if (!program_->wait_for_end(kEndLimit, clock_)) program_->stop(clock_);
  program_.reset();
}

}  // namespace nacelle::isolation
