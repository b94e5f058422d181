// SPDX-License-Identifier: Apache-2.0
#include "record/component/record_component.hpp"

#include <fmt/format.h>

#include <cstdint>
#include <ctime>
#include <utility>

#include "record/component/report_row.hpp"

namespace nacelle::record {
namespace {

constexpr const char* kEnded = "RECORDING_ENDED";
constexpr const char* kSnapshotFailed = "SNAPSHOT_FAILED";

ParameterDescriptor fixed(std::string description) {
  return {std::move(description), "", true, false, std::nullopt, std::nullopt};
}
ParameterDescriptor counted(std::string description, std::int64_t from, std::int64_t to) {
  return {std::move(description), "", true, false, IntegerRange{from, to, 0}, std::nullopt};
}

/// The pattern's %Y, %m, ... are replaced as in date(1), in the machine's time zone. Empty: rosbag2's name.
std::string folder_of(const std::string& pattern, WallTime now) {
  std::string given = pattern.empty() ? "rosbag2_%Y_%m_%d-%H_%M_%S" : pattern;
  if (given.find('%') == std::string::npos) return given;
  const auto seconds = static_cast<std::time_t>(now.since_origin / 1s);
  std::tm parts{};
  ::localtime_r(&seconds, &parts);
  std::string text(given.size() + 256, '\0');
  text.resize(std::strftime(text.data(), text.size(), given.c_str(), &parts));
  return text;
}

double megabytes(std::uint64_t bytes) { return static_cast<double>(bytes) / kMegabyte; }

}  // namespace

RecordComponent::RecordComponent(const NodeOptions& options)
    : LifecycleNode("rosbag2_recorder", options),
      facts_(shared_object<ContainerFacts>(kContainerFactsName, &make_container_facts)),
      network_facts_(shared_object<NetworkFacts>(kNetworkFactsName, &make_network_facts)) {
  auto choice = TopicChoice::make(declare_topics());
  if (choice) {
    choice_ = std::move(choice).value();
    if (!choice_->is_any())
      note({Place::of_parameter("record.topics"), "no topic is chosen",
            "set record.all_topics, record.topics or record.regex"});
  } else {
    Problem problem = choice.error();
    problem.where = Place::of_parameter("record." + problem.where.text());
    note(problem);
  }
  declare_storage();
  split_events_ = create_publisher<rosbag2_interfaces::msg::WriteSplitEvent>("events/write_split", QoS(1));
  diagnostics_ = create_publisher<diagnostic_msgs::msg::DiagnosticArray>("/diagnostics", QoS(10));
  timer_ = create_wall_timer(1s, [this] { report(); });
  remote_timer_ = create_wall_timer(250ms, [this] {
    if (remote_) remote_->look();
  });
  offer_services();
}

RecordComponent::~RecordComponent() { stop(); }

TopicWish RecordComponent::declare_topics() {
  TopicWish wish;
  wish.all = declare_parameter("record.all_topics", false, fixed("Record every topic of the container."));
  wish.topics = declare_parameter<std::vector<std::string>>("record.topics", {}, fixed("Topics to record."));
  for (std::string& topic : wish.topics) topic = resolve_topic_name(topic);
  wish.regex = declare_parameter("record.regex", "",
                                 fixed("And topics in which this regular expression (ECMAScript) is found."));
  wish.exclude_regex = declare_parameter("record.exclude_regex", "", fixed("But none in which this one is found."));
  wish.exclude_topics = declare_parameter<std::vector<std::string>>("record.exclude_topics", {}, fixed("Nor these."));
  for (std::string& topic : wish.exclude_topics) topic = resolve_topic_name(topic);
  wish.hidden = declare_parameter("record.include_hidden_topics", false,
                                  fixed("Of all topics, take those with a part that begins with '_', too."));
  takes_all_remote_ = declare_parameter(
      "record.all_remote_topics", false,
      fixed("With record.all_topics, also every topic that only other programs on the network publish. Those that "
            "record.topics names or record.regex finds are recorded anyway."));
  starts_paused_ = declare_parameter("record.start_paused", false, fixed("Wait for ~/resume."));
  return wish;
}

void RecordComponent::declare_storage() {
  storage_.folder = declare_parameter(
      "storage.uri", "",
      fixed("The folder to make; %Y, %m, %d, %H, %M and %S stand for its time. Empty: rosbag2_%Y_%m_%d-%H_%M_%S."));
  const auto id = declare_parameter("storage.storage_id", "mcap", fixed("The format: mcap."));
  if (id != "mcap") {
    note({Place::of_parameter("storage.storage_id"), "'" + id + "' is not a format that is written", "set mcap"});
  }
  const auto compression = declare_parameter("storage.compression", "none", fixed("Of chunks: none, lz4 or zstd."));
  const auto known = compression_of(compression == "none" ? "" : compression);
  if (known && !compression.empty()) {
    storage_.compression = *known;
  } else {
    note({Place::of_parameter("storage.compression"), "'" + compression + "' is not a compression",
          suggestion(compression, {"none", "lz4", "zstd"})});
  }
  storage_.max_file_bytes = static_cast<std::uint64_t>(declare_parameter<std::int64_t>(
      "storage.max_bagfile_size", 0, counted("Bytes after which another file begins; 0: never.", 0, INT64_MAX)));
  storage_.max_file_duration =
      1s *
      declare_parameter<std::int64_t>("storage.max_bagfile_duration", 0,
                                      counted("Seconds after which another file begins; 0: never.", 0, 1'000'000'000));
  storage_.keep_free =
      kMegabyte *
      static_cast<std::uint64_t>(declare_parameter<std::int64_t>(
          "storage.keep_free", 64, counted("Megabytes of the file system that are left to others.", 1, 1'000'000'000)));
  storage_.most_waiting =
      kMegabyte * static_cast<std::uint64_t>(declare_parameter<std::int64_t>(
                      "storage.max_cache_size", 32, counted("Megabytes that may wait for the disk.", 4, 4096)));
  storage_.repeats_latched = declare_parameter(
      "record.repeat_all_transient_local", true,
      fixed("Begin each further file with what transient_local publishers keep (/tf_static, /robot_description)."));
  ring_.longest = 1s * declare_parameter<std::int64_t>(
                           "storage.ring", 0,
                           counted("Keep the last so many seconds in memory, for ~/snapshot; 0: write all to the disk.",
                                   0, 86'400));
  ring_.most_bytes = static_cast<std::uint64_t>(declare_parameter<std::int64_t>(
      "storage.ring_size", 64 * kMegabyte,
      counted("Bytes of memory (/dev/shm) that storage.ring may take.", 1'000'000, 1'000'000'000'000)));
  ring_.compression = storage_.compression;
  ring_.name = ring_name(facts_->name, get_fully_qualified_name());
}

void RecordComponent::offer_services() {
  namespace srv = rosbag2_interfaces::srv;
  services_.push_back(create_service<srv::Pause>("~/pause", [this](const srv::Pause::Request&, srv::Pause::Response&) {
    if (recorder_) recorder_->pause(true);
  }));
  services_.push_back(
      create_service<srv::Resume>("~/resume", [this](const srv::Resume::Request&, srv::Resume::Response&) {
        if (recorder_) recorder_->pause(false);
      }));
  services_.push_back(create_service<srv::TogglePaused>(
      "~/toggle_paused", [this](const srv::TogglePaused::Request&, srv::TogglePaused::Response&) {
        if (recorder_) recorder_->pause(!recorder_->is_paused());
      }));
  services_.push_back(create_service<srv::IsPaused>(
      "~/is_paused", [this](const srv::IsPaused::Request&, srv::IsPaused::Response& response) {
        response.paused = recorder_ && recorder_->is_paused();
      }));
  services_.push_back(create_service<srv::SplitBagfile>(
      "~/split_bagfile", [this](const srv::SplitBagfile::Request&, srv::SplitBagfile::Response&) {
        if (recorder_) recorder_->split();
      }));
  offer_snapshot();
}

/// Answers when the snapshot is written, or cannot be.
void RecordComponent::offer_snapshot() {
  using rosbag2_interfaces::srv::Snapshot;
  snapshots_ = create_service<Snapshot>("~/snapshot", [this](const RequestId& request, const Snapshot::Request&) {
    const auto answer = [service = std::weak_ptr{snapshots_}, request](bool success) {
      Snapshot::Response response;
      response.success = success;
      if (const auto open = service.lock()) open->send_response(request, response);
    };
    if (!recorder_ || open_ring_ == nullptr ||
        !recorder_->post([this, answer] { black_box_->snapshot(*open_ring_, "asked for", answer); }))
      answer(false);
  });
}

void RecordComponent::note(Problem problem) {
  declare_problem(problem);
  if (!problem_) problem_ = std::move(problem);
}

CallbackReturn RecordComponent::on_configure(const State&) {
  return problem_ ? refuse(*problem_) : CallbackReturn::SUCCESS;
}

std::string RecordComponent::next_folder() const { return folder_of(storage_.folder, SystemClock{}.wall_now()); }

Result<std::unique_ptr<MessageLog>, Problem> RecordComponent::begin() {
  RecordingOptions storage = storage_;
  storage.folder = next_folder();
  auto recording = Recording::begin(std::move(storage));
  if (!recording) return err(recording.error());
  get_logger().info("recording into {}", (*recording)->folder());
  return std::unique_ptr<MessageLog>{std::move(*recording)};
}

Result<std::unique_ptr<MessageLog>, Problem> RecordComponent::begin_ring() {
  black_box_ = std::make_unique<BlackBox>(
      BlackBox::Options{[this] { return next_folder(); }, storage_.compression, storage_.keep_free,
                        [this](const std::string& reason, const auto& result) { on_snapshot(reason, result); }},
      facts_);
  RingOptions options = ring_;
  for (auto& left : RingFolder::left_behind(options.base, options.name)) {
    options.soon_free += left->bytes();
    get_logger().warn("a killed process left a ring, which is written now: {}", left->path());
    black_box_->recover(std::move(left));
  }
  auto ring = Ring::begin(std::move(options));
  if (!ring) return err(ring.error());
  if ((*ring)->most_bytes() < ring_.most_bytes)
    get_logger().warn("the ring takes {:.1f} MB, half of what /dev/shm has free", megabytes((*ring)->most_bytes()));
  open_ring_ = ring->get();
  return std::unique_ptr<MessageLog>{std::move(*ring)};
}

Recorder::Options RecordComponent::recorder_options() {
  Recorder::Options options{*choice_, starts_paused_};
  options.on_split = [this](const std::string& closed, const std::string& opened) {
    auto event = split_events_->borrow();
    if (!event) return;
    event->closed_file = closed;
    event->opened_file = opened;
    split_events_->publish(std::move(event));
  };
  if (open_ring_ == nullptr) return options;
  options.on_round = [this](MonotonicTime now) { black_box_->look_at(*open_ring_, now); };
  options.on_stop = [this](const std::string& topic) { black_box_->on_stop(topic); };
  return options;
}

CallbackReturn RecordComponent::on_activate(const State&) {
  const bool is_ring = ring_.longest > Duration::zero();
  auto log = is_ring ? begin_ring() : begin();
  if (!log && !is_ring) return refuse(log.error());
  const auto end = [this](const Problem& problem) {
    get_logger().error("the recording has ended: {}", problem.text());
    open_fault(kEnded, problem.text());
  };
  if (!log) {  // a robot without a black box goes on
    no_log_ = log.error();
    end(*no_log_);
    return CallbackReturn::SUCCESS;
  }
  for (const RunText& text : facts_->run_texts())
    (*log)->attach(text, static_cast<std::uint64_t>(SystemClock{}.wall_now().nanoseconds()));
  recorder_ = std::make_unique<Recorder>(GenericTopics{host(), get_fully_qualified_name()}, recorder_options(),
                                         std::move(*log), end);
  look_for_remote_topics();
  return CallbackReturn::SUCCESS;
}

void RecordComponent::look_for_remote_topics() {
  RemoteTopics::Options options;
  options.takes = [this](const std::string& topic) {
    return takes_all_remote_ ? choice_->takes(topic) : choice_->picks(topic);
  };
  options.add = [this](const std::string& topic, const msgs::MessageType& type, const std::vector<QoS>& offered) {
    recorder_->add_remote(topic, type, offered);
  };
  remote_ = std::make_unique<RemoteTopics>(*this, steady_clock(), network_facts_, std::move(options));
  remote_->look();
}

void RecordComponent::on_snapshot(const std::string& reason, const Result<Snapshot, Problem>& result) {
  if (!result) {
    get_logger().error("the snapshot ({}) is not written: {}", reason, result.error().text());
    return open_fault(kSnapshotFailed, result.error().text());
  }
  get_logger().info("snapshot ({}): {} messages ({:.1f} MB) in {}", reason, result->messages, megabytes(result->bytes),
                    result->folder);
  if (result->problems > 0) get_logger().warn("{} records of the ring could not be read", result->problems);
  close_fault(kSnapshotFailed);
}

CallbackReturn RecordComponent::on_deactivate(const State&) {
  stop();
  return CallbackReturn::SUCCESS;
}

CallbackReturn RecordComponent::on_error(const State&) {
  stop();
  return CallbackReturn::SUCCESS;
}

void RecordComponent::stop() {
  close_fault(kEnded);
  no_log_.reset();
  remote_.reset();
  if (!recorder_) return black_box_.reset();
  const auto problem = recorder_->stop();
  if (open_ring_ != nullptr) black_box_->finish(*open_ring_);
  const RecorderFigures figures = recorder_->figures();
  if (problem) get_logger().error("the recording is not complete: {}", problem->text());
  if (open_ring_ == nullptr)
    get_logger().info("recorded {} messages ({:.1f} MB) into {}", figures.messages, megabytes(figures.bytes),
                      figures.folder);
  if (figures.copies > 0)
    get_logger().info("recording copied {} images ({:.1f} MB)", figures.copies, megabytes(figures.bytes_copied));
  for (const std::string& topic : figures.absent) get_logger().warn("{} was never published", topic);
  for (const auto& topic : figures.topics) {
    if (topic.lost_in_queue > 0) get_logger().warn("lost in queue: {} messages of {}", topic.lost_in_queue, topic.name);
    if (topic.lost_to_disk > 0) get_logger().warn("lost to disk: {} messages of {}", topic.lost_to_disk, topic.name);
  }
  recorder_.reset();
  open_ring_ = nullptr;
  black_box_.reset();  // writes what is asked for
  close_fault(kSnapshotFailed);
}

void RecordComponent::report() {
  auto message = diagnostics_->borrow();
  if (!message) return;
  RecorderFigures figures;
  if (recorder_) figures = recorder_->figures();
  if (no_log_) figures.problem = no_log_;
  ReportRow row{*message, now(), get_name() + ": recording"};
  if (figures.problem) {
    row.say(ReportRow::Level::Error, figures.problem->text());
  } else if (recorder_ && recorder_->is_paused()) {
    row.say(ReportRow::Level::Ok, "paused");
  } else if (figures.lost > 0) {
    row.say(ReportRow::Level::Warning, fmt::format("{} messages were lost", figures.lost));
  } else {
    row.say(ReportRow::Level::Ok, "recording");
  }
  row.add("folder", figures.folder);
  row.add("file", figures.file);
  row.add("files", std::to_string(figures.files));
  row.add("seconds", fmt::format("{:.1f}", to_seconds(figures.recorded)));
  row.add("bytes", std::to_string(figures.bytes));
  row.add("messages", std::to_string(figures.messages));
  row.add("topics", std::to_string(figures.topics.size()));
  row.add("lost", std::to_string(figures.lost));
  row.add("camera copies", std::to_string(figures.copies));
  row.add("camera bytes copied", std::to_string(figures.bytes_copied));
  if (black_box_) {
    const BlackBox::Figures box = black_box_->figures();
    row.add("ring seconds", fmt::format("{:.1f}", to_seconds(figures.reach.value_or(Duration::zero()))));
    row.add("snapshots", std::to_string(box.snapshots));
    row.add("snapshot", box.last);
    row.add("snapshot problem", box.problem ? box.problem->text() : "");
  }
  for (const auto& topic : figures.topics) {
    if (topic.lost_in_queue > 0) row.add("lost in queue: " + topic.name, std::to_string(topic.lost_in_queue));
    if (topic.lost_to_disk > 0) row.add("lost to disk: " + topic.name, std::to_string(topic.lost_to_disk));
  }
  for (const std::string& topic : figures.absent) row.add("never published: " + topic, "");
  diagnostics_->publish(std::move(message));
}

}  // namespace nacelle::record
