// SPDX-License-Identifier: Apache-2.0
#include "ekf/component/report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include "ekf/component/innovation_report.hpp"

namespace nacelle::ekf {
namespace {

constexpr int kPatience = 2;  // checks without a fused measurement before a report
constexpr int kLooksBetweenLosses = 10;
constexpr std::uint64_t kSameStamps = 10;  // that many in a row are no coincidence
constexpr Duration kFarBehind = 1s;        // more than any latency that a filter without history can use

Duration far_behind(const Filter& filter) {
  return filter.history() == nullptr ? kFarBehind : std::max(kFarBehind, filter.history()->length());
}

// Of a queue: in the subscription, and in the filter.
std::uint64_t lost_of(const Input& input, const Filter& filter) {
  std::uint64_t lost = input.lost();
  for (const auto& part : input.parts()) lost += filter.stats(part.number).of(Rejection::QueueFull);
  return lost;
}

// The cause that grew most since the last look.
Rejection main_cause(const PartStats& now, const PartStats& before) {
  std::size_t most = 0;
  for (std::size_t i = 1; i < kRejections; ++i) {
    if (now.rejected[i] - before.rejected[i] > now.rejected[most] - before.rejected[most]) most = i;
  }
  return static_cast<Rejection>(most);
}

std::string in_words(Rejection cause, const Input& input, const PartStats& stats, const ClockSkews* skews) {
  const std::string skew = skews == nullptr ? "" : skews->cause(input.writer());
  switch (cause) {
    case Rejection::Gate: return "outside the rejection threshold";
    case Rejection::Stale: return "its stamps go backwards" + skew;
    case Rejection::NotFinite: return "what is configured of it is not a finite number";
    case Rejection::NoTransform: return "no transform: " + input.last_fault().text();
    case Rejection::Covariance: return "its covariance is none (not finite, or not positive definite)";
    case Rejection::BeforeSetPose: return "older than the last set_pose" + skew;
    case Rejection::QueueFull:
    case Rejection::Future:
      if (!skew.empty()) return "its stamps lie in the future" + skew;
      return fmt::format("its stamps lie {:.3f} s in the future; do the clocks agree?", -to_seconds(stats.behind));
    case Rejection::NoStamp: return "its stamps are zero; its driver has to stamp what it measures";
    case Rejection::Absent: return "the messages say that they do not carry it (covariance[0] is -1)";
    case Rejection::First: return "it only starts the difference";
    case Rejection::BeforeHistory:
      return fmt::format("its stamps are {:.3f} s behind the filter, more than history_length",
                         to_seconds(stats.late_by)) +
             skew;
  }
  return "?";
}

}  // namespace

Watch::Watch(const std::vector<std::unique_ptr<Input>>& inputs, const Filter& filter,
             std::shared_ptr<const ClockSkews> skews)
    : skews_(std::move(skews)) {
  for (const auto& input : inputs) {
    for (const auto& part : input->parts()) seen_.push_back({filter.stats(part.number), input->messages()});
    losses_.push_back({lost_of(*input, filter)});
  }
}

void Watch::look(const std::vector<std::unique_ptr<Input>>& inputs, const Filter& filter, const Logger& logger) {
  std::size_t at = 0;
  for (std::size_t i = 0; i < inputs.size(); ++i) look_at_losses(*inputs[i], filter, losses_[i], logger);
  for (const auto& input : inputs) {
    for (const auto& part : input->parts()) {
      Seen& seen = seen_[at++];
      const PartStats& now = filter.stats(part.number);
      const bool fused = now.fused > seen.stats.fused;
      const bool came = input->messages() > seen.messages;
      const Rejection cause = main_cause(now, seen.stats);
      seen.idle_looks = fused ? 0 : seen.idle_looks + 1;
      if (fused && seen.trouble != Trouble::None) {
        logger.info("{} is fused again", part.name);
        seen.trouble = Trouble::None;
      } else if (!fused && seen.idle_looks >= kPatience) {
        const Trouble trouble = came ? Trouble::Rejected : Trouble::Silent;
        const bool waits = came && now.waiting > 0 && now.of(cause) == seen.stats.of(cause);
        if (trouble != seen.trouble || (came && cause != seen.cause)) {
          if (!came) {
            logger.warn("waiting for {}: no message on {}", part.name, input->options().topic);
          } else {
            logger.warn("{} is not fused: {}", part.name,
                        in_words(waits ? Rejection::Future : cause, *input, now, skews_.get()));
          }
          seen.trouble = trouble;
          seen.cause = cause;
        }
      }
      if (came) look_at_stamps(*input, part, filter, seen, logger);
      seen.stats = now;
      seen.messages = input->messages();
    }
  }
}

// Reports implausible stamps, which are fused nevertheless, as in robot_localization.
void Watch::look_at_stamps(const Input& input, const Input::Part& part, const Filter& filter, Seen& seen,
                           const Logger& logger) const {
  const PartStats& now = filter.stats(part.number);
  const bool stands = now.same_stamp >= kSameStamps && now.of(Rejection::NoStamp) == 0;
  if (stands && !seen.stands)
    logger.warn("{}: its stamps stand still ({} messages have one stamp); its driver has to stamp what it measures",
                part.name, now.same_stamp + 1);
  if (!stands && seen.stands) logger.info("{}: its stamps move again", part.name);
  seen.stands = stands;
  const bool far = now.behind > far_behind(filter) && !stands && now.fused > seen.stats.fused;
  seen.behind_looks = far ? seen.behind_looks + 1 : 0;
  const bool behind = seen.behind_looks >= kPatience;
  if (behind && !seen.behind) {
    const std::string skew = skews_ == nullptr ? "" : skews_->cause(input.writer());
    logger.warn("{}: its stamps are {:.3f} s behind the clock{}", part.name, to_seconds(now.behind),
                skew.empty() ? "; do the clocks agree?" : skew);
  }
  if (!far && seen.behind) logger.info("{}: its stamps are up to date again", part.name);
  seen.behind = behind || (seen.behind && far);
  // If none of them was fused, look() has reported it.
  const std::uint64_t early = now.of(Rejection::Future) - seen.stats.of(Rejection::Future);
  const bool fused = now.fused > seen.stats.fused;
  if (early > 0 && fused && !seen.ahead)
    logger.warn("{}: {} of its last {} stamps lie in the future{}; these measurements are not fused", part.name, early,
                now.received - seen.stats.received, skews_ == nullptr ? "" : skews_->cause(input.writer()));
  if (early == 0 && fused && seen.ahead) logger.info("{}: its stamps no longer lie in the future", part.name);
  seen.ahead = early > 0 ? seen.ahead || fused : seen.ahead && !fused;
}

void Watch::look_at_losses(const Input& input, const Filter& filter, Losses& losses, const Logger& logger) {
  const std::uint64_t lost = lost_of(input, filter);
  if (losses.looks > 0) --losses.looks;
  if (lost == losses.told || losses.looks > 0) return;
  const std::uint64_t in_filter = lost - input.lost();
  logger.warn(
      "{}: {} measurements were lost ({} in all: {} in the subscription's queue, see {}_queue_size; {} in the "
      "filter's, "
      "see measurement_queue_limit)",
      input.options().name, lost - losses.told, lost, input.lost(), input.options().name, in_filter);
  losses = {lost, kLooksBetweenLosses};
}

void write_diagnostics(const std::vector<std::unique_ptr<Input>>& inputs, const Filter& filter, const std::string& node,
                       diagnostic_msgs::msg::DiagnosticArray& out) {
  using diagnostic_msgs::msg::DiagnosticStatus;
  out.status.clear();
  for (const auto& input : inputs) {
    for (const auto& part : input->parts()) {
      const PartStats& stats = filter.stats(part.number);
      DiagnosticStatus& status = out.status.emplace_back();
      std::uint64_t rejected = 0;
      for (const std::uint64_t n : stats.rejected) rejected += n;
      const bool doubtful = stats.same_stamp >= kSameStamps || stats.behind > far_behind(filter);
      status.level = stats.fused == 0 || doubtful ? DiagnosticStatus::WARN : DiagnosticStatus::OK;
      status.name = fmt::format("{}: {}", node, part.name);
      status.message = fmt::format("{} fused, {} rejected", stats.fused, rejected);
      status.hardware_id = "none";
      const auto add = [&status](std::string_view key, std::uint64_t value) {
        auto& pair = status.values.emplace_back();
        pair.key = key;
        pair.value = fmt::format("{}", value);
      };
      add("received", stats.received);
      add("fused", stats.fused);
      add("late", stats.late);
      add("waiting", stats.waiting);
      add("lost", input->lost());
      add("same_stamp", stats.same_stamp);
      for (std::size_t i = 0; i < kRejections; ++i)
        add(fmt::format("rejected_{}", kRejectionNames[i]), stats.rejected[i]);
      add_innovations(part, filter, status);
    }
  }
}

}  // namespace nacelle::ekf
