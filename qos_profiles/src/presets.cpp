// SPDX-License-Identifier: Apache-2.0
#include "nacelle/qos/presets.hpp"

#include <utility>

namespace nacelle {
namespace {

QoS all_unknown() {
  QoS q(std::size_t{0});
  return q.history(History::Unknown)
      .reliability(Reliability::Unknown)
      .durability(Durability::Unknown)
      .liveliness(Liveliness::Unknown);
}

const std::vector<std::pair<std::string, QoS>>& presets() {
  static const std::vector<std::pair<std::string, QoS>> all{
      {"default", QoS(10)},
      {"sensor_data", SensorDataQoS()},
      {"services_default", ServicesQoS()},
      {"parameters", ParametersQoS()},
      {"parameter_events", ParameterEventsQoS()},
      {"rosout", RosoutQoS()},
      {"clock", ClockQoS()},
      {"action_status", ActionStatusQoS()},
      {"system_default", SystemDefaultsQoS()},
      {"best_available", BestAvailableQoS()},
      {"unknown", all_unknown()},
  };
  return all;
}

}  // namespace

SystemDefaultsQoS::SystemDefaultsQoS() : QoS(std::size_t{0}) {
  history(History::SystemDefault).reliability(Reliability::SystemDefault).durability(Durability::SystemDefault);
}

BestAvailableQoS::BestAvailableQoS(QoS base) : QoS(base) {
  reliability_best_available().durability_best_available().liveliness(Liveliness::BestAvailable);
  deadline(kBestAvailableDuration).liveliness_lease_duration(kBestAvailableDuration);
}

std::optional<QoS> preset(std::string_view name) {
  for (const auto& [known, qos] : presets()) {
    if (known == name) return qos;
  }
  return std::nullopt;
}

const std::vector<std::string>& preset_names() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> all;
    for (const auto& [name, qos] : presets()) all.push_back(name);
    return all;
  }();
  return names;
}

}  // namespace nacelle
