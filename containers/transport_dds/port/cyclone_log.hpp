// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace nacelle::transport_dds {

/// Redirects Cyclone's log to Nacelle's until the process ends. At most twenty lines are logged in ten seconds, and the
/// same line once a minute, because a peer can cause a line with each packet. Further calls have no effect.
void redirect_cyclone_log();

/// Collects the errors and warnings that Cyclone logs on this thread while this object exists: the reasons of a failed
/// call. They are not logged. Do not nest. Threads: the one that made it.
class CapturedLog {
 public:
  CapturedLog();
  ~CapturedLog();
  CapturedLog(const CapturedLog&) = delete;
  CapturedLog& operator=(const CapturedLog&) = delete;
  /// Returns the lines, joined by "; ".
  [[nodiscard]] const std::string& text() const { return text_; }

 private:
  std::string text_;
};

}  // namespace nacelle::transport_dds
