// SPDX-License-Identifier: Apache-2.0
#include "record/component/recorder_figures.hpp"

namespace nacelle::record {

std::map<std::string, std::string> closing_words(const RecorderFigures& figures) {
  std::map<std::string, std::string> words{{"lost", std::to_string(figures.lost)},
                                           {"camera copies", std::to_string(figures.copies)},
                                           {"camera bytes copied", std::to_string(figures.bytes_copied)}};
  for (const auto& topic : figures.topics) {
    if (topic.lost_in_queue > 0) words["lost in queue: " + topic.name] = std::to_string(topic.lost_in_queue);
    if (topic.lost_to_disk > 0) words["lost to disk: " + topic.name] = std::to_string(topic.lost_to_disk);
    if (topic.copies > 0) words["camera copies: " + topic.name] = std::to_string(topic.copies);
  }
  return words;
}

}  // namespace nacelle::record
