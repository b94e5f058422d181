// SPDX-License-Identifier: Apache-2.0
#include "run_page/page.hpp"

#include <gmock/gmock.h>
#include <tinyxml2.h>

#include <cmath>
#include <map>
#include <regex>
#include <string>
#include <utility>
#include <vector>

#include "nacelle/base/xml.hpp"

namespace nacelle::run_page {
namespace {

using testing::HasSubstr;
using testing::Not;

/// A drive along one side of a square, in which odometry turns away.
Figures a_drive() {
  Figures figures;
  figures.robot = "robot";
  figures.launch_file = "/opt/launch/robot.launch.yaml";
  figures.version = "0.1.0 (0123456789ab)";
  figures.date = "2026-11-28 15:04:05 +0100";
  figures.seed = 4;
  figures.time_s = 10.0;
  figures.distance_m = 1.04;
  figures.odometry_error = {0.0208, 0.62};
  figures.ekf_error = {0.0043, 0.05};
  figures.cpu_percent = 2.34;
  figures.rss_mb = 24.5;
  figures.has_truth = true;
  for (int i = 0; i <= 100; ++i) {
    const double t = i * 0.1;
    figures.path.push_back(
        {t, {t * 0.1, 0.0}, {t * 0.1, t * 0.002}, {t * 0.1, 0.0}, {t * 0.002, t * 0.06}, {0.0043, 0.05}});
    figures.cpu_percents.push_back({t, 2.0 + 0.1 * t});
    figures.rss_mbs.push_back({t, 24.5});
  }
  StreamFigures scan;
  scan.name = "/scan";
  scan.nominal_hz = 10;
  scan.hz = 9.98;
  scan.lowest_hz = 9.5;
  scan.rates_hz = {{2, 10}, {3, 9.5}, {4, 10}};
  scan.published = 101;
  scan.dropped = 3;
  scan.copies = 2;
  scan.p50_us = 25;
  scan.p99_us = 90;
  scan.max_us = 1400;
  StreamFigures idle;
  idle.name = "/cmd_vel";
  idle.published = 7;
  figures.streams = {scan, idle};
  figures.command_p50_us = 4000;
  figures.command_p99_us = 12000;
  return figures;
}

/// A page as the browser has it: a tree.
class Page {
 public:
  explicit Page(const Figures& figures) : text(page_of(figures)) {
    const auto parsed = parse_xml(document_, text, "page");
    EXPECT_TRUE(parsed.has_value()) << (parsed ? "" : parsed.error().text()) << "\n" << text;
    walk(document_.RootElement());
  }

  const std::string text;
  std::map<std::string, std::string> tiles;                ///< dt -> dd
  std::vector<std::vector<std::string>> rows;              ///< of the table
  std::vector<std::pair<std::string, std::string>> lines;  ///< title and points of each polyline
  std::vector<std::string> names;                          ///< of all elements

