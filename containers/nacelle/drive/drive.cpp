// SPDX-License-Identifier: Apache-2.0
#include "drive/drive.hpp"

#include <fmt/format.h>
#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <nlohmann/json.hpp>
#include <set>

#include "control/client.hpp"
#include "drive/container_process.hpp"
#include "drive/live_figures.hpp"
#include "drive/live_view.hpp"
#include "drive/run_folder.hpp"
#include "drive/run_recorder.hpp"
#include "drive/velocity_sender.hpp"
#include "nacelle/base/files.hpp"
#include "nacelle/base/json_text.hpp"
#include "report/run_report.hpp"
#include "run_page/page.hpp"
#include "simulation/port/truth_file.hpp"

namespace nacelle::drive {
namespace {

constexpr Duration kAnswerLimit = 5s;
constexpr Duration kBringUpLimit = 60s;
constexpr Duration kShutdownLimit = 30s;
constexpr Duration kControlPeriod = 20ms;
constexpr Duration kStaleLimit = 1s;
constexpr int kInterrupted = 130;  // the shell's exit code of a program that SIGINT ended

/// Where filter and world think the robot is, at standstill.
struct FinalPoses {
  bool taken = false;
  PlanarPose ekf, truth;
};

class Run {
 public:
  Run(const DriveSettings& settings, process::StopSignal& stop, const Clock& clock)
      : settings_(settings),
        stop_(stop),
        clock_(clock),
        view_(::isatty(STDOUT_FILENO) == 1 && !settings.verbose, clock.now()),
        course_(settings.course) {}

  int run() {
    // Found out now, not after the drive.
    for (const auto* const file : {&settings_.report_file, &settings_.html_file}) {
      if (file->empty()) continue;
      if (auto fine = report::check_report_file(*file); !fine) return fail(fine.error());
    }
    auto done = bring_up();
    if (done && !settings_.html_file.empty()) start_recorder();
    if (done) done = settings_.duration || settings_.stay ? idle() : drive();
    take_down(done.has_value());
    const auto report = figures();
    const bool is_page_written = write_page(report, done);
    if (!done) return fail(done.error());
    const int code = finish(report);
    return code == 0 && !is_page_written ? 1 : code;
  }

 private:
  [[nodiscard]] Result<void, Problem> bring_up() {
    if (folder_.path().empty())
      return err(Problem{"drive", "no folder for the run can be made", "set XDG_RUNTIME_DIR to a folder of yours"});
    process::ProgramSpec spec;
    spec.label = "container";
    spec.path = settings_.program;
    name_ = fmt::format("drive-{}", ::getpid());
    spec.arguments = {"launch",
                      settings_.launch_file,
                      "--name",
                      name_,
                      "--report",
                      container_report(),
                      "--last-message",
                      settings_.odometry_topic,
                      "--parent",
                      std::to_string(::getpid()),
                      "--verbose",
                      "sim:=true",
                      fmt::format("seed:={}", settings_.seed),
                      "sim_dir:=" + folder_.path()};
    // On the network, any other robot on this machine that reads /cmd_vel would drive as well, so it is off by default.
    if (std::ranges::none_of(settings_.arguments, [](const auto& one) { return one.starts_with("network:="); }))
      spec.arguments.emplace_back("network:=off");
    spec.arguments.insert(spec.arguments.end(), settings_.arguments.begin(), settings_.arguments.end());
    // It puts a robot to rest before it ends.
    spec.sigterm_after = 10s;
    auto process = ContainerProcess::start(spec, name_, settings_.verbose, clock_);
    if (!process) return err(process.error());
    container_ = std::move(process).value();

    auto client = container_->connect(kBringUpLimit, stop_.descriptor());
    if (!client) return err(interrupted_or(client.error()));
    client_.emplace(std::move(client).value());
    const MonotonicTime until = clock_.now() + kBringUpLimit;
    while (true) {
      auto stats = look("");
      if (!stats) return stats;
      if (phase_ == "running") return {};
      if (stop_.is_raised()) return err(Problem{"", "interrupted", ""});
      if (clock_.now() > until) return err(Problem{"container", "is still " + phase_, "-v shows its steps"});
      container_->listen(50ms, stop_.descriptor());
    }
  }

