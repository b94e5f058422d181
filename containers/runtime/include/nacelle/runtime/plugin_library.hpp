// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "nacelle/base/mutex.hpp"
#include "nacelle/base/problem.hpp"
#include "nacelle/base/result.hpp"
#include "nacelle/node/component.hpp"

namespace nacelle::runtime {

/// A plugin library in the address space. Ownership: one reference to the image; destroying it gives the reference
/// back.
///
/// A file that was replaced on disk (by rename, as installers and linkers do) is opened as a new image, even while the
/// old one is still mapped. Both exist until the old one's last component and message are gone.
/// Threads: any; no lock is held while code of the library runs.
class PluginLibrary {
 public:
  /// Errors: a PluginFault of the library (plugin_fault.hpp); `where` is the file. The text of NotLinked has dlopen's
  /// reason, with a missing symbol by its C++ name.
  [[nodiscard]] static Result<std::unique_ptr<PluginLibrary>, Problem> open(const std::string& file);
  ~PluginLibrary();
  PluginLibrary(const PluginLibrary&) = delete;
  PluginLibrary& operator=(const PluginLibrary&) = delete;

  [[nodiscard]] const ComponentClass* find(const std::string& class_name) const;
  [[nodiscard]] std::vector<std::string> class_names() const;
  [[nodiscard]] const std::string& file() const { return file_; }
  /// Returns the image's name in the process, which is the same file in /proc/self/maps. Differs from file() for the
  /// later of two generations.
  [[nodiscard]] const std::string& image() const { return image_; }
  /// Returns true if the image is mapped into the process, by this object or another.
  [[nodiscard]] static bool is_mapped(const std::string& image);

 private:
  PluginLibrary(std::string file, std::string image, void* handle, const ComponentTable& table)
      : file_(std::move(file)), image_(std::move(image)), handle_(handle), table_(table) {}
  const std::string file_, image_;
  void* const handle_;
  const ComponentTable& table_;
};

/// One line of a plugin folder's index/.
struct PluginEntry {
  std::string class_name, file;
  std::string package{};  ///< The index file's name.
};

/// The plugins of a list of folders; earlier folders take precedence. <folder>/index/* has lines of "class;library".
///
/// Index files are read again only if a folder's index has changed, or if the file that listed the class before no
/// longer does. Threads: any.
class PluginIndex {
 public:
  explicit PluginIndex(std::vector<std::string> folders) : folders_(std::move(folders)) {}
  [[nodiscard]] std::optional<PluginEntry> find(const std::string& class_name);
  [[nodiscard]] std::vector<std::string> class_names();
  /// Returns all installed plugins, in the order of folders, index files and lines.
  [[nodiscard]] std::vector<PluginEntry> entries();
  [[nodiscard]] const std::vector<std::string>& folders() const { return folders_; }

 private:
  struct Known {
    PluginEntry entry;
    std::string index_file, line;
  };
  [[nodiscard]] std::vector<std::int64_t> stamps() const;
  void read() NACELLE_REQUIRES(mutex_);

  const std::vector<std::string> folders_;
  Mutex mutex_;
  std::vector<std::int64_t> stamps_ NACELLE_GUARDED_BY(mutex_);  // modification times of the index folders, in ns
  std::vector<Known> known_ NACELLE_GUARDED_BY(mutex_);
};

}  // namespace nacelle::runtime