 private:
  static std::string words(const tinyxml2::XMLElement& element) {
    return element.GetText() == nullptr ? "" : element.GetText();
  }
  void walk(const tinyxml2::XMLElement* element) {
    if (element == nullptr) return;
    const std::string name = element->Name();
    names.push_back(name);
    if (name == "dt") tiles[words(*element)] = words(*element->NextSiblingElement("dd"));
    if (name == "tr") rows.emplace_back();
    if (name == "td") rows.back().push_back(words(*element));
    if (name == "polyline")
      lines.emplace_back(words(*element->FirstChildElement("title")), element->Attribute("points"));
    for (const auto* child = element->FirstChildElement(); child != nullptr; child = child->NextSiblingElement())
      walk(child);
  }
  tinyxml2::XMLDocument document_;
};

TEST(RunPage, has_the_figures_of_the_run) {
  const Page page{a_drive()};
  for (const char* const part : {"<title>Run of robot: robot.launch.yaml</title>", "/opt/launch/robot.launch.yaml",
                                 "nacelle 0.1.0 (0123456789ab), 2026-11-28 15:04:05 +0100, seed 4"})
    EXPECT_THAT(page.text, HasSubstr(part));
  EXPECT_EQ(page.tiles.at("Distance driven"), "1.04 m");
  EXPECT_EQ(page.tiles.at("Time"), "10.0 s");
  EXPECT_EQ(page.tiles.at("Odometry error at the end"), "0.0208 m, 0.62 deg");
  EXPECT_EQ(page.tiles.at("EKF error at the end"), "0.0043 m, 0.05 deg");
  EXPECT_EQ(page.tiles.at("Messages"), "108");
  EXPECT_EQ(page.tiles.at("Dropped"), "3");
  EXPECT_EQ(page.tiles.at("Copied"), "2");
  EXPECT_EQ(page.tiles.at("Faults"), "0");
  EXPECT_EQ(page.tiles.at("CPU, of one core"), "2.3 %");
  EXPECT_EQ(page.tiles.at("Memory"), "24.5 MB");
  ASSERT_EQ(page.rows.size(), 3U);
  EXPECT_THAT(page.rows[1], testing::ElementsAre("/scan", "10", "9.98", "9.50", "", "101", "3", "2"));
  EXPECT_THAT(page.rows[2], testing::ElementsAre("/cmd_vel", "-", "0.00", "-", "", "7", "0", "0"));
  EXPECT_THAT(page.text, HasSubstr("25 / 90 / 1400 us"));
  EXPECT_THAT(page.text, HasSubstr("4000 / 12000 us"));
}

TEST(RunPage, draws_truth_odometry_and_ekf_with_one_scale) {
  const Page page{a_drive()};
  std::vector<std::string> titles;
  for (const auto& [title, points] : page.lines) titles.push_back(title);
  EXPECT_THAT(titles, testing::ElementsAre("truth", "odometry", "EKF",  // path
                                           "truth", "odometry", "EKF",  // position error
                                           "truth", "odometry", "EKF",  // yaw error
                                           "/scan", "CPU", "memory"));
  // Odometry ends 1 m to the right and 2 cm above.
  std::smatch ends;
  const std::string& points = page.lines[1].second;
  ASSERT_TRUE(std::regex_match(points, ends, std::regex{R"(([\d.]+),([\d.]+) .* ([\d.]+),([\d.]+))"})) << points;
  const double across = std::stod(ends[3]) - std::stod(ends[1]), up = std::stod(ends[2]) - std::stod(ends[4]);
  EXPECT_NEAR(up / across, 0.02, 0.0005);
  for (const char* const label :
       {"x [m]", "y [m]", "time [s]", "position error [m]", "yaw error [deg]", "CPU [% of a core]", "memory [MB]"})
    EXPECT_THAT(page.text, HasSubstr(std::string{">"} + label + "<"));
}

TEST(RunPage, needs_nothing_from_elsewhere) {
  const Page page{a_drive()};
  for (const char* const part : {"http", "//", "url(", "@import", "src=", "href="})
    EXPECT_THAT(page.text, Not(HasSubstr(part)));
  for (const char* const element : {"script", "link", "img", "iframe", "object"})
    EXPECT_THAT(page.names, Not(testing::Contains(element)));
  for (const char* const part : {"prefers-color-scheme: dark", "name=\"viewport\"", "charset=\"utf-8\""})
    EXPECT_THAT(page.text, HasSubstr(part));
}

TEST(RunPage, escapes_names) {
  Figures figures = a_drive();
  const std::string bad = "<script>alert(1)</script>&\"'\x1b\xFF";
  figures.robot = figures.launch_file = figures.failure = figures.version = bad;
  figures.arguments = figures.faults = {bad};
  for (auto& stream : figures.streams) stream.name = bad;
  const Page page{figures};
  EXPECT_THAT(page.names, Not(testing::Contains("script")));
  EXPECT_THAT(page.text, Not(HasSubstr("<script")));
  EXPECT_THAT(page.text, HasSubstr("&lt;script&gt;alert(1)&lt;/script&gt;&amp;&quot;'\xEF\xBF\xBD\xEF\xBF\xBD"));
  EXPECT_EQ(page.rows[1][0].substr(0, 8), "<script>") << "the reader sees the name";
}

TEST(RunPage, of_a_robot_without_truth_says_so) {
  Figures figures = a_drive();
  figures.has_truth = false;
  figures.odometry_error = figures.ekf_error = {};
  for (auto& sample : figures.path) {
    sample.truth = {};
    sample.odometry_error = sample.ekf_error = {};
  }
  const Page page{figures};
  EXPECT_THAT(page.text, HasSubstr("Unknown: the robot is not simulated."));
  EXPECT_EQ(page.tiles.count("EKF error at the end"), 0U);
  EXPECT_EQ(page.lines[0].first, "odometry");
}

TEST(RunPage, of_a_run_that_ended_early_names_the_reason_and_has_what_there_is) {
  Figures figures;
  figures.failure = "component lidar: is faulted";
  figures.faults = {"component lidar: is faulted"};
  const Page page{figures};
  EXPECT_THAT(page.text, HasSubstr("Ended early: component lidar: is faulted"));
  EXPECT_EQ(page.tiles.at("Distance driven"), "not driven");
  EXPECT_EQ(page.tiles.at("Faults"), "1");
  EXPECT_EQ(page.tiles.count("Messages"), 0U) << "unknown, which is not none";
  EXPECT_THAT(page.text, Not(HasSubstr("nan")));
}

TEST(RunPage, of_a_long_run_stays_small) {
  Figures figures = a_drive();
  figures.path.assign(2049, figures.path.back());
  figures.cpu_percents.assign(2049, {1.0, 2.0});
  figures.rss_mbs = figures.cpu_percents;
  figures.streams.assign(30, figures.streams[0]);
  for (auto& stream : figures.streams) {
    stream.rates_hz.clear();
    for (int i = 0; i < 2049; ++i) stream.rates_hz.push_back({i * 1.0, 10.0 + i % 2});
  }
  EXPECT_LT(Page{figures}.text.size(), 1'000'000U);
}

}  // namespace
}  // namespace nacelle::run_page
