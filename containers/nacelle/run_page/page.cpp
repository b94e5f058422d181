// SPDX-License-Identifier: Apache-2.0
#include "run_page/page.hpp"

#include <fmt/format.h>

#include <cmath>

#include "drawing/bars.hpp"
#include "drawing/chart.hpp"
#include "run_page/page_style.hpp"

namespace nacelle::run_page {
namespace {

using drawing::svg_number;
using drawing::svg_text;

constexpr const char* kTimeLabel = "time [s]";

drawing::ChartStyle style_of(double width, double plot_height) {
  return {drawing::svg_page_colours(), drawing::SvgPlace::Page, width, plot_height};
}

std::string number(double value, int decimals, const char* unit = "") {
  return std::isfinite(value) ? svg_number(value, decimals) + unit : "-";
}

std::string heading(const std::string& text) { return "<h2>" + svg_text(text) + "</h2>\n"; }
std::string paragraph(const std::string& text) { return "<p>" + svg_text(text) + "</p>\n"; }
std::string figure(const std::string& svg, const std::string& caption, const char* width = "wide") {
  return fmt::format("<figure class=\"{}\">\n", width) + svg + "<figcaption>" + svg_text(caption) +
         "</figcaption>\n</figure>\n";
}
std::string tile(const std::string& name, const std::string& value) {
  return fmt::format("<div><dt>{}</dt><dd>{}</dd></div>\n", svg_text(name), svg_text(value));
}

std::string error_text(const PoseError& error) {
  return number(error.distance_m, 4, " m") + ", " + number(error.yaw_deg, 2, " deg");
}

template <typename Count>
std::string sum_of(const std::vector<StreamFigures>& streams, const Count& count) {
  std::uint64_t sum = 0;
  for (const auto& stream : streams) sum += count(stream);
  return std::to_string(sum);
}

std::string head_of(const Figures& figures) {
  std::string text = paragraph("Launch file " + figures.launch_file);
  if (!figures.arguments.empty()) {
    std::string all;
    for (const auto& argument : figures.arguments) all += (all.empty() ? "" : " ") + argument;
    text += paragraph("Arguments " + all);
  }
  text += paragraph(fmt::format("nacelle {}, {}, seed {}", figures.version, figures.date, figures.seed));
  if (!figures.failure.empty()) text += "<p class=\"failure\">Ended early: " + svg_text(figures.failure) + "</p>\n";
  return text;
}

std::string summary_of(const Figures& figures) {
  std::string text = heading("Summary") + "<dl class=\"tiles\">\n";
  text +=
      tile("Distance driven", std::isfinite(figures.distance_m) ? number(figures.distance_m, 2, " m") : "not driven");
  text += tile("Time", number(figures.time_s, 1, " s"));
  if (std::isfinite(figures.odometry_error.distance_m) || std::isfinite(figures.ekf_error.distance_m)) {
    text += tile("Odometry error at the end", error_text(figures.odometry_error));
    text += tile("EKF error at the end", error_text(figures.ekf_error));
  }
  if (!figures.streams.empty()) {
    text += tile("Messages", sum_of(figures.streams, [](const auto& stream) { return stream.published; }));
    text += tile("Dropped", sum_of(figures.streams, [](const auto& stream) { return stream.dropped; }));
    text += tile("Copied", sum_of(figures.streams, [](const auto& stream) { return stream.copies; }));
  }
  text += tile("Faults", std::to_string(figures.faults.size()));
  text += tile("CPU, of one core", number(figures.cpu_percent, 1, " %"));
  text += tile("Memory", number(figures.rss_mb, 1, " MB"));
  text += "</dl>\n";
  for (const auto& fault : figures.faults) text += "<p class=\"failure\">" + svg_text(fault) + "</p>\n";
  return text;
}

drawing::ChartLine path_line(const Figures& figures, const char* name, Position PathSample::*of) {
  drawing::ChartLine line{name, {}};
  for (const auto& sample : figures.path) line.points.push_back({(sample.*of).x_m, (sample.*of).y_m});
  return line;
}

std::string path_of(const Figures& figures) {
  drawing::Chart chart{"x [m]", "y [m]", {}, true};
  // Always in these colours, also without a truth.
  chart.lines.push_back(path_line(figures, figures.has_truth ? "truth" : "truth (unknown)", &PathSample::truth));
  chart.lines.push_back(path_line(figures, "odometry", &PathSample::odometry));
  chart.lines.push_back(path_line(figures, "EKF", &PathSample::ekf));
  return heading("Driven path") +
         figure(drawing::chart_svg(chart, style_of(600, 0)), "Both axes have one scale. Frame: odom.", "narrow");
}

drawing::ChartLine error_line(const Figures& figures, const char* name, PoseError PathSample::*of,
                              double PoseError::*value) {
  drawing::ChartLine line{name, {}};
  for (const auto& sample : figures.path) line.points.push_back({sample.time_s, sample.*of.*value});
  return line;
}

std::string errors_of(const Figures& figures) {
  std::string text = heading("Error against the truth");
  if (!figures.has_truth) return text + paragraph("Unknown: the robot is not simulated.");
  const auto chart = [&](const char* label, double PoseError::*value) {
    // The first line is the truth: this keeps the colours of the path.
    const drawing::ChartLine truth{"truth", {{0.0, 0.0}, {figures.time_s, 0.0}}};
    return drawing::chart_svg({kTimeLabel,
                               label,
                               {truth, error_line(figures, "odometry", &PathSample::odometry_error, value),
                                error_line(figures, "EKF", &PathSample::ekf_error, value)},
                               false},
                              style_of(520, 240));
  };
  return text + "<div class=\"pair\">\n" +
         figure(chart("position error [m]", &PoseError::distance_m),
                "Distance to the true position at the pose's stamp") +
         figure(chart("yaw error [deg]", &PoseError::yaw_deg), "Angle to the true yaw at the pose's stamp") +
         "</div>\n";
}

std::string rates_of(const Figures& figures) {
  std::string text =
      heading("Rates") +
      "<div class=\"scroll\">\n<table>\n<thead><tr><th>stream</th><th>nominal Hz</th><th>measured Hz</th>"
      "<th>lowest Hz</th><th>over the run</th><th>messages</th><th>dropped</th><th>copied</th></tr></thead>\n"
      "<tbody>\n";
  for (const auto& stream : figures.streams) {
    drawing::ChartLine line{stream.name, {}};
    for (const auto& rate : stream.rates_hz) line.points.push_back({rate.time_s, rate.value});
    const double mark = std::isfinite(stream.nominal_hz) ? stream.nominal_hz : 0.0;
    const std::string picture = line.points.size() < 2 ? "" : drawing::small_line_svg(line, mark, style_of(128, 24));
    text += fmt::format(
        "<tr><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td></tr>\n",
        svg_text(stream.name), number(stream.nominal_hz, 0), number(stream.hz, 2), number(stream.lowest_hz, 2), picture,
        stream.published, stream.dropped, stream.copies);
  }
  return text + "</tbody>\n</table>\n</div>\n" +
         paragraph(
             "Nominal: what the monitor of the launch file expects; a thin line in the picture. Lowest: the lowest "
             "mean over "
             "two seconds, and over twenty messages of slower streams; - if the run was shorter.");
}

std::string latency_figures(const StreamFigures& stream) {
  return fmt::format("{:.0f} / {:.0f} / {:.0f} us", stream.p50_us, stream.p99_us, stream.max_us);
}

std::string latencies_of(const Figures& figures) {
  drawing::BarChart chart{{"p50", "p99", "max"}, {}};
  for (const auto& stream : figures.streams) {
    if (stream.max_us > 0.0)
      chart.rows.push_back(
          {stream.name, latency_figures(stream), {stream.p50_us * 1e-6, stream.p99_us * 1e-6, stream.max_us * 1e-6}});
  }
  if (std::isfinite(figures.command_p99_us)) {
    chart.rows.push_back({"cmd_vel to the wheels",
                          fmt::format("{:.0f} / {:.0f} us", figures.command_p50_us, figures.command_p99_us),
                          {figures.command_p50_us * 1e-6, figures.command_p99_us * 1e-6}});
  }
  if (chart.rows.empty()) return "";
  return heading("Latencies") +
         figure(drawing::bars_svg(chart, style_of(520, 0)),
                "From publish() to the reader's callback: p50 / p99 / max. The axis is logarithmic.", "narrow");
}

std::string load_of(const Figures& figures) {
  const auto chart = [](const char* name, const char* label, const std::vector<Sample>& samples) {
    drawing::ChartLine line{name, {}};
    for (const auto& sample : samples) line.points.push_back({sample.time_s, sample.value});
    return drawing::chart_svg({kTimeLabel, label, {line}, false, true}, style_of(520, 200));
  };
  return heading("CPU and memory of the robot's process") + "<div class=\"pair\">\n" +
         figure(chart("CPU", "CPU [% of a core]", figures.cpu_percents), "User and system time, mean over a second") +
         figure(chart("memory", "memory [MB]", figures.rss_mbs), "Resident memory (RSS)") + "</div>\n";
}

}  // namespace

std::string page_of(const Figures& figures) {
  const std::string title = svg_text(
      fmt::format("Run of {}: {}", figures.robot, figures.launch_file.substr(figures.launch_file.rfind('/') + 1)));
  return "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\"/>\n"
         "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"/>\n<title>" +
         title + "</title>\n<style>\n" + page_style() + "</style>\n</head>\n<body>\n<h1>" + title + "</h1>\n" +
         head_of(figures) + summary_of(figures) + path_of(figures) + errors_of(figures) + rates_of(figures) +
         latencies_of(figures) + load_of(figures) + "</body>\n</html>\n";
}

}  // namespace nacelle::run_page
