// SPDX-License-Identifier: Apache-2.0
#include "record/component/play_component.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "record/component/report_row.hpp"
#include "record/model/bag_metadata.hpp"
#include "rosbag2_interfaces/srv/get_rate.hpp"
#include "rosbag2_interfaces/srv/is_paused.hpp"
#include "rosbag2_interfaces/srv/pause.hpp"
#include "rosbag2_interfaces/srv/play_next.hpp"
#include "rosbag2_interfaces/srv/resume.hpp"
#include "rosbag2_interfaces/srv/seek.hpp"
#include "rosbag2_interfaces/srv/set_rate.hpp"
#include "rosbag2_interfaces/srv/toggle_paused.hpp"

namespace nacelle::record {
namespace {

ParameterDescriptor read_only(std::string description) {
  return {std::move(description), "", true, false, std::nullopt, std::nullopt};
}
ParameterDescriptor bounded(std::string description, double from, double to) {
  return {std::move(description), "", true, false, std::nullopt, FloatingPointRange{from, to, 0}};
}

std::uint64_t nanoseconds(double seconds) { return static_cast<std::uint64_t>(seconds * 1e9); }

}  // namespace

PlayComponent::PlayComponent(const NodeOptions& options)
    : LifecycleNode("rosbag2_player", options), types_({msgs::TypeLibrary::own_folder()}) {
  declare_play();
  diagnostics_ = create_publisher<diagnostic_msgs::msg::DiagnosticArray>("/diagnostics", QoS(10));
  timer_ = create_wall_timer(1s, [this] { report(); });
  offer_services();
  if (!problem_) make_writers();
}

PlayComponent::~PlayComponent() = default;

void PlayComponent::note(Problem problem) {
  declare_problem(problem);
  if (!problem_) problem_ = std::move(problem);
}

void PlayComponent::declare_play() {
  path_ = declare_parameter("storage.uri", "", read_only("An MCAP file, or the folder of a recording."));
  if (path_.empty())
    note({Place::of_parameter("storage.uri"), "no recording is named",
          "name an MCAP file, or the folder of a recording"});
  TopicWish wish;
  wish.topics =
      declare_parameter<std::vector<std::string>>("play.topics", {}, read_only("Topics to play; empty: all."));
  wish.regex = declare_parameter("play.regex", "",
                                 read_only("And topics in which this regular expression (ECMAScript) is found."));
  wish.exclude_regex = declare_parameter("play.exclude_regex", "", read_only("But none in which this one is found."));
  wish.exclude_topics = declare_parameter<std::vector<std::string>>("play.exclude_topics", {}, read_only("Nor these."));
  for (auto* const names : {&wish.topics, &wish.exclude_topics}) {
    for (std::string& topic : *names) {
      if (!topic.starts_with('/')) topic.insert(0, 1, '/');
    }
  }
  named_ = wish.topics;
  wish.all = wish.topics.empty() && wish.regex.empty();
  wish.hidden = true;
  auto choice = TopicChoice::make(std::move(wish));
  if (choice) {
    choice_ = std::move(choice).value();
  } else {
    Problem problem = choice.error();
    problem.where = Place::of_parameter("play." + problem.where.text());
    note(std::move(problem));
  }
  options_.rate = declare_parameter<double>("play.rate", 1.0, bounded("How many times as fast.", 0.001, 1000.0));
  options_.loops = declare_parameter("play.loop", false, read_only("Begin again at the end."));
  options_.starts_paused =
      declare_parameter("play.start_paused", false, read_only("Wait for ~/resume or ~/play_next."));
  start_offset_s_ =
      declare_parameter<double>("play.start_offset", 0.0, bounded("Seconds of the recording to leave out.", 0.0, 1e9));
  duration_s_ = declare_parameter<double>("play.playback_duration", 0.0,
                                          bounded("Seconds of the recording to play; 0: to its end.", 0.0, 1e9));
  const double clock_hz = declare_parameter<double>(
      "play.clock_publish_frequency", 0.0,
      bounded("Hz with which the recording's time is published on /clock; 0: not at all.", 0.0, 1000.0));
  if (clock_hz <= 0.0) return;
  options_.clock_period = from_seconds(1.0 / clock_hz);
  clock_ = create_publisher<rosgraph_msgs::msg::Clock>("/clock", QoS(1).best_effort());
  options_.publish_clock = [this](WallTime time) {
    auto message = clock_->borrow();
    if (!message) return;
    message->clock.sec = static_cast<std::int32_t>(time.since_origin / 1s);
    message->clock.nanosec = static_cast<std::uint32_t>((time.since_origin % 1s).count());
    clock_->publish(std::move(message));
  };
}

void PlayComponent::offer_services() {
  namespace srv = rosbag2_interfaces::srv;
  services_.push_back(create_service<srv::Pause>(
      "~/pause", [this](const srv::Pause::Request&, srv::Pause::Response&) { player_->pause(true); }));
  services_.push_back(create_service<srv::Resume>(
      "~/resume", [this](const srv::Resume::Request&, srv::Resume::Response&) { player_->pause(false); }));
  services_.push_back(create_service<srv::TogglePaused>(
      "~/toggle_paused", [this](const srv::TogglePaused::Request&, srv::TogglePaused::Response&) {
        player_->pause(!player_->is_paused());
      }));
  services_.push_back(create_service<srv::IsPaused>(
      "~/is_paused", [this](const srv::IsPaused::Request&, srv::IsPaused::Response& response) {
        response.paused = player_->is_paused();
      }));
  services_.push_back(create_service<srv::GetRate>(
      "~/get_rate",
      [this](const srv::GetRate::Request&, srv::GetRate::Response& response) { response.rate = player_->rate(); }));
  services_.push_back(create_service<srv::SetRate>(
      "~/set_rate", [this](const srv::SetRate::Request& request, srv::SetRate::Response& response) {
        response.success = player_->set_rate(request.rate);
      }));
  services_.push_back(create_service<srv::PlayNext>(
      "~/play_next", [this](const srv::PlayNext::Request&, srv::PlayNext::Response& response) {
        response.success = player_->play_next();
      }));
  services_.push_back(
      create_service<srv::Seek>("~/seek", [this](const srv::Seek::Request& request, srv::Seek::Response& response) {
        const auto time = 1s * request.time.sec + Duration{request.time.nanosec};
        response.success = time >= Duration::zero() && player_->seek(static_cast<std::uint64_t>(time.count()));
      }));
}

CallbackReturn PlayComponent::on_configure(const State&) {
  return problem_ ? refuse(*problem_) : CallbackReturn::SUCCESS;
}

void PlayComponent::make_writers() {
  auto recording = OpenRecording::open(path_);
  if (!recording) return note(recording.error());
  recorded_ = recording->messages->topics();
  std::vector<std::string> names;
  for (const auto& topic : recorded_) names.push_back(topic.name);
  for (const std::string& topic : named_) {
    if (std::find(names.begin(), names.end(), topic) == names.end())
      note({Place::of_parameter("play.topics"), path_ + " has no topic " + topic, suggestion(topic, names)});
  }
  for (const auto& topic : recorded_) writers_.push_back(make_writer(topic, topics_.emplace_back()));
}

std::unique_ptr<Writer> PlayComponent::make_writer(const OrderedMessages::Topic& topic, Player::Topic& out) {
  if (!choice_->takes(topic.name)) return nullptr;
  const auto leave_out = [&](const std::string& why) {
    left_out_.push_back(topic.name);
    declare_warning({"topic " + topic.name, "is not played: " + why, ""});
    get_logger().warn("{} is not played: {}", topic.name, why);
    return nullptr;
  };
  if (topic.message_encoding != "cdr") return leave_out("its messages are " + topic.message_encoding + ", not CDR");
  const auto type = types_.message(topic.type);
  if (!type) return leave_out(type.error().text());
  const auto hash = topic.metadata.find("topic_type_hash");
  if (hash != topic.metadata.end() && !hash->second.empty() && hash->second != (*type)->hash)
    return leave_out("it was recorded with another definition of " + topic.type);
  const auto offered = topic.metadata.find("offered_qos_profiles");
  const QoS qos =
      strongest_qos(offered == topic.metadata.end() ? std::vector<QoS>{} : read_qos_profiles(offered->second));
  auto writer = GenericTopics{host(), get_fully_qualified_name()}.write(resolve_topic_name(topic.name), **type, qos);
  out = {*type, writer.get(), qos.resolved().durability() == Durability::TransientLocal};
  return writer;
}

CallbackReturn PlayComponent::on_activate(const State&) {
  auto recording = OpenRecording::open(path_);
  if (!recording) return refuse(recording.error());
  OrderedMessages& messages = *recording->messages;
  if (messages.topics() != recorded_)
    return refuse(Problem{Place{path_, 0}, "it has other topics than when this component was loaded", "load it anew"});
  Player::Options options = options_;
  options.from = messages.first() + nanoseconds(start_offset_s_);
  options.to = messages.last();
  if (duration_s_ > 0.0) options.to = std::min(options.to, options.from + nanoseconds(duration_s_));
  if (options.from > options.to)
    return refuse(Problem{
        Place::of_parameter("play.start_offset"),
        fmt::format("the recording has only {:.1f} s", static_cast<double>(messages.last() - messages.first()) * 1e-9),
        "begin earlier"});
  get_logger().info("playing {}: {} messages", path_, messages.messages());
  player_ = std::make_unique<Player>(std::move(*recording), topics_, std::move(options), steady_clock());
  return CallbackReturn::SUCCESS;
}

CallbackReturn PlayComponent::on_deactivate(const State&) {
  player_.reset();
  return CallbackReturn::SUCCESS;
}

CallbackReturn PlayComponent::on_error(const State&) {
  player_.reset();
  return CallbackReturn::SUCCESS;
}

void PlayComponent::report() {
  auto message = diagnostics_->borrow();
  if (!message) return;
  const PlayerFigures figures = player_->figures();
  ReportRow row{*message, now(), get_name() + ": playing"};
  row.say(figures.undecoded > 0 || !left_out_.empty() ? ReportRow::Level::Warning : ReportRow::Level::Ok,
          figures.has_ended      ? "ended"
          : player_->is_paused() ? "paused"
                                 : "playing");
  row.add("seconds", fmt::format("{:.1f}", figures.seconds));
  row.add("messages", std::to_string(figures.messages));
  row.add("without a reader", std::to_string(figures.unread));
  row.add("not decoded", std::to_string(figures.undecoded));
  for (const std::string& topic : left_out_) row.add("not played", topic);
  diagnostics_->publish(std::move(message));
}

}  // namespace nacelle::record
