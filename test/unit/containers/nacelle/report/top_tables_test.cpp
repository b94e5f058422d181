// SPDX-License-Identifier: Apache-2.0
#include "report/top_tables.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

namespace nacelle::report {
namespace {

using nlohmann::json;
using testing::HasSubstr;
using testing::Not;

/// The answers of a container at two moments a second apart: /camera publishes 30 images, /detector reads them on a thread of
/// its own, /log on the shared one.
struct Figures : ::testing::Test {
  Figures() {
    after = {{"container", "robot"},
             {"now_ns", 12'000'000'000},
             {"process", {{"cpu_us", 5'120'000.0}, {"rss_bytes", 30'000'000}}},
             {"streams", {stream("/image", 60)}},
             {"readers", {reader("/detector", 5), reader("/log", 10)}},
             {"callbacks",
              {callback("/detector", "subscription", "/image", 60, 120'000),
               callback("/log", "subscription", "/image", 60, 600), callback("/map", "timer", "10 ms", 200, 40'000)}},
             {"components",
              {component("/detector", true, "detector", 130'000), component("/log", false, "executor", 9'000),
               component("/map", false, "executor", 60'000)}},
             {"threads",
              {thread(1, "executor", "serving"),
               thread(2, "detector", "serving"),
               {{"id", 3}, {"name", "camera_rx"}, {"executor", ""}, {"cpu_us", 50'000.0}}}}};
    before = after;
    before["now_ns"] = 11'000'000'000;
    before["process"]["cpu_us"] = 5'000'000.0;
    before["streams"][0]["published"] = 30;
    for (auto& row : before["callbacks"]) {
      row["count"] = row["count"].get<int>() / 2;
      row["total_us"] = row["total_us"].get<double>() / 2;
    }
    for (auto& row : before["components"]) row["cpu_us"] = row["cpu_us"].get<double>() / 2;
    before["threads"][2]["cpu_us"] = 40'000.0;
  }
  static json stream(const char* name, int published) {
    return {{"name", name},
            {"type", "sensor_msgs/msg/Image"},
            {"writers", 1},
            {"readers", 2},
            {"published", published},
            {"delivered", 2 * published},
            {"last_ns", 11'990'000'000},
            {"copies", 0},
            {"bytes_copied", 0},
            {"handed_over", "both"},
            {"latency_p50_us", 20.0},
            {"latency_p99_us", 650.0},
            {"latency_max_us", 900.0},
            {"deadline_missed", 0},
            {"dropped",
             {{"overwritten", 0},
              {"full", 0},
              {"expired", 0},
              {"inactive", 0},
              {"would_block", 0},
              {"pool_dry", 0},
              {"discarded", 0}}}};
  }
  static json reader(const char* node, int depth) {
    return {{"topic", "/image"},      {"type", "sensor_msgs/msg/Image"},
            {"node", node},           {"other_process", false},
            {"open", true},           {"keeps_all", false},
            {"waiting", 0},           {"depth", depth},
            {"delivered", 60},        {"lost", 0},
            {"deadline_missed", 0},   {"latency_p99_us", 650.0},
            {"latency_max_us", 900.0}};
  }
  static json callback(const char* node, const char* kind, const char* name, int count, double total_us) {
    return {{"node", node}, {"kind", kind},         {"name", name},      {"count", count},
            {"skipped", 0}, {"total_us", total_us}, {"p99_us", 3'000.0}, {"max_us", 5'000.0}};
  }
  static json component(const char* node, bool own, const char* executor, double cpu_us) {
    return {{"node", node},       {"state", "active"}, {"callbacks", 60}, {"executor", executor},
            {"own_threads", own}, {"cpu_us", cpu_us},  {"samples", 3}};
  }
  static json thread(int id, const char* executor, const char* state) {
    return {{"id", id}, {"name", executor}, {"executor", executor}, {"state", state}, {"cpu_us", 1.0}};
  }
  /// The rows of readers and callbacks, by node.
  json& reader_of(const std::string& node) { return row(after["readers"], node); }
  static json& row(json& rows, const std::string& node) {
    for (auto& one : rows) {
      if (one["node"] == node) return one;
    }
    throw std::out_of_range(node);
  }
  json late() const { return streams_between(before, after)["streams"][0]["late"]; }

  json before, after;
};

TEST_F(Figures, of_a_robot_that_keeps_up_name_no_late_reader) {
  const json table = streams_between(before, after);
  EXPECT_DOUBLE_EQ(table["seconds"], 1.0);
  const json& image = table["streams"][0];
  EXPECT_DOUBLE_EQ(image["hz"], 30.0);
  EXPECT_NEAR(image["age_s"].get<double>(), 0.01, 1e-9);
  EXPECT_TRUE(image["late"].empty());
  EXPECT_THAT(streams_text(table), Not(HasSubstr("late")));
}

TEST_F(Figures, of_a_stream_without_messages_have_no_age) {
  after["streams"][0]["published"] = before["streams"][0]["published"] = 0;
  EXPECT_TRUE(streams_between(before, after)["streams"][0]["age_s"].is_null());
}

TEST_F(Figures, of_a_message_that_came_after_the_clock_was_read_are_not_negative) {
  after["streams"][0]["last_ns"] = after["now_ns"].get<std::int64_t>() + 491'000;
  EXPECT_EQ(streams_between(before, after)["streams"][0]["age_s"].get<double>(), 0.0);
}

TEST_F(Figures, show_drops_by_cause) {
  after["streams"][0]["dropped"]["overwritten"] = 12;
  after["streams"][0]["dropped"]["pool_dry"] = 3;
  after["streams"][0]["deadline_missed"] = 2;
  before["streams"][0]["dropped"]["overwritten"] = 10;
  const json table = streams_between(before, after);
  EXPECT_DOUBLE_EQ(table["streams"][0]["dropped_per_s"], 5.0);
  EXPECT_THAT(streams_text(table), HasSubstr("12 overwritten, 3 pool_dry, 2 deadline missed (5.0/s)"));
}

TEST_F(Figures, a_callback_that_takes_longer_than_the_period_is_named) {
  reader_of("/detector")["lost"] = 7;
  reader_of("/detector")["waiting"] = 5;
  row(after["callbacks"], "/detector")["count"] = 50;
  row(after["callbacks"], "/detector")["total_us"] = 60'000 + 20 * 48'000;
  ASSERT_EQ(late().size(), 1U);
  EXPECT_EQ(late()[0]["node"], "/detector");
  EXPECT_EQ(late()[0]["why"], "7 lost, 5 of 5 wait: its callback takes 48.0 ms, and every 33.3 ms a message comes");
}

TEST_F(Figures, a_neighbour_that_holds_the_shared_thread_is_named) {
  reader_of("/log")["waiting"] = 6;
  row(after["callbacks"], "/map")["total_us"] = 20'000 + 950'000;
  ASSERT_EQ(late().size(), 1U);
  EXPECT_EQ(
      late()[0]["why"],
      "6 of 10 wait: its thread 'executor' is busy 95 % of the time, most of it with /map's timer 10 ms (9.5 ms each)");
}

TEST_F(Figures, a_thread_whose_work_is_in_no_report_is_known_by_its_clock) {
  reader_of("/log")["waiting"] = 6;
  after["threads"][0]["cpu_us"] = before["threads"][0]["cpu_us"].get<double>() + 970'000;
  EXPECT_EQ(late()[0]["why"], "6 of 10 wait: its thread 'executor' is busy 97 % of the time");
}

TEST_F(Figures, streams_without_readers_come_last) {
  after["streams"].push_back(stream("/a_stream_to_nobody", 1));
  after["streams"][1]["readers"] = 0;
  EXPECT_EQ(streams_between(before, after)["streams"][0]["name"], "/image");
}

TEST_F(Figures, a_thread_of_ones_own_is_not_held_by_others) {
  reader_of("/detector")["waiting"] = 4;
  row(after["callbacks"], "/map")["total_us"] = 20'000 + 950'000;
  EXPECT_THAT(late()[0]["why"], Not(HasSubstr("/map")));
}

TEST_F(Figures, reports_a_callback_that_runs_too_long_now) {
  reader_of("/log")["waiting"] = 6;
  after["threads"][0]["state"] = "late";
  EXPECT_THAT(late()[0]["why"], HasSubstr("a callback on its thread runs too long"));
}

TEST_F(Figures, reports_a_callback_that_does_not_run) {
  reader_of("/log")["lost"] = 3;
  row(before["callbacks"], "/log") = row(after["callbacks"], "/log");
  EXPECT_EQ(late()[0]["why"], "3 lost: its callback has not run");
}

TEST_F(Figures, reports_one_long_callback_with_the_time_that_the_queue_bridges) {
  reader_of("/detector")["lost"] = 3;
  row(after["callbacks"], "/detector")["max_us"] = 400'000.0;
  EXPECT_EQ(late()[0]["why"], "3 lost: its callback took up to 400.0 ms, and its queue of 5 bridges 166.7 ms");
}

TEST_F(Figures, reports_bursts_if_nothing_else_explains_the_losses) {
  reader_of("/detector")["lost"] = 3;
  EXPECT_EQ(late()[0]["why"], "3 lost: messages come in bursts of more than its queue of 5");
}

TEST_F(Figures, a_missed_deadline_is_the_publishers) {
  reader_of("/log")["deadline_missed"] = 2;
  EXPECT_EQ(late()[0]["why"], "deadline missed 2 times: too few messages arrived (30.0 per second)");
}

TEST_F(Figures, reports_a_late_reader_of_another_process_as_such) {
  reader_of("/log")["lost"] = 1;
  reader_of("/log")["other_process"] = true;
  EXPECT_THAT(late()[0]["why"], HasSubstr("its process does not take its messages in time"));
}

TEST_F(Figures, who_is_not_active_or_has_just_come_is_not_late) {
  reader_of("/log")["lost"] = 9;
  reader_of("/log")["open"] = false;
  EXPECT_TRUE(late().empty());
  reader_of("/log")["open"] = true;
  before["readers"] = json::array();
  EXPECT_TRUE(late().empty()) << "losses before the first look are not of this interval";
}

TEST_F(Figures, of_components_are_sorted_by_what_they_cost) {
  const json table = components_between(before, after);
  ASSERT_EQ(table["components"].size(), 3U);
  EXPECT_EQ(table["components"][0]["node"], "/detector");
  EXPECT_NEAR(table["components"][0]["cpu_percent"].get<double>(), 6.5, 1e-9);
  EXPECT_EQ(table["components"][0]["cpu_by"], "threads");
  EXPECT_EQ(table["components"][1]["node"], "/map");
  EXPECT_EQ(table["components"][1]["cpu_by"], "callbacks");
  EXPECT_NEAR(table["components"][0]["callbacks_per_s"].get<double>(), 30, 1e-9);
  EXPECT_NEAR(table["components"][0]["mean_us"].get<double>(), 2000, 1e-9);
  EXPECT_NEAR(table["cpu_percent"].get<double>(), 12, 1e-9);
  EXPECT_NEAR(table["other_threads"][0]["cpu_percent"].get<double>(), 1, 1e-9);
  const std::string text = components_text(table);
  EXPECT_THAT(text, HasSubstr("robot: 12.0 % of a core, 30.0 MB, 3 threads"));
  EXPECT_THAT(text, HasSubstr("other threads: camera_rx 1.0 %"));
}

TEST_F(Figures, of_a_process_of_its_own_have_its_memory) {
  after["components"].push_back(
      {{"node", "/apart"}, {"state", "active"}, {"process", 77}, {"cpu_us", 300'000.0}, {"rss_bytes", 12'500'000}});
  before["components"].push_back(
      {{"node", "/apart"}, {"state", "active"}, {"process", 77}, {"cpu_us", 100'000.0}, {"rss_bytes", 12'500'000}});
  const json table = components_between(before, after);
  EXPECT_EQ(table["components"][0]["node"], "/apart");
  EXPECT_EQ(table["components"][0]["cpu_by"], "process");
  EXPECT_NEAR(table["components"][0]["cpu_percent"].get<double>(), 20, 1e-9);
  EXPECT_THAT(components_text(table), HasSubstr("12.5 MB"));
}

TEST_F(Figures, of_a_component_that_began_anew_count_from_its_begin) {
  row(before["components"], "/detector")["cpu_us"] = 900'000.0;  // of the one before
  EXPECT_NEAR(components_between(before, after)["components"][0]["cpu_percent"].get<double>(), 13, 1e-9);
}

}  // namespace
}  // namespace nacelle::report
