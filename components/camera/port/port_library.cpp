// SPDX-License-Identifier: Apache-2.0
#include "camera/port/port_library.hpp"

#include <dlfcn.h>
#include <link.h>

#include <filesystem>
#include <string_view>

#include "camera/port/camera_fault.hpp"

namespace nacelle::camera {
namespace {

/// Stands for a port whose library is not there.
class UnavailablePort final : public CapturePort {
 public:
  explicit UnavailablePort(std::string why) : why_(std::move(why)) {}
  [[nodiscard]] Result<CaptureFormat, Problem> open(const CaptureWish& wish) override {
    return err(Problem{wish.device, "the port for this kind of camera cannot be loaded: " + why_,
                       "install the package nacelle-libcamera of this version of Nacelle (Debian 13)",
                       CameraFault::NotInstalled});
  }
  [[nodiscard]] Result<void, Problem> start() override {
    return err(Problem{"camera", "is not open", "", CameraFault::NotOpen});
  }
  [[nodiscard]] Result<Frame, CaptureFault> next(MonotonicTime /*deadline*/, ByteSpan /*offered*/) override {
    return err(CaptureFault::Gone);
  }
  void interrupt() noexcept override {}
  void close() override {}
  [[nodiscard]] std::vector<Control> controls() override { return {}; }
  [[nodiscard]] Result<void, Problem> set_control(const Control& control, std::int64_t /*value*/) override {
    return err(Problem{"camera", "has no control " + control.name, "", CameraFault::NoControl, control.name});
  }
  [[nodiscard]] CaptureStats stats() const override { return {}; }

 private:
  std::string why_;
};

int note_base(dl_phdr_info* info, std::size_t /*size*/, void* found) {
  const std::string_view path = info->dlpi_name == nullptr ? "" : info->dlpi_name;
  if (path.find("/libnacelle_base.so") == std::string_view::npos) return 0;
  *static_cast<std::string*>(found) = path;
  return 1;
}

}  // namespace

std::string port_library_path(const std::string& name) {
  std::string base;
  ::dl_iterate_phdr(&note_base, &base);
  if (base.empty()) return {};
  return (std::filesystem::path{base}.parent_path() / "nacelle" / "ports" / (name + ".so")).string();
}

std::unique_ptr<CapturePort> make_port_of(const std::string& library, const Clock& clock) {
  void* const handle = ::dlopen(library.c_str(), RTLD_NOW | RTLD_LOCAL | RTLD_NODELETE);
  if (handle == nullptr) {
    const char* const why = ::dlerror();
    return std::make_unique<UnavailablePort>(why == nullptr ? library : why);
  }
  const auto entry_of = reinterpret_cast<const PortEntry* (*)()>(::dlsym(handle, kPortSymbol));
  if (entry_of == nullptr) return std::make_unique<UnavailablePort>(library + " is no port of a camera");
  const PortEntry* const entry = entry_of();
  if (entry->abi != kPortAbi) return std::make_unique<UnavailablePort>(library + " is of another version of Nacelle");
  return std::unique_ptr<CapturePort>(entry->make(clock));
}

}  // namespace nacelle::camera
