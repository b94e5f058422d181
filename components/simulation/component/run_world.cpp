// SPDX-License-Identifier: Apache-2.0
#include "simulation/component/run_world.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <sched.h>
#include <sys/file.h>
#include <sys/prctl.h>
#include <sys/stat.h>
#include <sys/timerfd.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <memory>
#include <vector>

#include "nacelle/io/descriptor.hpp"
#include "nacelle/io/pty_pair.hpp"
#include "simulation/component/end_signals.hpp"
#include "simulation/model/world_model.hpp"
#include "simulation/port/truth_file.hpp"

namespace nacelle::simulation {
namespace {

// A machine that stood still for longer than this (suspended, stopped in a debugger) is not caught up with: the robot
// would jump. The world's clock jumps instead.
constexpr Duration kLongestCatchUp = 1s;
// Missed time is made up for at this multiple of the world's pace. A line holds 4 KB, a quarter of a second of the LiDAR: more would not
// fit at once, and its reader, at normal priority, needs time to empty it.
constexpr std::uint64_t kCatchUpPace = 4;
// The most ticks that one wake-up counts as. More are a pause; fewer are a busy machine.
constexpr std::uint64_t kTicksAtATime = 5;

/// A file that exists while this object does.
class Marker {
 public:
  explicit Marker(std::string path) : path_(std::move(path)) {}
  Marker(const Marker&) = delete;
  Marker& operator=(const Marker&) = delete;
  ~Marker() { ::unlink(path_.c_str()); }
  [[nodiscard]] bool write(const std::string& text) const {
    const std::string fresh = path_ + ".new";
    const io::Descriptor file{::open(fresh.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644)};
    return file.is_open() && ::write(file.number(), text.data(), text.size()) == static_cast<ssize_t>(text.size()) &&
           ::rename(fresh.c_str(), path_.c_str()) == 0;
  }

 private:
  std::string path_;
};

struct Lines {
  std::array<std::unique_ptr<io::PtyPair>, kDevices.size()> ptys;
  /// Null while the cable is pulled.
  [[nodiscard]] io::PtyPair* operator[](Device device) { return ptys[static_cast<std::size_t>(device)].get(); }
  [[nodiscard]] int device_end(Device device) {
    return (*this)[device] != nullptr ? (*this)[device]->device_end() : -1;
  }
};

Result<std::unique_ptr<io::PtyPair>, Problem> open_line(const std::string& directory, Device device) {
  auto pty = io::PtyPair::create();
  if (!pty) return pty;
  auto linked = pty.value()->link_as(fmt::format("{}/{}", directory, name_of(device)));
  if (!linked) return err(linked.error());
  return pty;
}

Result<Lines, Problem> open_lines(const std::string& directory) {
  Lines lines;
  for (const Device device : kDevices) {
    auto pty = open_line(directory, device);
    if (!pty) return err(std::move(pty).error());
    lines.ptys[static_cast<std::size_t>(device)] = std::move(pty).value();
  }
  return lines;
}

/// A fifo in which others write "unplug base" or "plug base", a line each.
class Control {
 public:
  explicit Control(std::string path) : path_(std::move(path)) {
    ::unlink(path_.c_str());
    // Both ways, so that a writer which leaves is no end of file.
    if (::mkfifo(path_.c_str(), 0600) == 0)
      fifo_ = io::Descriptor{::open(path_.c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC)};
  }
  Control(const Control&) = delete;
  Control& operator=(const Control&) = delete;
  ~Control() { ::unlink(path_.c_str()); }
  [[nodiscard]] int descriptor() const { return fifo_.number(); }

  /// Calls `each(line)` for each line received. A line that is too long is dropped.
  template <typename Each>
  void read(Each&& each) {
    std::array<char, 256> bytes{};
    ssize_t count = 0;
    while ((count = ::read(fifo_.number(), bytes.data(), bytes.size())) > 0) {
      for (const char c : std::string_view{bytes.data(), static_cast<std::size_t>(count)}) {
        if (c == '\n') {
          each(std::string_view{line_});
          line_.clear();
        } else if (line_.size() < bytes.size()) {
          line_.push_back(c);
        }
      }
    }
  }

 private:
  std::string path_;
  std::string line_;
  io::Descriptor fifo_;
};

io::Descriptor start_ticks() {
  io::Descriptor timer{::timerfd_create(CLOCK_MONOTONIC, TFD_NONBLOCK | TFD_CLOEXEC)};
  itimerspec ticks{};
  ticks.it_value.tv_nsec = ticks.it_interval.tv_nsec = WorldModel::kStep.count();
  if (timer.is_open()) ::timerfd_settime(timer.number(), 0, &ticks, nullptr);
  return timer;
}

constexpr std::size_t kTicks = 0, kSignals = 1, kStop = 2, kControl = 3,
                      kFirstLine = 4;  // the polled descriptors, in this order

/// The world between its lines and the clock.
class Runner {
 public:
  Runner(const WorldOptions& options, const Clock& clock, Lines lines, TruthFile& truth)
      : clock_(clock),
        directory_(options.directory),
        lines_(std::move(lines)),
        truth_file_(truth),
        world_(options.settings),
        origin_(clock.now()) {
    truth_.seed = options.settings.seed;
    write_truth();
  }

