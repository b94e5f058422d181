// SPDX-License-Identifier: Apache-2.0
#include "record/model/field_series.hpp"

#include <algorithm>

namespace nacelle::record {

Result<TopicField, Problem> parse_topic_field(std::string_view text) {
  const std::size_t dot = text.find('.');
  if (dot == std::string_view::npos || dot == 0 || dot + 1 == text.size() || text.substr(0, dot) == "/")
    return err(Problem{"field '" + std::string{text} + "'", "it is no field of a topic",
                       "write it as /odom.pose.pose.position.x"});
  const std::string topic{text.substr(0, dot)};
  return TopicField{topic.starts_with('/') ? topic : "/" + topic, std::string{text.substr(dot + 1)}};
}

FieldSeries::FieldSeries(const std::vector<TopicField>& fields, FindType find_type) : find_type_(std::move(find_type)) {
  for (const TopicField& field : fields) series_.push_back({field, std::nullopt, {}, 0});
}

void FieldSeries::begin_file() {
  types_.clear();
  channels_.clear();
  problems_.clear();
}

void FieldSeries::on_schema(const McapSchema& schema) { types_[schema.id] = schema.name; }

void FieldSeries::on_channel(const McapChannel& channel) {
  topics_.push_back(channel.topic);
  const std::string type = channel.schema_id == 0 ? "" : types_[channel.schema_id];
  for (std::size_t i = 0; i < series_.size(); ++i) {
    Series& series = series_[i];
    if (series.field.topic != channel.topic || series.problem) continue;
    const auto found = find_type_(type);
    if (!found) {
      series.problem = found.error();
      continue;
    }
    auto field = NumericField::find(**found, series.field.path);
    if (!field) {
      series.problem = field.error();
      continue;
    }
    Channel& known = channels_[channel.id];
    if (!known.message) known.message.emplace(**found);
    known.readings.push_back({i, std::move(*field)});
  }
}

void FieldSeries::on_message(const McapMessage& message, const McapSpot& spot) {
  first_ = has_messages_ ? std::min(first_, message.log_time) : message.log_time;
  has_messages_ = true;
  const auto channel = channels_.find(message.channel_id);
  if (channel == channels_.end()) return;
  msgs::AnyMessage& decoded = *channel->second.message;
  if (!decoded.type().decode(message.data.bytes, decoded.get()))
    return on_problem({McapFault::BadPayload, spot.offset, "a message's bytes are none of its type"});
  for (const Reading& reading : channel->second.readings) {
    Series& series = series_[reading.series];
    ++series.messages;
    if (const auto value = reading.field.read(decoded.get())) series.values.push_back({message.log_time, *value});
  }
}

void FieldSeries::on_problem(const McapProblem& problem) {
  if (problems_.size() < kMostProblems) problems_.push_back(problem);
}

std::vector<TimedValue> FieldSeries::values(std::size_t field) const {
  std::vector<TimedValue> sorted = series_[field].values;
  std::stable_sort(sorted.begin(), sorted.end(),
                   [](const TimedValue& a, const TimedValue& b) { return a.time < b.time; });
  return sorted;
}

Result<void, Problem> FieldSeries::check() const {
  for (const Series& series : series_) {
    const std::string& topic = series.field.topic;
    if (std::find(topics_.begin(), topics_.end(), topic) == topics_.end())
      return err(Problem{"topic " + topic, "the recording does not have it", suggestion(topic, topics_), {}, topic});
    if (series.problem) return err(*series.problem);
    if (series.messages == 0) return err(Problem{"topic " + topic, "it has no messages"});
    if (series.values.empty())
      return err(Problem{"field " + series.field.text(), "no message has this element", "give a smaller index"});
  }
  return {};
}

std::vector<std::pair<double, double>> joined(const std::vector<TimedValue>& x, const std::vector<TimedValue>& y) {
  std::vector<std::pair<double, double>> points;
  for (const TimedValue& at : y) {
    const auto after = std::lower_bound(x.begin(), x.end(), at.time,
                                        [](const TimedValue& value, std::uint64_t time) { return value.time < time; });
    if (after == x.end()) continue;
    if (after->time == at.time) {
      points.emplace_back(after->value, at.value);
      continue;
    }
    if (after == x.begin()) continue;
    const auto before = after - 1;
    const double part = static_cast<double>(at.time - before->time) / static_cast<double>(after->time - before->time);
    points.emplace_back(before->value + part * (after->value - before->value), at.value);
  }
  return points;
}

}  // namespace nacelle::record
