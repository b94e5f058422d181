// SPDX-License-Identifier: Apache-2.0
#include "nacelle/runtime/plugin_library.hpp"

#include <cxxabi.h>
#include <dlfcn.h>
#include <link.h>
#include <sys/stat.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <optional>
#include <span>
#include <sstream>

#include "nacelle/base/files.hpp"
#include "nacelle/base/guarded.hpp"
#include "nacelle/runtime/plugin_fault.hpp"

namespace nacelle::runtime {
namespace {

std::span<const ComponentClass> classes_of(const ComponentTable& table) { return {table.classes, table.class_count}; }

// --- which image belongs to which file ------------------------------------------------------------------------------------

std::int64_t nanoseconds(const timespec& t) { return t.tv_sec * 1'000'000'000 + t.tv_nsec; }

// A file's identity when it was opened. The inode of a mapped file is not reused.
struct FileIdentity {
  dev_t device = 0;
  ino_t inode = 0;
  off_t size = 0;
  std::int64_t modified_ns = 0;
  [[nodiscard]] bool is_same_file(const FileIdentity& other) const {
    return device == other.device && inode == other.inode;
  }
  [[nodiscard]] bool is_same_content(const FileIdentity& other) const {
    return size == other.size && modified_ns == other.modified_ns;
  }
};

struct OpenImage {
  std::string image;  // the path passed to dlopen
  FileIdentity identity;
  std::size_t uses = 0;
};

// For a known path, dlopen returns the existing image, even if the file has been replaced. Therefore a file that was replaced while
// its old image is mapped is opened under another spelling of its path ("/dir/./x.so"), which also preserves $ORIGIN.
class ImageRegistry {
 public:
  /// Returns the spelling to open the file with; release it with leave().
  Result<std::string, Problem> enter(const std::string& file) {
    struct stat status {};
    if (::stat(file.c_str(), &status) != 0)
      return err(Problem{Place(file, 0), std::string("cannot be read: ") + std::strerror(errno), "build or install it",
                         PluginFault::NoLibrary, file});
    const FileIdentity now{status.st_dev, status.st_ino, status.st_size, nanoseconds(status.st_mtim)};
    auto images = images_.lock();
    std::erase_if(*images, [](const OpenImage& i) { return i.uses == 0 && !PluginLibrary::is_mapped(i.image); });
    for (auto& open : *images) {
      if (!open.identity.is_same_file(now)) continue;
      if (!open.identity.is_same_content(now))
        return err(Problem{Place(file, 0), "was overwritten while its code is loaded",
                           "unload what uses it; install libraries as a new file (install, mv), not over the old one",
                           PluginFault::OverwrittenLibrary, file});
      ++open.uses;
      return open.image;
    }
    std::string image = file;
    const auto taken = [&](const OpenImage& open) { return open.image == image; };
    while (std::ranges::any_of(*images, taken)) image.insert(image.rfind('/') + 1, "./");
    images->push_back({image, now, 1});
    return image;
  }
  void leave(const std::string& image) {
    auto images = images_.lock();
    for (auto& open : *images) {
      if (open.image == image) --open.uses;
    }
  }

 private:
  Guarded<std::vector<OpenImage>> images_;
};

ImageRegistry& registry() {
  static ImageRegistry images;  // of the process, as the linker's own list
  return images;
}

// --- what dlopen says -----------------------------------------------------------------------------------------------------

// dlopen names C++ symbols as the linker does: "undefined symbol: _ZN3foo3barEv".
std::string readable(std::string text) {
  const std::string mark = "undefined symbol: ";
  const auto at = text.find(mark);
  if (at == std::string::npos) return text;
  const auto begin = at + mark.size();
  const auto end = std::min(text.find_first_of(" ,()", begin), text.size());
  int status = 0;
  char* const name = abi::__cxa_demangle(text.substr(begin, end - begin).c_str(), nullptr, nullptr, &status);
  if (status == 0) text.replace(begin, end - begin, name);
  std::free(name);
  return text;
}

std::string last_dl_error() {
  const char* const text = dlerror();
  return text != nullptr ? readable(text) : "unknown reason";
}

/// Returns the component ABI that a library's file names; nothing if it names none. For a library that cannot be opened.
std::optional<std::uint32_t> abi_of_file(const std::string& file) {
  constexpr std::size_t kLargestLibrary = std::size_t{64} << 20U;
  const auto bytes = read_regular_file(file, kLargestLibrary);
  if (!bytes) return std::nullopt;
  const std::string_view mark{kComponentAbiMark};
  const auto at = bytes->find(mark);
  if (at == std::string::npos) return std::nullopt;
  std::uint32_t abi = 0;
  const auto [end, fault] = std::from_chars(bytes->data() + at + mark.size(), bytes->data() + bytes->size(), abi);
  return fault == std::errc{} ? std::optional{abi} : std::nullopt;
}

std::string other_abi(const std::string& abi) {
  return "was built for component ABI " + abi + ", this container has " + std::to_string(kComponentAbi);
}
constexpr const char* kBuildAgain = "build it again with the headers of this version";

}  // namespace

Result<std::unique_ptr<PluginLibrary>, Problem> PluginLibrary::open(const std::string& file) {
  auto image = registry().enter(file);
  if (!image) return err(image.error());
  const auto fail = [&](void* handle, PluginFault fault, std::string what, std::string way_out) {
    if (handle != nullptr) dlclose(handle);
    registry().leave(image.value());
    return err(Problem{Place(file, 0), std::move(what), std::move(way_out), fault, file});
  };
  void* const handle = dlopen(image.value().c_str(), RTLD_NOW | RTLD_LOCAL);
  if (handle == nullptr) {
    const std::string why = last_dl_error();
    // The library is fine: the process has no descriptors left.
    const bool is_our_lack =
        why.find(std::strerror(EMFILE)) != std::string::npos || why.find(std::strerror(ENFILE)) != std::string::npos;
    if (const auto abi = abi_of_file(file); !is_our_lack && abi && *abi != kComponentAbi)
      return fail(nullptr, PluginFault::OtherAbi, other_abi(std::to_string(*abi)), kBuildAgain);
    return fail(nullptr, is_our_lack ? PluginFault::TooManyFiles : PluginFault::NotLinked, "cannot be loaded: " + why,
                is_our_lack
                    ? "raise `ulimit -n`, or LimitNOFILE= of the service"
                    : "build or install it for this version of Nacelle (`ldd -r " + file + "` shows what is missing)");
  }
  using Entry = const ComponentTable* (*)();
  const auto entry = reinterpret_cast<Entry>(dlsym(handle, kComponentEntry));
  if (entry == nullptr) {
    return fail(handle, PluginFault::NotAComponentLibrary,
                std::string("is not a component library: it has no symbol ") + kComponentEntry,
                "end one source file with NACELLE_REGISTER_COMPONENT(Class)");
  }
  const ComponentTable* const table = entry();
  if (table == nullptr || table->abi != kComponentAbi) {
    const std::string version = table == nullptr ? "none" : std::to_string(table->abi);
    return fail(handle, PluginFault::OtherAbi, other_abi(version), kBuildAgain);
  }
  return std::unique_ptr<PluginLibrary>(new PluginLibrary(file, image.value(), handle, *table));
}

PluginLibrary::~PluginLibrary() {
  dlclose(handle_);
  registry().leave(image_);
}

const ComponentClass* PluginLibrary::find(const std::string& class_name) const {
  for (const auto& candidate : classes_of(table_)) {
    if (class_name == candidate.name) return &candidate;
  }
  return nullptr;
}

std::vector<std::string> PluginLibrary::class_names() const {
  std::vector<std::string> names;
  for (const auto& candidate : classes_of(table_)) names.emplace_back(candidate.name);
  return names;
}

bool PluginLibrary::is_mapped(const std::string& image) {
  // dlopen with RTLD_NOLOAD would also compare files, and return the image of a newer one.
  const auto compare = [](dl_phdr_info* info, std::size_t, void* wanted) {
    return info->dlpi_name != nullptr && *static_cast<const std::string*>(wanted) == info->dlpi_name ? 1 : 0;
  };
  return dl_iterate_phdr(compare, const_cast<std::string*>(&image)) != 0;
}

// --- the index ------------------------------------------------------------------------------------------------------------

namespace {

// Calls `on_line(class_name, library, line)` for every plugin that an index file names, until it returns true.
template <typename OnLine>
bool any_line_of(const std::filesystem::path& index_file, const OnLine& on_line) {
  std::istringstream lines(read_regular_file(index_file.string()).value_or(""));
  for (std::string line; std::getline(lines, line);) {
    const auto semicolon = line.find(';');
    if (semicolon == std::string::npos) continue;
    if (on_line(line.substr(0, semicolon), line.substr(semicolon + 1), line)) return true;
  }
  return false;
}

std::vector<std::filesystem::path> index_files_of(const std::string& folder) {
  std::error_code ignored;
  std::vector<std::filesystem::path> files;
  for (const auto& file : std::filesystem::directory_iterator(std::filesystem::path(folder) / "index", ignored))
    files.push_back(file.path());
  std::ranges::sort(files);
  return files;
}

}  // namespace

std::vector<std::int64_t> PluginIndex::stamps() const {
  std::vector<std::int64_t> stamps;
  for (const auto& folder : folders_) {
    struct stat status {};
    stamps.push_back(::stat((folder + "/index").c_str(), &status) == 0 ? nanoseconds(status.st_mtim) : 0);
  }
  return stamps;
}

void PluginIndex::read() {
  std::vector<Known> all;
  for (const auto& folder : folders_) {
    for (const auto& file : index_files_of(folder)) {
      any_line_of(file, [&](const std::string& name, const std::string& library, const std::string& line) {
        const auto same = [&](const Known& known) { return known.entry.class_name == name; };
        if (std::ranges::none_of(all, same))
          all.push_back({{name, (std::filesystem::path(folder) / library).string(), file.filename().string()},
                         file.string(),
                         line});
        return false;
      });
    }
  }
  known_ = std::move(all);
}

std::optional<PluginEntry> PluginIndex::find(const std::string& class_name) {
  const LockGuard lock(mutex_);
  const auto known = [&]() NACELLE_REQUIRES(mutex_) {
    return std::ranges::find_if(known_, [&](const Known& k) { return k.entry.class_name == class_name; });
  };
  auto now = stamps();
  if (now == stamps_) {
    // An index file that was written in place does not change the folder's time, so the line itself is checked.
    const auto hit = known();
    if (hit != known_.end() && any_line_of(hit->index_file, [&](const auto&, const auto&, const std::string& line) {
          return line == hit->line;
        }))
      return hit->entry;
  }
  stamps_ = std::move(now);
  read();
  const auto hit = known();
  if (hit == known_.end()) return std::nullopt;
  return hit->entry;
}

std::vector<PluginEntry> PluginIndex::entries() {
  const LockGuard lock(mutex_);
  stamps_ = stamps();
  read();
  std::vector<PluginEntry> all;
  for (const auto& known : known_) all.push_back(known.entry);
  return all;
}

std::vector<std::string> PluginIndex::class_names() {
  std::vector<std::string> names;
  for (auto& entry : entries()) names.push_back(std::move(entry.class_name));
  return names;
}

}  // namespace nacelle::runtime
