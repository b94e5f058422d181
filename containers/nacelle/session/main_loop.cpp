// SPDX-License-Identifier: Apache-2.0
// What a session's main thread waits for and does while the robot runs.
#include <fmt/format.h>

#include <algorithm>

#include "answers/interface_services.hpp"
#include "answers/loader.hpp"
#include "nacelle/base/printable.hpp"
#include "requests/request_server.hpp"
#include "session/clock_jump.hpp"
#include "session/session.hpp"

namespace nacelle::session {
namespace {

constexpr Duration kBudgetPeriod = 1s;

}  // namespace

process::Task Session::services_task() {
  return process::on_readable("services", answers_->descriptor(), [this] { answers_->serve(); });
}

// The clients of the control socket. It closes some of them if poll() rejects the list of descriptors.
process::Task Session::requests_task() {
  return {
      .name = "requests",
      .watch =
          [this](std::vector<pollfd>& waits) {
            waits.push_back({server_->handed_over_descriptor(), POLLIN, 0});
            request_server_->append_waits(waits);
          },
      .next_due = [this] { return request_server_->next_due(); },
      .serve =
          [this](std::span<const pollfd> waits) {
            request_server_->serve(waits.data() + 1);
            if (waits.front().revents == 0) return;
            for (auto& handed : server_->take_handed_over()) request_server_->take(std::move(handed));
          },
      .shed = [this] { request_server_->send_half_away("closed: too many connections for the limit of open files"); }};
}

void Session::add_upkeep(process::EventLoop& loop) {
  loop.add({.name = "figures",
            .watch = {},
            .next_due = [this] { return steady_.has_begun() ? std::nullopt : steady_from_; },
            .serve = [this](auto) { steady_.begin(clock_.now()); },
            .shed = {}});
  loop.add({.name = "budgets",
            .watch = {},
            .next_due = [this] { return next_budget_look_; },
            .serve =
                [this](auto) {
                  next_budget_look_ = clock_.now() + kBudgetPeriod;
                  for (const auto& event : budgets_.look(*container_, clock_.now())) say("nacelle: " + event.text());
                },
            .shed = {}});
  loop.add({.name = "network",
            .watch =
                [this](std::vector<pollfd>& waits) {
                  waits.push_back({network_->descriptor(), POLLIN, 0});
                },
            .next_due = [this] { return network_->next_due(); },
            .serve = [this](std::span<const pollfd> waits) { network_->serve(waits.front().revents != 0); },
            .shed = {}});
}

// What components and the control thread ring for: states, faults, descriptors. Each part is tried by itself.
void Session::add_supervision(process::EventLoop& loop) {
  const auto watch = [this](std::vector<pollfd>& waits) { waits.push_back({fault_bell_.descriptor(), POLLIN, 0}); };
  loop.add({.name = "states",
            .watch = watch,
            .next_due = {},
            .serve =
                [this](auto) {
                  fault_bell_.silence();
                  service_->set_nodes(container_->list());
                },
            .shed = {}});
  loop.add({.name = "descriptors",
            .watch = watch,
            .next_due = {},
            .serve = [this](auto) { look_at_descriptors(); },
            .shed = {}});
  const auto next_due = [this] { return supervision_->next_due(); };
  loop.add(
      {.name = "faults",
       .watch = watch,
       .next_due = next_due,
       .serve =
           [this, &loop](auto) {
             supervision_->work();
             if (const std::string why = supervision_->why_to_restart(); !why.empty())
               loop.end(Problem{"container", why, "its service manager, if it has one, starts it again with --resume"});
           },
       .shed = {}});
  loop.add({.name = "state",
            .watch = watch,
            .next_due = next_due,
            .serve = [this](auto) { keep_composition(); },
            .shed = {}});
}

void Session::tell_service_manager(const char* state, const std::string& status) const {
  service_manager_.tell(fmt::format("{}STATUS={}", state, printable_line(status)));
}

std::string Session::running_status() const {
  const auto components = container_->list();
  const auto is_faulted = [](const runtime::ComponentInfo& info) { return !info.fault.code.empty(); };
  const auto faulted = std::ranges::count_if(components, is_faulted);
  return fmt::format("{} components{}", components.size(), faulted == 0 ? "" : fmt::format(", {} faulted", faulted));
}

std::string Session::why_not_feed() {
  std::string why = supervision_ ? supervision_->why_to_restart() : std::string{};
  if (!why.empty() || !container_)
    return why;  // without a container: it is being destroyed, and waits for its components
  return container_->stalled();
}

void Session::add_service_manager(process::EventLoop& loop) {
  loop.add({.name = "watchdog",
            .watch = {},
            .next_due = [this] { return watchdog_->next_due(); },
            .serve = [this](auto) { watchdog_->work(); },
            .shed = {}});
  if (stop_.reload_descriptor() < 0) return;
  reload_.emplace(*this, options_.reread, clock_, [this](const std::string& line) { say(line); });
  loop.add(process::on_readable("reload", stop_.reload_descriptor(), [this] {
    stop_.take_reload();
    const auto now_us = clock_.now().nanoseconds() / 1000;
    tell_service_manager(fmt::format("RELOADING=1\nMONOTONIC_USEC={}\n", now_us).c_str(), "reloading parameters");
    if (!reload_->begin()) say("nacelle: reload: one is running; try again when it has ended");
  }));
  loop.add({.name = "reloaded parameters",
            .watch =
                [this](std::vector<pollfd>& waits) {
                  waits.push_back({reload_->descriptor(), POLLIN, 0});
                },
            .next_due = [this] { return reload_->next_due(); },
            .serve =
                [this](auto) {
                  const auto ended = reload_->work();
                  if (!ended) return;
                  say("nacelle: " + *ended);
                  tell_service_manager("READY=1\n", running_status() + "; " + *ended);
                },
            .shed = {}});
}

void Session::add_programs(process::EventLoop& loop) {
  loop.add({.name = "programs",
            .watch =
                [this](std::vector<pollfd>& waits) {
                  for (const auto& program : programs_) waits.push_back({program->descriptor(), POLLIN, 0});
                },
            .next_due = {},
            .serve =
                [this, &loop](auto) {
                  if (auto failure = look_at_programs()) loop.end(std::move(failure));
                },
            .shed = {}});
}

std::optional<Problem> Session::look_at_programs() {
  for (const auto& program : programs_) {
    if (program->descriptor() < 0) continue;
    const std::string how = program->ended();
    if (how.empty()) continue;
    Problem problem{"program " + program->spec().label, how, "see its output above"};
    if (program->spec().required) return problem;
    say("nacelle: " + problem.text());
  }
  return std::nullopt;
}

std::optional<Problem> Session::serve() {
  decltype(make_kernel_clock_alarm()) kernel_alarm;
  ClockWatch clock_watch{
      clock_, options_.clock_alarm != nullptr ? *options_.clock_alarm : *(kernel_alarm = make_kernel_clock_alarm())};
  ClockJumpReport clock_jumps{container_->transport(), options_.container_name,
                              fully_qualified_node_name(plan_.container.namespace_, options_.container_name)};
  if (!budgets_.empty()) next_budget_look_ = clock_.now();
  process::EventLoop loop{clock_};
  loop.add(process::on_readable("stop signal", stop_.descriptor(), [&] {
    // Without a signal, another file has this number now.
    if (!stop_.is_raised() || service_->has_lost_a_descriptor()) {
      loop.end_with_a_lost_descriptor();
    } else {
      loop.end();
    }
  }));
  add_supervision(loop);
  loop.add(process::on_readable("clock", clock_watch.descriptor(), [&] {
    const auto step = clock_watch.look();
    if (!step) return;
    say("nacelle: " + clock_jumps.tell(*step, clock_.wall_now()));
    network_->note_clock_jump();
  }));
  loop.add(process::on_readable("composition", loader_->descriptor(), [this] { loader_->serve(); }));
  loop.add(services_task());
  add_upkeep(loop);
  loop.add({.name = "emergency stops",
            .watch = [this](std::vector<pollfd>& waits) { emergency_stops_->append_waits(waits); },
            .next_due = {},
            .serve =
                [this](auto) {
                  if (emergency_stops_->look()) keep_composition();
                },
            .shed = {}});
  add_programs(loop);
  loop.add(requests_task());
  add_service_manager(loop);
  tell_service_manager("READY=1\n", running_status());
  watchdog_->begin();
  auto failure = loop.run();
  lost_descriptors_ = loop.has_lost_a_descriptor();
  return failure;
}

// Requests are answered while the bring-up waits, so that a user can see what it waits for.
void Session::answer_guests() {
  process::EventLoop loop{clock_};
  loop.add(services_task());
  loop.add(requests_task());
  loop.turn(Duration::zero());
}

}  // namespace nacelle::session
