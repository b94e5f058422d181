// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>

#include "nacelle/node/lifecycle_node.hpp"

namespace nacelle {

/// Grows when Node, LifecycleNode, NodeHost, Block or this header change in a way that old plugins cannot take.
inline constexpr std::uint32_t kComponentAbi = 4;

/// One class that a plugin can make.
struct ComponentClass {
  const char* name = nullptr;  ///< "nacelle::lidar::LidarComponent"
  Node* (*create)(const NodeOptions& options) = nullptr;
  void (*destroy)(Node* node) = nullptr;
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

/// Makes a plugin of the component classes; once per library, at the end of a source file.
#define NACELLE_REGISTER_COMPONENT(Class)                                                                        \
  extern "C" __attribute__((visibility("default"))) const ::nacelle::ComponentTable* nacelle_component_table() { \
    static constexpr ::nacelle::ComponentClass kClasses[] = {                                                    \
        {#Class, [](const ::nacelle::NodeOptions& options) -> ::nacelle::Node* { return new Class(options); },   \
         [](::nacelle::Node* node) { delete node; }}};                                                           \
    static constexpr ::nacelle::ComponentTable kTable{::nacelle::kComponentAbi, 1, kClasses};                    \
    return &kTable;                                                                                              \
  }
