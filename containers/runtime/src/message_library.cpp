// SPDX-License-Identifier: Apache-2.0
#include "message_library.hpp"

#include <dlfcn.h>

#include <set>

#include "nacelle/base/guarded.hpp"

namespace nacelle::runtime {

void pin_library_of(const msgs::MessageType& type) {
  // Entries are never removed, so that an address identifies a type forever.
  static Guarded<std::set<const msgs::MessageType*>> pinned;
  if (pinned.lock()->contains(&type)) return;
  Dl_info info{};
  if (dladdr(reinterpret_cast<const void*>(type.construct), &info) == 0 || info.dli_fname == nullptr) return;
  if (dlopen(info.dli_fname, RTLD_LAZY | RTLD_NOLOAD | RTLD_NODELETE) != nullptr) pinned.lock()->insert(&type);
}

}  // namespace nacelle::runtime
