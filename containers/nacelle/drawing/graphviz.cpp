// SPDX-License-Identifier: Apache-2.0
#include "drawing/graphviz.hpp"

#include <fmt/format.h>
#include <spawn.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <string_view>

#include "nacelle/base/files.hpp"
#include "nacelle/base/xml.hpp"

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

/// A file without a name, for a child's input or output.
struct MemoryFile : File {
  explicit MemoryFile(const char* name) : File(::memfd_create(name, MFD_CLOEXEC)) {}
  bool fill(std::string_view text) const {
    while (!text.empty()) {
      const auto written = ::write(descriptor, text.data(), text.size());
      if (written < 0 && errno == EINTR) continue;
      if (written <= 0) return false;
      text.remove_prefix(static_cast<std::size_t>(written));
    }
    return ::lseek(descriptor, 0, SEEK_SET) == 0;
  }
  [[nodiscard]] std::string text() const {
    std::string all;
    std::array<char, 4096> part{};
    for (ssize_t got = 0; (got = ::pread(descriptor, part.data(), part.size(), static_cast<off_t>(all.size()))) > 0;)
      all.append(part.data(), static_cast<std::size_t>(got));
    return all;
  }
};

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
  std::string out = xml_escaped(text);
  for (char& c : out) c = static_cast<unsigned char>(c) < ' ' ? '?' : c;
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
  const auto written = [](const std::string& file, std::string_view text,
                          std::string remark) -> Result<std::string, Problem> {
    if (auto done = write_whole_file(file, text); !done) return err(done.error());
    return remark;
  };
  const std::string format = drawing_format(path).value_or("dot");
  if (format == "dot") return written(path, dot_text, "");
  const MemoryFile input{"input"}, drawing{"drawing"}, complaints{"complaints"};
  if (input.descriptor < 0 || drawing.descriptor < 0 || complaints.descriptor < 0 || !input.fill(dot_text))
    return err(Problem{path, fmt::format("cannot be drawn: {}", std::strerror(errno)),
                       "write FILE.dot and draw that yourself"});
  switch (run_dot(format, input.descriptor, drawing.descriptor, complaints.descriptor)) {
    case Ending::Drawn: return written(path, drawing.text(), "");
    case Ending::NotInstalled: {
      const std::string beside = std::filesystem::path(path).replace_extension(".dot").string();
      return written(
          beside, dot_text,
          fmt::format("wrote {0}: Graphviz, which draws it, is not installed; run `apt install graphviz`, then "
                      "`dot -T{1} {0} -o {2}`",
                      beside, format, path));
    }
    case Ending::Failed: break;
  }
  const std::string words = complaints.text();
  return err(Problem{path, words.empty() ? "`dot` failed" : "`dot` failed: " + words.substr(0, words.find('\n')),
                     "write FILE.dot and draw that yourself"});
}

}  // namespace nacelle::drawing
