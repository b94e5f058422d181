// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "element.hpp"
#include "nacelle/launch/launch_fault.hpp"
#include "nacelle/launch/load_plan.hpp"
#include "nacelle/launch/plan.hpp"

namespace nacelle::launch {

// Above any robot's needs, and low enough that a hostile file costs no more than a large honest one.
inline constexpr std::size_t kMaxActions = 1000;
inline constexpr std::size_t kMaxEvaluatedBytes = 2U << 20U;

/// A parameter, or a file of them, that a scope or a node lists. Order matters: the later wins.
struct ParameterSource {
  Parameter parameter;                        ///< If there is no file.
  std::shared_ptr<const ParameterFile> file;  ///< Read and without faults.
  std::string path;                           ///< Of the file.
  bool substituted = false;                   ///< The file's text is not what the nodes are to see.
};

/// The command line's argument that every launch file has: network:=off, local or export.
inline constexpr const char* kNetworkArgument = "network";
/// Two more: namespace:=NAME and tf:=topics or frames.
inline constexpr const char* kNamespaceArgument = "namespace";
inline constexpr const char* kTfArgument = "tf";
/// robot_state_publisher's name for it, and ours (nacelle/node/frame_name.hpp).
inline constexpr const char* kFramePrefixParameter = "frame_prefix";

/// What the files are read for.
enum class Wanted : std::uint8_t { Plan, Arguments };

/// What an action sees; a group works on a copy.
struct Scope {
  /// Launch configurations. One without a value is an argument whose absence was reported before.
  std::map<std::string, std::optional<std::string>> variables;
  std::string namespace_ = "/";
  std::map<std::string, std::optional<std::string>> environment;  ///< Set to, or unset.
  std::vector<ParameterSource> parameters;
  std::vector<RemapRule> remaps;
  std::vector<Place> remap_lines;  // beside remaps
};

/// A launch file while it is worked on.
struct File {
  std::string path;
  std::set<std::string> declared;  ///< Arguments of it and of what it includes.
};

/// Walks the elements of all files and fills a plan.
class Builder {
 public:
  Builder(const Environment& environment, const std::map<std::string, std::string>& arguments, Wanted wanted);

  /// Before run_top(). `declared`: the arguments that the files declare, which then mean what the files say.
  void take_namespace_arguments(const std::set<std::string>& declared);
  void run_top(const std::string& text, const std::string& path);
  [[nodiscard]] const std::set<std::string>& declared_arguments() const { return declared_; }
  [[nodiscard]] Result<Plan, std::vector<Problem>> finish();
  void report(const Place& where, LaunchFault fault, std::string what, std::string way_out = {});
  /// The same for a Problem without `where`; one without `what` was reported before.
  void report(const Place& where, Problem problem);

 private:
  struct Target {  // a load_composable_node's
    std::string name;
    Place where;
  };

  // actions.cpp
  void run_file(const std::string& text, const std::string& path, Scope& scope, const std::optional<Place>& from);
  void run_actions(const Element& parent, Scope& scope);
  void run_action(const Element& action, Scope& scope);
  void declare_argument(const Element& element, Scope& scope);
  void include(const Element& element, Scope& scope);
  void group(const Element& element, Scope& scope);
  void program(const Element& element, Scope& scope);
  void container(const Element& element, Scope& scope);
  void load_composable(const Element& element, Scope& scope);

  // components.cpp
  void component(const Element& element, Scope& scope);
  void read_qos(const Element& element, Scope& scope, ComponentPlan& into);
  void read_after(const Element& element, Scope& scope, ComponentPlan& into);
  void read_thread(const Element& element, Scope& scope, ThreadPolicy& into);
  void read_budget(const Element& element, Scope& scope, ComponentPlan& into);
  void read_on_fault(const Element& element, Scope& scope, ComponentPlan& into);

  // network.cpp
  void network(const Element& element, Scope& scope);
  void look(const Element& element, Scope& scope);
  void read_export(const Element& element, Scope& scope);
  void read_security(const Element& element, Scope& scope);
  void add_export(ExportPlan made, const Scope& scope);
  void apply_network_argument();

  // namespace.cpp
  [[nodiscard]] static bool is_for_every_file(const std::string& argument);
  void name_space(const Element& element, Scope& scope);
  void enter_namespace(Scope& scope);
  void note_named(const Place& where);
  /// The node's name without the launch's namespace: as its files write it.
  [[nodiscard]] std::string name_in_files(const std::string& full_name) const;
  void check_namespace();

