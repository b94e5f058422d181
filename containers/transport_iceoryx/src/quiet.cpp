// SPDX-License-Identifier: Apache-2.0
#include "quiet.hpp"

#include <unistd.h>

#include <cstddef>
#include <mutex>
#include <new>
#include <set>
#include <utility>

#include "iceoryx_hoofs/error_handling/error_handling.hpp"
#include "iceoryx_hoofs/log/logmanager.hpp"
#include "iceoryx_posh/internal/runtime/posh_runtime_impl.hpp"
#include "nacelle/base/guarded.hpp"
#include "nacelle/base/log.hpp"

namespace nacelle::transport_iceoryx {
namespace {

// iceoryx has no call that ends its greeting, and destroying the runtime would unmap memory that messages still lie in. An explicit
// instantiation may name a private member: the language's own way in.
template <auto Member>
struct Open {
  friend auto& greeting_of(iox::runtime::PoshRuntimeImpl& runtime) { return runtime.*Member; }
};
template struct Open<&iox::runtime::PoshRuntimeImpl::m_keepAliveTask>;
auto& greeting_of(iox::runtime::PoshRuntimeImpl& runtime);

thread_local const char* this_threads_error = "";
thread_local void (*to_tell)(void*, const char*) = nullptr;
thread_local void* to_tell_context = nullptr;

void note(iox::Error error, iox::ErrorLevel level) {
  static Guarded<std::set<iox::Error>> told;
  // What the writer refuses it explains itself.
  if (error == iox::Error::kMEPOO__MEMPOOL_GETCHUNK_CHUNK_IS_TOO_LARGE ||
      error == iox::Error::kMEPOO__MEMPOOL_GETCHUNK_POOL_IS_RUNNING_OUT_OF_CHUNKS) {
    return;
  }
  if (!told.lock()->insert(error).second) return;
  const Logger log("transport_iceoryx");
  const char* const text = iox::ErrorHandler::toString(error);
  if (level == iox::ErrorLevel::MODERATE) {
    log.warn("iceoryx says {} (said once)", text);
  } else {
    log.error("iceoryx says {} (said once)", text);
  }
}

void handle(iox::Error error, const std::function<void()>& also, iox::ErrorLevel level) {
  this_threads_error = iox::ErrorHandler::toString(error);
  note(error, level);
  if (also) also();
  if (level != iox::ErrorLevel::FATAL || to_tell == nullptr) return;
  to_tell(to_tell_context, this_threads_error);
  while (true) ::pause();
}

}  // namespace

void take_over_errors() {
  static std::once_flag once;
  std::call_once(once, [] {
    iox::log::LogManager::GetLogManager().SetDefaultLogLevel(iox::log::LogLevel::kOff,
                                                             iox::log::LogLevelOutput::kHideLogLevel);
    // The handler stays for the life of the process; the guard that would restore the old one is never destroyed.
    alignas(iox::cxx::GenericRAII) static std::byte guard[sizeof(iox::cxx::GenericRAII)];
    ::new (static_cast<void*>(guard)) iox::cxx::GenericRAII(iox::ErrorHandler::setTemporaryErrorHandler(&handle));
  });
}

const char* last_error() { return std::exchange(this_threads_error, ""); }

void park_this_thread_on_fatal_errors(void (*told)(void* context, const char* error), void* context) {
  to_tell = told;
  to_tell_context = context;
}
void park_no_longer() { to_tell = nullptr; }

void stop_greeting(iox::runtime::PoshRuntime& runtime) {
  greeting_of(static_cast<iox::runtime::PoshRuntimeImpl&>(runtime)).stop();
}

}  // namespace nacelle::transport_iceoryx