  /// Not for a container without odometry: the page has none then.
  void start_recorder() {
    std::optional<OdometryTap> odometry;
    if (auto client = container_->connect(kAnswerLimit, stop_.descriptor())) {
      if (auto tap = OdometryTap::open(std::move(client).value(), settings_.odometry_topic))
        odometry = std::move(tap).value();
    }
    recorder_.emplace(truth_file(), std::move(odometry), clock_.now(), clock_.wall_now());
  }
  [[nodiscard]] Duration look_period() const {
    return recorder_ ? std::min(view_.period(), RunRecorder::kStatsPeriod) : view_.period();
  }

  [[nodiscard]] Result<void, Problem> idle() {
    const MonotonicTime begin = clock_.now();
    const bool for_ever = settings_.stay;
    while (!stop_.is_raised()) {
      const Duration ran = clock_.now() - begin;
      if (!for_ever && ran >= *settings_.duration) break;
      const std::string activity = for_ever ? fmt::format("until Ctrl-C; container '{}'", name_)
                                            : fmt::format("{:.0f} s left", to_seconds(*settings_.duration - ran));
      if (auto stats = look(activity); !stats) return stats;
      if (recorder_) {
        auto X_OB = client_->lookup(settings_.odom_frame, settings_.base_frame, kAnswerLimit);
        if (!X_OB) return err(interrupted_or(X_OB.error()));
        recorder_->note_pose(X_OB.value(), clock_.now(), clock_.wall_now());
      }
      // With --stay, the robot continues with the remaining components, as under `launch`.
      if (for_ever) tell_faults();
      if (auto fine = for_ever ? check_runs() : check_faults(); !fine) return fine;
      container_->listen(for_ever ? look_period() : std::min(look_period(), *settings_.duration - ran),
                         stop_.descriptor());
    }
    // Of --stay and --for, Ctrl-C is an ordinary end.
    return {};
  }

  [[nodiscard]] Result<void, Problem> drive() {
    auto sender = VelocitySender::open(*client_, settings_.topic, settings_.stamped, settings_.command_frame);
    if (!sender) return err(sender.error());
    const auto zero = [&] { static_cast<void>(sender.value().send(0, 0, clock_.wall_now())); };
    MonotonicTime next = clock_.now(), next_look = next;
    WallTime newest{};
    MonotonicTime newest_at = next;
    while (!course_.is_over()) {
      auto X_OB = client_->lookup(settings_.odom_frame, settings_.base_frame, kAnswerLimit);
      if (!X_OB) return err(interrupted_or(X_OB.error()));
      const MonotonicTime now = clock_.now();
      if (X_OB.value().known && X_OB.value().stamp > newest) {
        newest = X_OB.value().stamp;
        newest_at = now;
      }
      if (stop_.is_raised() || now - newest_at > kStaleLimit) {
        zero();
        if (stop_.is_raised()) return err(Problem{"", "interrupted", ""});
        return err(Problem{"drive",
                           fmt::format("no new transform {} -> {} for a second; the robot was stopped",
                                       settings_.odom_frame, settings_.base_frame),
                           "does the launch file start odometry or an EKF?"});
      }
      if (recorder_) recorder_->note_pose(X_OB.value(), now, clock_.wall_now());
      if (X_OB.value().known) {
        pose_ = planar(X_OB.value());
        const VelocityCommand command = course_.step(pose_, now);
        if (auto sent = sender.value().send(command.speed_mps, command.yaw_rate_rps, clock_.wall_now()); !sent)
          return err(interrupted_or(sent.error()));
      }
      if (now >= next_look) {
        next_look = now + look_period();
        if (auto stats = look(activity()); !stats) return stats;
        if (auto fine = check_faults(); !fine) {
          zero();
          return fine;
        }
      }
      // A fixed rate; after a delay the schedule restarts, so that no burst of commands follows.
      next = std::max(next + kControlPeriod, clock_.now());
      container_->listen(next - clock_.now(), stop_.descriptor());
      while (clock_.now() < next && !stop_.is_raised() && container_->ended().empty())
        container_->listen(next - clock_.now(), stop_.descriptor());
    }
    zero();
    if (course_.phase() == CoursePhase::Stalled) {
      return err(Problem{"drive", fmt::format("the robot does not move any more: {}", activity()),
                         "is something in its way, or a limit at zero?"});
    }
    return take_final_poses();
  }

