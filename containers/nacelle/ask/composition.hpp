// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "ask/nodes.hpp"
#include "nacelle/base/problem.hpp"
#include "nacelle/base/result.hpp"

// Verbs of composition and lifecycle, over the services of containers (nacelle_interfaces, composition_interfaces)
// and of nodes (lifecycle_msgs). `container`: a name, or empty for the only one.
// Errors: as Nodes::call(), and those listed.
namespace nacelle::ask {

/// The maximum size of a parameter file in bytes. Encoded as JSON, it still fits into a request.
inline constexpr std::size_t kMostParametersText = 448U << 10U;

/// Returns "container", "components" and "kept_images". A component is an object:
///
///   "id", "node", "plugin", "library", "managed", "state" (empty without a lifecycle); if there are any also "fault",
///   "open_faults" and "other_nodes"
///
/// A container that is not Nacelle's reports no plugin, library or fault.
[[nodiscard]] Result<nlohmann::json, Problem> list_components(Nodes& nodes, const std::string& container);

/// Returns one component in the form of list_components(), and its "container". `name`: id, full name, or name without
/// namespace.
/// Errors: no such component, with the nearest name; an ambiguous name.
[[nodiscard]] Result<nlohmann::json, Problem> find_component(Nodes& nodes, const std::string& container,
                                                             const std::string& name);

/// Returns the details of a component: the fields of list_components(), "container", "state_id", "namespace", and from
/// a Nacelle container:
///
///   "host", "isolated" (in a process of its own), "actuator" (it moves something)
///   "faults"      so far: "code", "text", "callback", "time_s"
///   "callbacks"   "kind", "name", and their counters
///   the settings of its load, if known: "parameters" (name to value), "remaps" ("scan:=/front/scan"), "qos_overrides"
///   ("topic", "publisher"), "thread" ("own", "threads", "priority", "cpus"), "on_fault" ("policy", "max_restarts",
///   "backoff_s")
///
/// `name`: id, full name, or name without namespace. Errors: no such component, with the nearest name; an ambiguous
/// name.
[[nodiscard]] Result<nlohmann::json, Problem> component_info(Nodes& nodes, const std::string& container,
                                                             const std::string& name);

/// The component to load.
struct LoadWish {
  std::string component;  ///< A name of the launch file, or a class; the other fields are for a class.
  std::string name, name_space;
  std::vector<std::string> parameters, remaps;  ///< "rate:=5", "scan:=/front/scan"
  std::string parameters_file,
      parameters_text;  ///< A ROS 2 parameter file's name and content; `parameters` takes precedence.
};
/// Loads a component. Returns it (as list_components() does) and "warnings". A container that is not Nacelle's does not
/// configure it.
/// Errors: an invalid parameter or remap rule; the container's refusal.
[[nodiscard]] Result<nlohmann::json, Problem> load_component(Nodes& nodes, const std::string& container,
                                                             const LoadWish& wish);
/// Unloads a component. Returns "id", "node", "library", "image_closed" and "held_by". `name`: id, full name, or name
/// without namespace.
[[nodiscard]] Result<nlohmann::json, Problem> unload_component(Nodes& nodes, const std::string& container,
                                                               const std::string& name);

/// Returns "id" (of the component; 0: unknown), "node", "state" and "state_id". Errors: a node without a lifecycle.
[[nodiscard]] Result<nlohmann::json, Problem> lifecycle_state(Nodes& nodes, const std::string& name);
/// Triggers a transition. Returns "node" and "state". Errors: the transition failed; a Nacelle container adds the
/// reason.
[[nodiscard]] Result<nlohmann::json, Problem> change_state(Nodes& nodes, const std::string& name,
                                                           const std::string& transition);

}  // namespace nacelle::ask