  void read_lines(const std::array<pollfd, kFirstLine + kDevices.size()>& watched) {
    for (const Device device : kDevices) {
      io::PtyPair* const line = lines_[device];
      if (line == nullptr || (watched[kFirstLine + static_cast<std::size_t>(device)].revents & POLLIN) == 0) continue;
      // A few chunks only: a host that writes without end must not stop the world.
      for (int chunk = 0; chunk < 4; ++chunk) {
        const auto bytes = line->read();
        if (!bytes || bytes->empty()) break;
        count(device).received_bytes += bytes->size();
        const auto before = world_.board().motion_commands();
        world_.receive(device, *bytes);
        if (world_.board().motion_commands() != before) truth_.last_motion_command_ns = clock_.now().nanoseconds();
        note_aim();
      }
    }
  }

  /// "unplug base", "plug base"; anything else is nothing.
  void obey(std::string_view command) {
    for (const Device device : kDevices) {
      auto& line = lines_.ptys[static_cast<std::size_t>(device)];
      if (command == fmt::format("unplug {}", name_of(device))) line.reset();
      if (command != fmt::format("plug {}", name_of(device)) || line) continue;
      if (auto fresh = open_line(directory_, device)) line = std::move(fresh).value();
    }
  }

  /// Makes the steps that are due, as far as the catch-up pace allows. `ticks`: of the timer, since the last call.
  void catch_up(std::uint64_t ticks) {
    const Duration due = clock_.now() - origin_;
    if (due - world_.now() > kLongestCatchUp) {
      const auto skipped = (due - world_.now()) / WorldModel::kStep;
      report_.skipped_steps += static_cast<std::uint64_t>(skipped);
      origin_ += skipped * WorldModel::kStep;
    }
    const std::uint64_t most = kCatchUpPace * std::min(ticks, kTicksAtATime);
    std::uint64_t steps = 0;
    for (; steps < most && world_.now() + WorldModel::kStep <= clock_.now() - origin_; ++steps) {
      world_.step([this](Device device, ByteView bytes) {
        const std::size_t taken = lines_[device] != nullptr ? lines_[device]->write_some(bytes) : 0;
        count(device).sent_bytes += taken;
        count(device).dropped_bytes += bytes.size() - taken;
      });
      note_aim();
    }
    if (steps > 1) report_.late_steps += steps - 1;
    if (steps > 0) write_truth();
  }

  [[nodiscard]] std::array<pollfd, kFirstLine + kDevices.size()> watched(int ticks, int signals, int stop,
                                                                         int control) {
    return {pollfd{ticks, POLLIN, 0},
            pollfd{signals, POLLIN, 0},
            pollfd{stop, POLLIN, 0},
            pollfd{control, POLLIN, 0},
            pollfd{lines_.device_end(Device::Lidar), POLLIN, 0},
            pollfd{lines_.device_end(Device::Imu), POLLIN, 0},
            pollfd{lines_.device_end(Device::Base), POLLIN, 0},
            pollfd{lines_.device_end(Device::Gps), POLLIN, 0}};
  }

  [[nodiscard]] WorldReport report() const {
    WorldReport report = report_;
    report.seconds = to_seconds(world_.now());
    return report;
  }

 private:
  [[nodiscard]] WorldReport::Line& count(Device device) { return report_.lines[static_cast<std::size_t>(device)]; }

  /// Records when the board's aim leaves zero, or returns to it.
  void note_aim() {
    const MotorBoard& board = world_.board();
    const bool turns = board.left_command_mps() != 0.0 || board.right_command_mps() != 0.0;
    if (turns == turns_) return;
    turns_ = turns;
    ++(turns ? truth_.starts : truth_.stops);
    (turns ? truth_.last_start_ns : truth_.last_stop_ns) = clock_.now().nanoseconds();
  }

  void write_truth() {
    const DriveModel& drive = world_.drive();
    truth_.time_s = to_seconds(world_.now());
    truth_.x_m = drive.pose().x_m;
    truth_.y_m = drive.pose().y_m;
    truth_.yaw_rad = drive.pose().yaw_rad;
    truth_.speed_mps = drive.speed_mps();
    truth_.yaw_rate_rps = drive.yaw_rate_rps();
    truth_.left_command_mps = world_.board().left_command_mps();
    truth_.right_command_mps = world_.board().right_command_mps();
    truth_.motion_commands = world_.board().motion_commands();
    truth_.watchdog_stops = world_.board().watchdog_stops();
    truth_.contacts = drive.contacts();
    truth_file_.write(truth_);
  }

