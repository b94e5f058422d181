// SPDX-License-Identifier: Apache-2.0
// `namespace:` of a launch file, and the command line's `namespace:=NAME tf:=topics`.
#include <algorithm>

#include "builder.hpp"
#include "nacelle/base/name_fault.hpp"

namespace nacelle::launch {
namespace {

const std::vector<std::string> kWaysApart{"topics", "frames"};

}  // namespace

const char* to_text(TfApart tf) { return kWaysApart[static_cast<std::size_t>(tf)].c_str(); }

std::string NamespacePlan::topic(std::string_view name) const { return join_namespaces(path, name); }

std::string NamespacePlan::frame_prefix() const {
  return moves() && tf == TfApart::Frames ? path.substr(1) + "/" : std::string{};
}

std::string NamespacePlan::frame(const std::string& name) const {
  const std::string prefix = frame_prefix();
  if (prefix.empty() || name.starts_with(prefix)) return name;
  if (name.starts_with('/')) return name.substr(1);
  return name.empty() ? name : prefix + name;
}

bool Builder::is_for_every_file(const std::string& argument) {
  return argument == kNetworkArgument || argument == kNamespaceArgument || argument == kTfArgument;
}

// Known before the files are read, since everything in them is named by it.
void Builder::take_namespace_arguments(const std::set<std::string>& declared) {
  const auto given = [&](const char* name) -> const std::string* {
    const auto found = arguments_.find(name);
    return found == arguments_.end() || declared.contains(name) ? nullptr : &found->second;
  };
  if (const std::string* const path = given(kNamespaceArgument)) {
    namespace_given_ = join_namespaces("/", *path);
    plan_.name_space.where = {"namespace:=" + path->substr(0, 80), 0};
    if (const auto fine = validate_namespace(*namespace_given_); !fine) {
      problems_.push_back({plan_.name_space.where, fine.error().what, fine.error().way_out, NameFault::Invalid});
      namespace_given_ = "/";
    }
    plan_.name_space.path = *namespace_given_;
  }
  if (const std::string* const tf = given(kTfArgument)) {
    const auto found = std::find(kWaysApart.begin(), kWaysApart.end(), *tf);
    tf_given_ = true;
    if (found != kWaysApart.end()) {
      plan_.name_space.tf = static_cast<TfApart>(found - kWaysApart.begin());
    } else {
      const std::string shown = tf->substr(0, 80);
      problems_.push_back({"tf:=" + shown, "'" + shown + "' is no way to keep transforms apart",
                           suggestion(shown, kWaysApart), LaunchFault::WrongValue});
    }
  }
}

void Builder::name_space(const Element& element, Scope& scope) {
  NamespacePlan& made = plan_.name_space;
  if (made.declared) {
    return report(at(element.line), LaunchFault::Twice,
                  "a second 'namespace'; the first is at " + declared_namespace_.text(),
                  "push_ros_namespace moves a part of the nodes");
  }
  made.declared = true;
  declared_namespace_ = at(element.line);
  if (first_named_) {
    return report(at(element.line), LaunchFault::Misplaced,
                  "'namespace' moves all nodes, and what is at " + first_named_->text() + " was read before it",
                  "put it before all that names something");
  }
  if (groups_ != 0)
    return report(at(element.line), LaunchFault::Misplaced, "'namespace' moves all nodes",
                  "put it outside of the group");
  const auto name = text(element, "name", scope);
  const auto tf = word(element, "tf", kWaysApart, scope);
  if (tf && !tf_given_) made.tf = static_cast<TfApart>(*tf);
  if (name && !namespace_given_) {
    made.path = join_namespaces("/", *name);
    made.where = at(element.line);
    if (const auto fine = validate_namespace(made.path); !fine) {
      report(at(element.find("name")->line), fine.error());
      made.path = "/";
    }
  }
  enter_namespace(scope);
}

// The lists hold nothing else yet. A parameter of the file's own comes later and wins; a remap of its own comes later and
// does not, as with set_remap.
void Builder::enter_namespace(Scope& scope) {
  const NamespacePlan& plan = plan_.name_space;
  outermost_ = {};
  outermost_.namespace_ = plan.path;
  if (plan.moves() && plan.tf == TfApart::Frames) {
    outermost_.parameters.push_back({{kFramePrefixParameter, plan.frame_prefix(), plan.where}, nullptr, "", false});
  } else if (plan.moves()) {
    for (const char* const topic : {"/tf", "/tf_static"}) {
      outermost_.remaps.push_back({RemapKind::Topic, "", topic, plan.path + topic});
      outermost_.remap_lines.push_back(plan.where);
    }
  }
  scope.namespace_ = outermost_.namespace_;
  scope.parameters = outermost_.parameters;
  scope.remaps = outermost_.remaps;
  scope.remap_lines = outermost_.remap_lines;
}

void Builder::note_named(const Place& where) {
  if (!first_named_) first_named_ = where;
}

std::string Builder::name_in_files(const std::string& full_name) const {
  const std::string& path = plan_.name_space.path;
  if (!plan_.name_space.moves() || !full_name.starts_with(path + "/")) return full_name;
  return full_name.substr(path.size());
}

void Builder::check_namespace() {
  if (tf_given_ && !plan_.name_space.moves()) {
    problems_.push_back({std::string("tf:=") + to_text(plan_.name_space.tf), "nothing is moved, so transforms stay",
                         "give a namespace, too: namespace:=robot1", LaunchFault::Misplaced});
  }
}

}  // namespace nacelle::launch
