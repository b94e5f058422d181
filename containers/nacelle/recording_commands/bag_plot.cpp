// SPDX-License-Identifier: Apache-2.0
#include "recording_commands/bag_plot.hpp"

#include <algorithm>
#include <array>
#include <string_view>

#include "cli/output.hpp"
#include "cli/program.hpp"
#include "drawing/chart.hpp"
#include "nacelle/base/files.hpp"
#include "nacelle/msgs/type_library.hpp"
#include "record/model/field_series.hpp"
#include "record/port/recording_file.hpp"
#include "recording_commands/recording_files.hpp"

namespace nacelle::cli {
namespace {

using record::TopicField;

/// Fields that are lengths along the axes of a frame.
bool is_coordinate(const TopicField& field) {
  constexpr std::array kEnds{".x", ".y", ".z"};
  return std::ranges::any_of(kEnds, [&](const char* end) { return field.text().ends_with(end); });
}

/// The field at the axis: what all lines have in common, if they are one.
std::string y_label_of(const std::vector<TopicField>& fields) {
  return fields.size() == 1 ? fields.front().text() : "";
}

drawing::Chart chart_of(const record::FieldSeries& series, const std::vector<TopicField>& fields, const TopicField* x) {
  drawing::Chart chart;
  chart.x_label = x == nullptr ? "time since the first message [s]" : x->text();
  chart.y_label = y_label_of(fields);
  if (x != nullptr) chart.equal_scales = is_coordinate(*x) && std::ranges::all_of(fields, is_coordinate);
  const auto of_x = x == nullptr ? std::vector<record::TimedValue>{} : series.values(fields.size());
  for (std::size_t i = 0; i < fields.size(); ++i) {
    drawing::ChartLine line{fields[i].text(), {}};
    const auto values = series.values(i);
    if (x == nullptr) {
      for (const auto& at : values)
        line.points.push_back({static_cast<double>(at.time - series.first()) * 1e-9, at.value});
    } else {
      for (const auto& [of_time, value] : record::joined(of_x, values)) line.points.push_back({of_time, value});
    }
    chart.lines.push_back(std::move(line));
  }
  return chart;
}

}  // namespace

std::string wrong_topic_field(const std::string& text) {
  const auto parsed = record::parse_topic_field(text);
  if (!parsed) return parsed.error().text();
  const auto steps = record::parse_field_path(parsed->path);
  return steps ? "" : steps.error().text();
}

int plot_bag(const BagPlotWish& wish) {
  const auto files = recording_files(wish.path);
  if (!files) return complain(files.error());
  std::vector<TopicField> fields;
  for (const auto& text : wish.fields) fields.push_back(*record::parse_topic_field(text));
  std::vector<TopicField> all = fields;
  if (!wish.x.empty()) all.push_back(*record::parse_topic_field(wish.x));

  msgs::TypeLibrary library{message_library_directories()};
  record::FieldSeries series{all, [&](const std::string& type) { return library.message(type); }};
  bool is_whole = true;
  for (const auto& file : *files) {
    auto source = record::FileSource::open(file);
    if (!source) return complain(source.error());
    series.begin_file();
    record::walk_mcap(**source, series);
    for (const auto& problem : series.problems()) complain(problem_of(file, problem));
    is_whole = is_whole && series.problems().empty();
    const bool is_none = !series.problems().empty() && series.problems().front().fault == record::McapFault::NoMagic;
    if (is_none) return kFailed;
  }
  if (const auto checked = series.check(); !checked) return complain(checked.error());

  const auto chart = chart_of(series, fields, wish.x.empty() ? nullptr : &all.back());
  std::size_t points = 0;
  for (const auto& line : chart.lines) points += line.points.size();
  if (const auto written = write_whole_file(wish.output, drawing::chart_svg(chart)); !written)
    return complain(written.error());
  print_text("%s: %zu line%s, %zu point%s\n", wish.output.c_str(), chart.lines.size(),
             chart.lines.size() == 1 ? "" : "s", points, points == 1 ? "" : "s");
  return is_whole ? kDone : kFailed;
}

}  // namespace nacelle::cli
