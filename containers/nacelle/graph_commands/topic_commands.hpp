// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "cli/topic_listener.hpp"
#include "cli/whom.hpp"

// The commands of `topic`: list and info (topic_commands.cpp), reading (topic_listen.cpp, topic_rates.cpp), publishing
// (topic_publish.cpp).
namespace nacelle::cli {

struct TopicWish {
  Whom whom;
  std::string topic, type, field, message = "{}";
  std::vector<std::string> words;  ///< Topics, each followed by its type if that is given.
  bool as_json = false, as_csv = false, with_types = false, once = false, full = false, verbose = false,
       only_count = false, all = false, is_raw = false;
  double rate_hz = 1.0, longest_wait_s = 0.0;
  std::size_t window = 0, longest = 128, times = 0, readers = 0, print_every = 1;
};

int echo_topic(const TopicWish& wish);
int measure_rate(const TopicWish& asked);
int measure_rates(const TopicWish& wish, const std::vector<Listening::Topic>& topics);
int measure_bandwidth(const TopicWish& wish);
int measure_delay(const TopicWish& wish);
int publish_topic(const TopicWish& asked);

}  // namespace nacelle::cli
