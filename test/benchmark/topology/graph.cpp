// SPDX-License-Identifier: Apache-2.0
#include "topology/graph.hpp"

#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <sstream>

namespace nacelle::bench {

Graph read_graph(const std::string& file) {
  Graph graph;
  std::ifstream lines(file);
  bool good = lines.good();
  for (std::string line; good && std::getline(lines, line);) {
    std::istringstream words(line);
    std::string verb;
    words >> verb;
    if (verb == "node") {
      words >> graph.nodes.emplace_back().name;
    } else if (verb == "pub" && !graph.nodes.empty()) {
      Source source;
      std::int64_t period_us = 0;
      std::string how;
      words >> source.topic >> source.type >> period_us >> source.bytes >> how;
      source.period = std::chrono::microseconds(period_us);
      source.filled = how == "filled";
      good = period_us > 0;
      graph.nodes.back().sources.push_back(std::move(source));
    } else if (verb == "sub" && !graph.nodes.empty()) {
      Sink sink;
      words >> sink.topic >> sink.type;
      graph.nodes.back().sinks.push_back(std::move(sink));
    } else {
      good = verb.empty();
    }
    good = good && (verb.empty() || !words.fail());
    if (!good) std::fprintf(stderr, "topology: %s: cannot read the line '%s'\n", file.c_str(), line.c_str());
  }
  if (good && !graph.nodes.empty()) return graph;
  std::fprintf(stderr, "topology: %s holds no graph\n", file.c_str());
  std::exit(2);
}

std::map<std::string, Duration> Graph::periods() const {
  std::map<std::string, Duration> found;
  for (const auto& node : nodes) {
    for (const auto& source : node.sources) found[source.topic] = source.period;
  }
  return found;
}

double Graph::offered_hz() const {
  double sum = 0;
  for (const auto& [topic, period] : periods()) sum += 1.0 / to_seconds(period);
  return sum;
}

double Graph::deliveries_hz() const {
  const auto known = periods();
  double sum = 0;
  for (const auto& node : nodes) {
    for (const auto& sink : node.sinks) {
      if (const auto found = known.find(sink.topic); found != known.end()) sum += 1.0 / to_seconds(found->second);
    }
  }
  return sum;
}

}  // namespace nacelle::bench
