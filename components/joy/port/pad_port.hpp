// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "joy/model/pad_info.hpp"
#include "nacelle/io/byte_stream.hpp"

namespace nacelle::joy {

/// A gamepad: a stream of struct input_event (see joy/protocol), and the state behind it. Nothing is written to it.
class PadPort : public io::ByteStream {
 public:
  /// Reads what the pad has and how it stands now. From the reading thread, or while nothing reads.
  /// Errors: HungUp, NotFound. Allocates: its name and path.
  [[nodiscard]] virtual Result<PadInfo, io::StreamFault> inspect() = 0;
};

}  // namespace nacelle::joy
