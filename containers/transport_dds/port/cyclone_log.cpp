// SPDX-License-Identifier: Apache-2.0
#include "transport_dds/port/cyclone_log.hpp"

#include <dds/ddsrt/log.h>

#include <array>
#include <functional>
#include <string_view>

#include "nacelle/base/log.hpp"
#include "nacelle/base/mutex.hpp"
#include "nacelle/base/time.hpp"

namespace nacelle::transport_dds {
namespace {

thread_local std::string* captured = nullptr;

/// Counts recent log lines. Cyclone logs from any thread.
class Flow {
 public:
  /// Returns false if there were too many lines, or the same line was logged just before. `silent`: lines that were
  /// left out before this one.
  [[nodiscard]] bool admits(std::string_view line, MonotonicTime now, unsigned& silent) {
    const LockGuard lock(mutex_);
    if (is_repeated(std::hash<std::string_view>{}(line), now)) {
      ++left_out_;
      return false;
    }
    if (now - begin_ >= 10s) {
      begin_ = now;
      said_ = 0;
    }
    if (said_ == kMost) {
      ++left_out_;
      return false;
    }
    ++said_;
    silent = left_out_;
    left_out_ = 0;
    return true;
  }

 private:
  struct Said {
    std::size_t line = 0;
    MonotonicTime when{};
  };

  // A participant with a foreign certificate is refused once a second, as long as it retries.
  [[nodiscard]] bool is_repeated(std::size_t line, MonotonicTime now) NACELLE_REQUIRES(mutex_) {
    for (const Said& one : recent_) {
      if (one.line == line && one.when != MonotonicTime{} && now - one.when < 60s) return true;
    }
    recent_[next_++ % recent_.size()] = {line, now};
    return false;
  }

  static constexpr unsigned kMost = 20;
  Mutex mutex_;
  MonotonicTime begin_ NACELLE_GUARDED_BY(mutex_){};
  unsigned said_ NACELLE_GUARDED_BY(mutex_) = 0, left_out_ NACELLE_GUARDED_BY(mutex_) = 0;
  std::array<Said, 8> recent_ NACELLE_GUARDED_BY(mutex_);
  std::size_t next_ NACELLE_GUARDED_BY(mutex_) = 0;
};

std::string_view line_of(const dds_log_data_t& data) {
  std::string_view line{data.message, data.size};
  while (!line.empty() && (line.back() == '\n' || line.back() == '\0')) line.remove_suffix(1);
  return line;
}

void write(void* flow, const dds_log_data_t* data) {
  const std::string_view line = line_of(*data);
  const bool trouble = (data->priority & (DDS_LC_FATAL | DDS_LC_ERROR | DDS_LC_WARNING)) != 0;
  if (captured != nullptr && trouble) {
    if (!captured->empty()) *captured += "; ";
    *captured += line;
    return;
  }
  static const Logger log{"dds"};
  unsigned silent = 0;
  if (!static_cast<Flow*>(flow)->admits(line, SystemClock{}.now(), silent)) return;
  if (silent != 0) log.warn("{} lines of Cyclone DDS were left out", silent);
  if ((data->priority & (DDS_LC_FATAL | DDS_LC_ERROR)) != 0) {
    log.error("{}", line);
  } else if (trouble) {
    log.warn("{}", line);
  } else {
    log.debug("{}", line);
  }
}

}  // namespace

void redirect_cyclone_log() {
  // Never taken back: Cyclone's threads may log until the process ends.
  static Flow* const flow = [] {
    auto* const made = new Flow;
    dds_set_log_sink(write, made);
    return made;
  }();
  static_cast<void>(flow);
}

CapturedLog::CapturedLog() { captured = &text_; }
CapturedLog::~CapturedLog() { captured = nullptr; }

}  // namespace nacelle::transport_dds