  [[nodiscard]] Result<void, Problem> take_final_poses() {
    auto X_OB = client_->lookup(settings_.odom_frame, settings_.base_frame, kAnswerLimit);
    if (!X_OB) return err(X_OB.error());
    const auto truth = simulation::read_truth(truth_file());
    // Without a simulated world (sim:=false) there is nothing to compare with.
    if (truth && X_OB.value().known) {
      final_ = {true, planar(X_OB.value()), {truth.value().x_m, truth.value().y_m, truth.value().yaw_rad}};
    }
    driven_ = true;
    return {};
  }

  [[nodiscard]] Result<void, Problem> look(const std::string& activity) {
    auto text = client_->stats(kAnswerLimit);
    if (!text) return err(interrupted_or(text.error()));
    stats_ = parse_json_or_discard(text.value());
    if (!stats_.is_object() || !stats_.contains("streams") || !stats_.contains("nodes"))
      return err(Problem{"container", "its figures cannot be read", ""});
    phase_ = stats_.value("phase", "");
    view_.show(stats_, activity, clock_.now());
    if (recorder_) recorder_->note_stats(stats_, clock_.now());
    return {};
  }

  [[nodiscard]] Result<void, Problem> check_faults() const {
    if (const auto faults = faults_of(stats_); !faults.empty()) return err(faults.front());
    return check_runs();
  }

  /// Each fault once.
  void tell_faults() {
    std::set<std::string> faults;
    for (const Problem& fault : faults_of(stats_)) {
      const std::string text = fault.text();
      faults.insert(text);
      if (faults_told_.contains(text)) continue;
      view_.clear();
      std::fprintf(stderr, "nacelle: %s\n", text.c_str());
    }
    faults_told_ = std::move(faults);
  }

  [[nodiscard]] Result<void, Problem> check_runs() const {
    if (phase_ != "running") return err(Problem{"container", "is " + phase_ + " before the drive was over", ""});
    return {};
  }

  [[nodiscard]] std::string activity() const {
    const unsigned sides = settings_.course.sides;
    return fmt::format("side {} of {}, {:.2f} m, at ({:+.2f}, {:+.2f}) m, {:+.0f} deg",
                       std::min(course_.sides_done() + 1, sides), sides, course_.distance_m(), pose_.x_m, pose_.y_m,
                       pose_.yaw_rad * 180 / M_PI);
  }

  /// Returns what broke the connection: this program's own Ctrl-C, the container's end, or the problem itself.
  [[nodiscard]] Problem interrupted_or(Problem problem) const {
    if (stop_.is_raised()) return {"", "interrupted", ""};
    container_->wait_for_end(200ms);
    return problem;
  }

  void take_down(bool fine) {
    if (!container_) return;
    if (fine || client_) {
      // While it stops, Ctrl-C has nothing more to add.
      if (!client_ || !client_->send(control::FrameKind::Shutdown, "")) container_->interrupt();
    } else {
      container_->interrupt();
    }
    how_ended_ = container_->wait_for_end(kShutdownLimit);
    view_.clear();
  }

  int fail(const Problem& problem) {
    if (stop_.is_raised()) {
      std::fprintf(stderr, "nacelle: interrupted by %s; the robot was stopped and taken down (container %s)\n",
                   stop_.name(), how_ended_.c_str());
      return kInterrupted;
    }
    const bool failed = container_ && how_ended_ != "exited with 0";
    if (failed && !container_->complaints().empty()) {
      // The container has printed the cause, and the lost connection is a consequence. If verbose, its line stands above.
      if (!settings_.verbose) std::fputs(container_->complaints().c_str(), stderr);
      return 1;
    }
    std::fprintf(stderr, "nacelle: %s\n", problem.text().c_str());
    // It ended without a word of why: its steps are all there is to see.
    const std::string lines = failed ? container_->last_lines() : "";
    if (!lines.empty() && !settings_.verbose)
      std::fprintf(stderr, "The container (%s) said at last:\n%s", how_ended_.c_str(), lines.c_str());
    return 1;
  }

