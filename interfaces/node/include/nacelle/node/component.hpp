// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <iterator>

#include "nacelle/node/lifecycle_node.hpp"

// Grows when Node, LifecycleNode, NodeHost, Block or this header change in a way that old plugins cannot take. Macros, so that a
// library has the number as text.
#define NACELLE_COMPONENT_ABI 9
#define NACELLE_COMPONENT_ABI_MARK "@(#)nacelle component ABI "

namespace nacelle {

/// The version of what components are compiled against. A container refuses a component of another one.
inline constexpr std::uint32_t kComponentAbi = NACELLE_COMPONENT_ABI;
/// Stands in front of the number in the library's file, for a library that cannot be linked and so cannot be asked.
inline constexpr const char* kComponentAbiMark = NACELLE_COMPONENT_ABI_MARK;

/// What the reference of components (`nacelle component info --doc`) says of a class beside what its constructor declares.
struct ComponentAbout {
  const char* purpose = "";  ///< What it does, in a sentence or two.
  const char* devices = "";  ///< The devices that it speaks to, and over which line; empty: none.
  /// Parameters of which others depend, as NAME:=VALUE, one a line. The reference also lists what the component has with them:
  /// `topics.NAME.timeout` of a base is declared only where `topics.NAME.topic` is given.
  const char* also_with = "";
};
/// Specialised beside NACELLE_REGISTER_COMPONENT, at global scope:
/// `template <> inline constexpr nacelle::ComponentAbout nacelle::kComponentAbout<a::B>{.purpose = "..."};`
template <typename Class>
inline constexpr ComponentAbout kComponentAbout{};

/// One class that a plugin can make.
struct ComponentClass {
  const char* name = nullptr;  ///< "nacelle::lidar::LidarComponent"
  Node* (*create)(const NodeOptions& options) = nullptr;
  void (*destroy)(Node* node) = nullptr;
  ComponentAbout about{};
};

/// What a plugin library tells about itself.
struct ComponentTable {
  std::uint32_t abi = kComponentAbi;
  std::size_t class_count = 0;
  const ComponentClass* classes = nullptr;
};

/// The one symbol that a plugin exports.
inline constexpr const char* kComponentEntry = "nacelle_component_table";

}  // namespace nacelle

// Applies NACELLE_COMPONENT_CLASS to up to 27 classes. Source: the recursion that __VA_OPT__ allows (C++20).
#define NACELLE_PARENS ()
#define NACELLE_EXPAND(...) NACELLE_EXPAND_9(NACELLE_EXPAND_9(NACELLE_EXPAND_9(__VA_ARGS__)))
#define NACELLE_EXPAND_9(...) NACELLE_EXPAND_3(NACELLE_EXPAND_3(NACELLE_EXPAND_3(__VA_ARGS__)))
#define NACELLE_EXPAND_3(...) NACELLE_EXPAND_1(NACELLE_EXPAND_1(NACELLE_EXPAND_1(__VA_ARGS__)))
#define NACELLE_EXPAND_1(...) __VA_ARGS__
#define NACELLE_EACH_CLASS(Class, ...) \
  NACELLE_COMPONENT_CLASS(Class) __VA_OPT__(NACELLE_EACH_CLASS_AGAIN NACELLE_PARENS(__VA_ARGS__))
#define NACELLE_EACH_CLASS_AGAIN() NACELLE_EACH_CLASS
#define NACELLE_COMPONENT_CLASS(Class)                                                                   \
  {#Class, [](const ::nacelle::NodeOptions& options) -> ::nacelle::Node* { return new Class(options); }, \
   [](::nacelle::Node* node) { delete node; }, ::nacelle::kComponentAbout<Class>},

#define NACELLE_TEXT_OF(number) #number
#define NACELLE_COMPONENT_ABI_TEXT(number) NACELLE_COMPONENT_ABI_MARK NACELLE_TEXT_OF(number)

/// Makes a plugin of one or more component classes; once per library, at the end of a source file. The container reads kAbi in the file, so
/// neither compiler nor linker may leave it out.
#define NACELLE_REGISTER_COMPONENT(...)                                                                          \
  extern "C" __attribute__((visibility("default"))) const ::nacelle::ComponentTable* nacelle_component_table() { \
    [[gnu::used, gnu::retain]] static constexpr char kAbi[] = NACELLE_COMPONENT_ABI_TEXT(NACELLE_COMPONENT_ABI); \
    static constexpr ::nacelle::ComponentClass kClasses[] = {NACELLE_EXPAND(NACELLE_EACH_CLASS(__VA_ARGS__))};   \
    static constexpr ::nacelle::ComponentTable kTable{NACELLE_COMPONENT_ABI, std::size(kClasses), kClasses};     \
    return &kTable;                                                                                              \
  }
