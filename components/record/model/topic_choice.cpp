// SPDX-License-Identifier: Apache-2.0
#include "record/model/topic_choice.hpp"

#include <algorithm>
#include <utility>

namespace nacelle::record {
namespace {

bool is_hidden(const std::string& topic) { return topic.starts_with('_') || topic.find("/_") != std::string::npos; }

bool is_among(const std::vector<std::string>& topics, const std::string& topic) {
  return std::find(topics.begin(), topics.end(), topic) != topics.end();
}

Result<std::optional<std::regex>, Problem> regex_of(const std::string& text, const char* name) {
  std::optional<std::regex> made;
  if (text.empty()) return made;
  try {
    made.emplace(text);
  } catch (const std::regex_error& error) {
    return err(Problem{name, "'" + text + "' is no regular expression (ECMAScript): " + error.what(),
                       "escape its special characters with a backslash"});
  }
  return made;
}

}  // namespace

Result<TopicChoice, Problem> TopicChoice::make(TopicWish wish) {
  auto by = regex_of(wish.regex, "regex");
  if (!by) return err(by.error());
  auto without = regex_of(wish.exclude_regex, "exclude_regex");
  if (!without) return err(without.error());
  TopicChoice choice{std::move(wish)};
  choice.by_ = std::move(by).value();
  choice.without_ = std::move(without).value();
  return choice;
}

bool TopicChoice::is_found(const std::string& topic) const { return by_ && std::regex_search(topic, *by_); }

bool TopicChoice::takes(const std::string& topic) const {
  if (is_among(wish_.exclude_topics, topic) || (without_ && std::regex_search(topic, *without_))) return false;
  if (is_among(wish_.topics, topic)) return true;
  if (is_hidden(topic) && !wish_.hidden) return false;
  return wish_.all || is_found(topic);
}

bool TopicChoice::picks(const std::string& topic) const {
  return takes(topic) && (is_among(wish_.topics, topic) || is_found(topic));
}

}  // namespace nacelle::record