  const Clock& clock_;
  const std::string directory_;
  Lines lines_;
  TruthFile& truth_file_;
  Truth truth_;
  WorldModel world_;
  MonotonicTime origin_;
  WorldReport report_;
  bool turns_ = false;
};

}  // namespace

Result<void, Problem> plug_device(const std::string& directory, const std::string& device, bool in) {
  std::vector<std::string> names;
  for (const Device known : kDevices) names.emplace_back(name_of(known));
  if (std::find(names.begin(), names.end(), device) == names.end())
    return err(
        Problem{"device '" + device + "'", "the simulated robot has none of that name", suggestion(device, names)});
  const std::string path = directory + "/control";
  const io::Descriptor fifo{::open(path.c_str(), O_WRONLY | O_NONBLOCK | O_CLOEXEC)};
  const std::string line = (in ? "plug " : "unplug ") + device + "\n";
  // A line is shorter than PIPE_BUF: it arrives whole or not at all.
  if (!fifo.is_open() || ::write(fifo.number(), line.data(), line.size()) != static_cast<ssize_t>(line.size())) {
    return err(Problem{path, fmt::format("no world listens ({})", std::strerror(errno)),
                       "start one with `nacelle sim world`, or name its folder with --dir"});
  }
  return {};
}

Result<WorldReport, Problem> run_world(const WorldOptions& options, const Clock& clock) {
  const EndSignals signals;  // first: a signal from now on ends the world in order
  if (options.end_with_parent) {
    ::prctl(PR_SET_PDEATHSIG, SIGTERM);
    if (options.parent_pid != 0 && ::getppid() != options.parent_pid) return WorldReport{};
  }
  std::error_code made;
  std::filesystem::create_directories(options.directory, made);
  const io::Descriptor directory{::open(options.directory.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC)};
  if (!directory.is_open()) {
    return err(Problem{options.directory, fmt::format("cannot be used ({})", std::strerror(errno)),
                       "choose another folder: sim_dir:=FOLDER of a launch file, --dir FOLDER of `nacelle sim world`"});
  }
  if (::flock(directory.number(), LOCK_EX | LOCK_NB) != 0) {
    return err(Problem{
        options.directory, "another world runs here",
        "end it, or choose another folder: sim_dir:=FOLDER of a launch file, --dir FOLDER of `nacelle sim world`"});
  }
  const std::string ready_path = options.directory + "/ready";
  ::unlink(ready_path.c_str());  // of a world that was killed
  auto truth = TruthFile::create(options.directory + "/truth");
  if (!truth) return err(std::move(truth).error());
  auto lines = open_lines(options.directory);
  if (!lines) return err(std::move(lines).error());
  Control control{options.directory + "/control"};
  const io::Descriptor ticks = start_ticks();
  Runner runner{options, clock, std::move(lines).value(), *truth.value()};
  const Marker ready{ready_path};  // after the runner: it is the first to go
  if (!ready.write(fmt::format("{}\n", ::getpid()))) {
    return err(Problem{ready_path, "cannot be written", "is the directory writable?"});
  }

  // Real devices do not wait for the processors of this machine. Where the limits allow it (RLIMIT_RTPRIO), the world does not either.
  const sched_param lowest{::sched_get_priority_min(SCHED_FIFO)};
  static_cast<void>(::sched_setscheduler(0, SCHED_FIFO | SCHED_RESET_ON_FORK, &lowest));
  for (;;) {
    auto watched = runner.watched(ticks.number(), signals.descriptor(), options.stop_descriptor, control.descriptor());
    if (::poll(watched.data(), watched.size(), -1) < 0 && errno != EINTR) {
      return err(Problem{"simulated world", fmt::format("poll failed ({})", std::strerror(errno)), ""});
    }
    if ((watched[kStop].revents & (POLLIN | POLLHUP)) != 0) return runner.report();
    if ((watched[kSignals].revents & POLLIN) != 0 && signals.ask_to_end(!options.end_with_parent))
      return runner.report();
    std::uint64_t passed = 0;
    if ((watched[kTicks].revents & POLLIN) != 0 && ::read(ticks.number(), &passed, sizeof passed) < 0) passed = 0;
    runner.read_lines(watched);
    if ((watched[kControl].revents & POLLIN) != 0)
      control.read([&](std::string_view command) { runner.obey(command); });
    runner.catch_up(passed);
  }
}

}  // namespace nacelle::simulation