  /// False, and reported once, when the files ask for too much.
  [[nodiscard]] bool counted(const Element& action);

  // values.cpp
  [[nodiscard]] Place at(int line) const { return {files_.back().path, line}; }
  /// The attribute's text; nothing if it is missing or was reported.
  [[nodiscard]] std::optional<std::string> text(const Element& element, std::string_view attribute, Scope& scope);
  [[nodiscard]] std::optional<std::string> evaluate(const RawText& raw, Scope& scope);
  [[nodiscard]] Result<std::string, Problem> look_up(const std::string& name, const std::vector<std::string>& arguments,
                                                     Scope& scope);
  /// Nothing: it cannot be told, which was reported.
  [[nodiscard]] std::optional<bool> known_flag(const Element& element, std::string_view attribute, Scope& scope);
  [[nodiscard]] bool flag(const Element& element, std::string_view attribute, bool otherwise, Scope& scope);
  [[nodiscard]] std::optional<Duration> duration(const Element& element, std::string_view attribute, Scope& scope);
  [[nodiscard]] std::optional<std::uint64_t> count(const Element& element, std::string_view attribute,
                                                   std::uint64_t most, Scope& scope);
  /// One of the words, as its place in the list.
  [[nodiscard]] std::optional<std::size_t> word(const Element& element, std::string_view attribute,
                                                const std::vector<std::string>& words, Scope& scope);
  [[nodiscard]] bool condition_holds(const Element& element, Scope& scope);
  [[nodiscard]] std::string beside_file(const std::string& path) const;
  /// The text of a file, with its reading reported at `where` if it fails: "the <kind> '<path>' cannot be read: ...".
  [[nodiscard]] std::optional<std::string> read_file(const std::string& path, const char* kind, const Place& where);
  [[nodiscard]] std::vector<std::string> words_of(const Element& element, std::string_view attribute, Scope& scope);

  // parameters.cpp
  void read_parameters(const Element& element, Scope& scope, const std::string& prefix,
                       std::vector<ParameterSource>& into);
  void read_parameter(const Element& param, Scope& scope, const std::string& prefix,
                      std::vector<ParameterSource>& into);
  [[nodiscard]] std::optional<ParameterValue> parameter_value(const Element& element, Scope& scope);
  void read_parameter_file(const Element& element, std::string_view attribute, bool substitute, Scope& scope,
                           std::vector<ParameterSource>& into);
  void substitute_tree(YamlNode& node, const std::string& path, Scope& scope);
  [[nodiscard]] std::vector<Parameter> resolve(const std::vector<ParameterSource>& sources,
                                               const std::string& full_name);
  void note_sections(const ParameterSource& source, const std::string& full_name);
  void read_remaps(const Element& element, Scope& scope, std::vector<RemapRule>& into,
                   std::vector<Place>* lines = nullptr);
  void check_remaps(const ComponentPlan& component);
  [[nodiscard]] std::string node_namespace(const Element& element, Scope& scope);

  // finish.cpp
  void check_names();
  void check_targets();
  void resolve_after();
  void resolve_detail(AfterCondition& condition);
  void find_cycles();
  void check_arguments();

  const Environment& environment_;
  const std::map<std::string, std::string>& arguments_;
  const Wanted wanted_;
  bool lacks_argument_ = false;
  Plan plan_;
  std::vector<Problem> problems_;
  std::vector<File> files_;  // the innermost last
  std::size_t files_read_ = 0;
  std::size_t actions_run_ = 0;
  std::size_t evaluated_bytes_ = 0;
  std::vector<Target> targets_;
  std::set<std::string> declared_;
  std::optional<std::string> namespace_given_;  // on the command line
  bool tf_given_ = false;
  Place declared_namespace_;
  std::optional<Place> first_named_;  // what `namespace` would come too late for
  unsigned groups_ = 0;               // around the action
  Scope outermost_;                   // only what the launch's namespace puts into every scope
  std::map<std::string, std::shared_ptr<const ParameterFile>> parameter_files_;
  std::set<std::string> unreadable_;  // parameter files that were reported
  std::map<std::pair<std::string, std::string>, std::pair<Place, bool>> sections_;  // (path, pattern) -> used
};

/// true/True/TRUE/1 and false/False/FALSE/0, as launch's conditions.
[[nodiscard]] std::optional<bool> parse_condition(std::string_view text);

}  // namespace nacelle::launch
