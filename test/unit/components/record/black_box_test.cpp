// SPDX-License-Identifier: Apache-2.0
// The recorder with a ring in a container: what makes it write a snapshot.
#include <sys/wait.h>
#include <unistd.h>

#include <diagnostic_msgs/msg/diagnostic_array.hpp>
#include <map>
#include <std_msgs/msg/bool.hpp>
#include <std_msgs/msg/string.hpp>

#include "nacelle/base/names.hpp"
#include "nacelle/runtime/test_container.hpp"
#include "record/component/ring.hpp"
#include "record/model/recording_summary.hpp"
#include "record/port/recording_file.hpp"
#include "temporary_folder.hpp"

namespace nacelle::record {
namespace {

using diagnostic_msgs::msg::DiagnosticArray;
using std_msgs::msg::Bool;
using std_msgs::msg::String;

class BlackBoxTest : public TemporaryFolder {
 protected:
  runtime::ComponentInfo start() {
    return container_.start("nacelle::record::RecordComponent", {{"record.topics", std::vector<std::string>{"/a"}},
                                                                 {"storage.uri", path("bag")},
                                                                 {"storage.keep_free", std::int64_t{1}},
                                                                 {"storage.ring", std::int64_t{60}},
                                                                 {"storage.ring_size", std::int64_t{1'000'000}}});
  }
  /// Returns the values of the next report; one comes each second.
  std::map<std::string, std::string> values() {
    const auto report = reports_.next();
    std::map<std::string, std::string> all;
    for (const auto& one : report.status.front().values) all[one.key] = one.value;
    return all;
  }
  std::string value(const std::string& key) { return values().at(key); }
  /// Returns the last snapshot's folder as soon as there are so many.
  std::string wait_for_snapshots(const std::string& count) {
    auto all = values();
    for (int left = 30; left > 0 && all.at("snapshots") != count; --left) all = values();
    EXPECT_EQ(all.at("snapshots"), count);
    return all.at("snapshot");
  }
  /// The number of messages of each topic, and why it was written.
  std::map<std::string, std::uint64_t> recorded(const std::string& folder, std::string& reason) {
    auto source = FileSource::open(folder + "/" + std::filesystem::path{folder}.filename().string() + "_0.mcap");
    RecordingSummary summary;
    EXPECT_TRUE(source && walk_mcap(**source, summary)) << folder;
    std::map<std::string, std::uint64_t> all;
    for (const auto& [id, topic] : summary.topics()) all[topic.name] += topic.messages;
    const auto found = summary.metadata().find("nacelle.snapshot");
    if (found != summary.metadata().end()) reason = found->second.at("reason");
    return all;
  }
  static String words(const std::string& text) {
    String message;
    message.data = text;
    return message;
  }
  static Bool stop(bool is_set) {
    Bool message;
    message.data = is_set;
    return message;
  }

  runtime::TestContainer container_;
  runtime::TestSubscription<DiagnosticArray> reports_ = container_.subscribe<DiagnosticArray>("/diagnostics", QoS(100));
};

TEST_F(BlackBoxTest, writes_nothing_until_a_fault) {
  auto a = container_.advertise<String>("/a", QoS(10));
  start();
  a.publish(words("before"));
  EXPECT_EQ(value("snapshots"), "0");
  EXPECT_FALSE(std::filesystem::exists(path("bag")));
  runtime::FaultEvent fault{.node = "/other", .code = "SERIAL_LOST", .text = "unplugged"};
  fault.is_open_fault = true;
  container_.container().tell_open_fault(fault);
  std::string reason;
  EXPECT_EQ(wait_for_snapshots("1"), path("bag"));
  EXPECT_EQ(recorded(path("bag"), reason), (std::map<std::string, std::uint64_t>{{"/a", 1}}));
  EXPECT_EQ(reason, "fault 1");
}

TEST_F(BlackBoxTest, writes_what_a_fault_wants_before_it_ends) {
  auto a = container_.advertise<String>("/a", QoS(10));
  const auto recorder = start();
  a.publish(words("before"));
  runtime::FaultEvent fault{.node = "/other", .code = "SERIAL_LOST", .text = "unplugged"};
  fault.is_open_fault = true;
  container_.container().tell_open_fault(fault);
  EXPECT_EQ(container_.container().trigger(recorder.id, Transition::Deactivate).reason, "");
  std::string reason;
  EXPECT_EQ(recorded(path("bag"), reason).at("/a"), 1U);
}

TEST_F(BlackBoxTest, writes_after_an_emergency_stop_that_a_component_reads) {
  auto base = container_.subscribe<Bool>("/robot/emergency_stop", QoS(1).transient_local());
  auto button = container_.advertise<Bool>("/robot/emergency_stop", QoS(1).transient_local());
  auto a = container_.advertise<String>("/a", QoS(10));
  button.publish(stop(true));  // before it began
  start();
  a.publish(words("before"));
  EXPECT_EQ(value("snapshots"), "0");
  EXPECT_EQ(value("snapshots"), "0");
  button.publish(stop(false));
  button.publish(stop(true));
  std::string reason;
  EXPECT_EQ(recorded(wait_for_snapshots("1"), reason).at("/a"), 1U);
  EXPECT_EQ(reason, "emergency stop /robot/emergency_stop");
}

TEST_F(BlackBoxTest, first_writes_what_a_killed_process_left) {
  const auto& options = container_.container().options();
  const std::string name = ring_name(fully_qualified_node_name(options.name_space, options.name), "/rosbag2_recorder");
  const pid_t child = ::fork();
  if (child == 0) {
    auto ring = Ring::begin({.name = name});
    if (!ring) ::_exit(1);
    const auto message = words("the last ones");
    (*ring)->write((*ring)->add_topic("/a", String::message_type(), {QoS(10)}), &message, {1, 1});
    const auto content = (*ring)->content();
    ::_exit(content.size() == 1 ? 0 : 1);
  }
  int status = 0;
  ASSERT_EQ(::waitpid(child, &status, 0), child);
  ASSERT_EQ(status, 0);
  start();
  std::string reason;
  const auto folder = wait_for_snapshots("1");
  EXPECT_EQ(recorded(folder, reason).at("/a"), 1U);
  EXPECT_EQ(folder, path("bag_crashed"));
  EXPECT_EQ(reason, "what a killed process left");
  EXPECT_TRUE(RingFolder::left_behind("/dev/shm", name).empty()) << "it is gone from the memory";
}

TEST_F(BlackBoxTest, a_snapshot_that_cannot_be_written_is_a_fault) {
  auto a = container_.advertise<String>("/a", QoS(10));
  const auto recorder =
      container_.start("nacelle::record::RecordComponent", {{"record.topics", std::vector<std::string>{"/a"}},
                                                            {"storage.uri", std::string{"/proc/bag"}},
                                                            {"storage.ring", std::int64_t{60}}});
  runtime::FaultEvent fault{.node = "/other", .code = "SERIAL_LOST", .text = "unplugged"};
  fault.is_open_fault = true;
  container_.container().tell_open_fault(fault);
  std::string problem;
  for (int left = 30; left > 0 && problem.empty(); --left) problem = value("snapshot problem");
  EXPECT_NE(problem.find("cannot be made"), std::string::npos);
  const auto found = container_.container().find(std::to_string(recorder.id));
  ASSERT_TRUE(found);
  ASSERT_EQ(found->open_faults.size(), 1U);
  EXPECT_EQ(found->open_faults.front().code, "SNAPSHOT_FAILED");
}

}  // namespace
}  // namespace nacelle::record
