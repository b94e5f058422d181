// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace nacelle::transport_dds {

/// Brings what Cyclone has to say into Nacelle's log, at most twenty lines in ten seconds, and one line once a
/// minute: a peer can make it say something with each packet. Once in a process is enough; it stays so.
void redirect_cyclone_log();

/// While it lives, errors and warnings of this thread are collected here instead: what Cyclone says of a call that
/// fails.
/// Threads: the one that made it.
class CapturedLog {
 public:
  CapturedLog();
  ~CapturedLog();
  CapturedLog(const CapturedLog&) = delete;
  CapturedLog& operator=(const CapturedLog&) = delete;
  /// Lines joined by "; ", without their ends.
  [[nodiscard]] const std::string& text() const { return text_; }

 private:
  std::string text_;
};

}  // namespace nacelle::transport_dds