  /// Returns the container's report with what the drive adds; null if the container left none.
  [[nodiscard]] nlohmann::ordered_json figures() const {
    const auto written = read_regular_file(container_report());
    auto report = parse_json_or_discard<nlohmann::ordered_json>(written ? written.value() : "");
    if (!report.is_object()) return nullptr;
    report["seed"] = settings_.seed;
    if (driven_) report["drive"] = report::to_json(drive_figures(report));
    report.erase("last_messages");
    return report;
  }

  int finish(const nlohmann::ordered_json& report) {
    if (how_ended_ != "exited with 0" || !report.is_object()) {
      return fail({"container", how_ended_ + (report.is_object() ? "" : ", and left no report"), ""});
    }
    std::fputs(report::summary_of(report).c_str(), stdout);
    std::fflush(stdout);
    if (settings_.report_file.empty()) return 0;
    return write(settings_.report_file, report.dump(2) + "\n") ? 0 : 1;
  }

  /// Of a run that ended early, too: that is when one looks.
  [[nodiscard]] bool write_page(const nlohmann::ordered_json& report, const Result<void, Problem>& done) const {
    if (!recorder_) return true;
    auto page = recorder_->figures(report, settings_);
    if (!settings_.duration && !settings_.stay) page.distance_m = course_.distance_m();
    if (!done) page.failure = done.error().text();
    if (how_ended_ != "exited with 0")
      page.failure += (page.failure.empty() ? "" : "; ") + ("container: " + how_ended_);
    return write(settings_.html_file, run_page::page_of(page));
  }

  [[nodiscard]] static bool write(const std::string& file, const std::string& text) {
    const auto kept = write_whole_file(file, text);
    if (!kept) std::fprintf(stderr, "nacelle: the report: %s\n", kept.error().text().c_str());
    return kept.has_value();
  }

  [[nodiscard]] report::DriveFigures drive_figures(const nlohmann::ordered_json& report) const {
    constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();
    report::DriveFigures drive{course_.distance_m(), kUnknown, kUnknown};
    if (!final_.taken) return drive;
    const auto of_ekf = error_between(final_.ekf, final_.truth);
    drive.ekf_error_m = of_ekf.distance_m;
    drive.ekf_error_deg = of_ekf.yaw_deg;
    const nlohmann::ordered_json::json_pointer pose{"/pose/pose"};
    const auto messages = report.value("last_messages", nlohmann::ordered_json::object());
    const auto odometry = messages.find(settings_.odometry_topic);
    if (odometry != messages.end() && odometry->contains(pose / "position") &&
        odometry->contains(pose / "orientation")) {
      const auto number = [&](const char* part, const char* name) {
        return (*odometry)[pose][part].value(name, kUnknown);
      };
      const double yaw_rad = yaw_of({number("orientation", "x"), number("orientation", "y"), number("orientation", "z"),
                                     number("orientation", "w")});
      const auto of_odometry = error_between({number("position", "x"), number("position", "y"), yaw_rad}, final_.truth);
      drive.odometry_error_m = of_odometry.distance_m;
      drive.odometry_error_deg = of_odometry.yaw_deg;
    }
    return drive;
  }

  [[nodiscard]] std::string container_report() const { return folder_.path() + "/container.json"; }
  [[nodiscard]] std::string truth_file() const { return folder_.path() + "/truth"; }

  const DriveSettings& settings_;
  process::StopSignal& stop_;
  const Clock& clock_;
  RunFolder folder_;
  std::string name_;
  LiveView view_;
  SquareCourse course_;
  std::unique_ptr<ContainerProcess> container_;
  std::optional<control::Client> client_;
  std::optional<RunRecorder> recorder_;  // with --report-html, while the robot runs and after
  nlohmann::json stats_;
  std::string phase_, how_ended_;
  std::set<std::string> faults_told_;
  PlanarPose pose_;
  FinalPoses final_;
  bool driven_ = false;
};

}  // namespace

int run_drive(const DriveSettings& settings, process::StopSignal& stop, const Clock& clock) {
  return Run{settings, stop, clock}.run();
}

}  // namespace nacelle::drive
