// SPDX-License-Identifier: Apache-2.0
#include "nacelle/drawing/graphviz.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <string_view>

extern char** environ;  // NOLINT(readability-redundant-declaration): POSIX has it in no header

namespace nacelle::drawing {
namespace {

constexpr std::array<std::string_view, 4> kFormats{"dot", "svg", "pdf", "png"};

/// A file that is closed when the owner goes.
struct File {
  int descriptor = -1;
  explicit File(int opened) : descriptor(opened) {}
  ~File() {
    if (descriptor >= 0) ::close(descriptor);
  }
  File(const File&) = delete;
  File& operator=(const File&) = delete;
};

bool write_all(int descriptor, std::string_view text) {
  while (!text.empty()) {
    const auto written = ::write(descriptor, text.data(), text.size());
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) return false;
    text.remove_prefix(static_cast<std::size_t>(written));
  }
  return true;
}

Problem not_written(const std::string& path, int code) {
  return {path, fmt::format("the drawing cannot be written: {}", std::strerror(code)),
          "name a file in a folder that this user may write, with space left"};
}

/// Takes the place of `path` when it is complete, and leaves nothing behind when it is not.
class Replacement {
 public:
  explicit Replacement(const std::string& path) : path_(path), beside_(path + ".XXXXXX") {
    file_.descriptor = ::mkostemp(beside_.data(), O_CLOEXEC);
    if (file_.descriptor < 0) code_ = errno;
  }
  ~Replacement() {
    if (file_.descriptor >= 0 && !is_kept_) ::unlink(beside_.c_str());
  }
  Replacement(const Replacement&) = delete;
  Replacement& operator=(const Replacement&) = delete;

  [[nodiscard]] bool is_open() const { return file_.descriptor >= 0; }
  [[nodiscard]] int code() const { return code_; }
  [[nodiscard]] int descriptor() const { return file_.descriptor; }
  bool keep() {
    const mode_t mask = ::umask(0);
    ::umask(mask);
    is_kept_ = ::fchmod(file_.descriptor, 0666 & ~mask) == 0 && ::fsync(file_.descriptor) == 0 &&
               ::rename(beside_.c_str(), path_.c_str()) == 0;
    if (!is_kept_) code_ = errno;
    return is_kept_;
  }

 private:
  const std::string path_;
  std::string beside_;
  File file_{-1};
  int code_ = 0;
  bool is_kept_ = false;
};

Result<void, Problem> write_text(const std::string& path, const std::string& text) {
  Replacement file{path};
  if (!file.is_open()) return err(not_written(path, file.code()));
  if (!write_all(file.descriptor(), text)) return err(not_written(path, errno));
  if (!file.keep()) return err(not_written(path, file.code()));
  return {};
}

std::string first_line_of(int descriptor) {
  std::array<char, 400> text{};
  const auto got = ::pread(descriptor, text.data(), text.size(), 0);
  const std::string_view all{text.data(), got > 0 ? static_cast<std::size_t>(got) : 0};
  return std::string{all.substr(0, all.find('\n'))};
}

enum class Ending { Drawn, NotInstalled, Failed };

/// Runs `dot -Tformat` between three files. No shell sees any name.
Ending run_dot(const std::string& format, int from, int to, int complaints) {
  std::string program = "dot", option = "-T" + format;
  std::array<char*, 3> arguments{program.data(), option.data(), nullptr};
  posix_spawn_file_actions_t actions;
  ::posix_spawn_file_actions_init(&actions);
  ::posix_spawn_file_actions_adddup2(&actions, from, STDIN_FILENO);
  ::posix_spawn_file_actions_adddup2(&actions, to, STDOUT_FILENO);
  ::posix_spawn_file_actions_adddup2(&actions, complaints, STDERR_FILENO);
  pid_t child = 0;
  const int refused = ::posix_spawnp(&child, program.c_str(), &actions, nullptr, arguments.data(), environ);
  ::posix_spawn_file_actions_destroy(&actions);
  if (refused != 0) return refused == ENOENT ? Ending::NotInstalled : Ending::Failed;
  int status = 0;
  while (::waitpid(child, &status, 0) < 0) {
    if (errno != EINTR) return Ending::Failed;
  }
  return WIFEXITED(status) && WEXITSTATUS(status) == 0 ? Ending::Drawn : Ending::Failed;
}

}  // namespace

std::string dot_quoted(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') out += '\\';
    out += c;
  }
  return out + "\"";
}

std::string dot_label_text(const std::string& text) {
  std::string out;
  for (const char c : text) {
    switch (c) {
      case '<': out += "&lt;"; break;
      case '>': out += "&gt;"; break;
      case '&': out += "&amp;"; break;
      case '"': out += "&quot;"; break;
      default: out += static_cast<unsigned char>(c) < ' ' ? '?' : c;
    }
  }
  return out;
}

std::optional<std::string> drawing_format(const std::string& path) {
  for (const std::string_view format : kFormats) {
    const std::string ending = "." + std::string{format};
    if (path.size() > ending.size() && path.ends_with(ending)) return std::string{format};
  }
  return std::nullopt;
}

Result<std::string, Problem> write_drawing(const std::string& path, const std::string& dot_text) {
  const std::string format = drawing_format(path).value_or("dot");
  if (format == "dot") {
    if (auto written = write_text(path, dot_text); !written) return err(written.error());
    return std::string{};
  }
  Replacement drawing{path};
  if (!drawing.is_open()) return err(not_written(path, drawing.code()));
  const File input{::memfd_create("drawing", MFD_CLOEXEC)}, complaints{::memfd_create("complaints", MFD_CLOEXEC)};
  if (input.descriptor < 0 || complaints.descriptor < 0 || !write_all(input.descriptor, dot_text) ||
      ::lseek(input.descriptor, 0, SEEK_SET) != 0)
    return err(not_written(path, errno));
  switch (run_dot(format, input.descriptor, drawing.descriptor(), complaints.descriptor)) {
    case Ending::Drawn:
      if (!drawing.keep()) return err(not_written(path, drawing.code()));
      return std::string{};
    case Ending::NotInstalled: {
      const std::string beside = std::filesystem::path(path).replace_extension(".dot").string();
      if (auto written = write_text(beside, dot_text); !written) return err(written.error());
      return fmt::format(
          "wrote {0}: Graphviz, which draws it, is not installed; run `apt install graphviz`, then "
          "`dot -T{1} {0} -o {2}`",
          beside, format, path);
    }
    case Ending::Failed: break;
  }
  const std::string words = first_line_of(complaints.descriptor);
  return err(Problem{path, words.empty() ? "`dot` failed" : "`dot` failed: " + words,
                     "write FILE.dot and draw that yourself"});
}

}  // namespace nacelle::drawing
