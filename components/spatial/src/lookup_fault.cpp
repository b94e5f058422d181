// SPDX-License-Identifier: Apache-2.0
#include "nacelle/spatial/lookup_fault.hpp"

#include <fmt/format.h>

namespace nacelle::spatial {
namespace {

std::string seconds(WallTime t) { return fmt::format("{:.6f}", to_seconds(t.since_origin)); }

}  // namespace

std::string LookupFault::text() const {
  if (would_starve) {
    LookupFault plain = *this;
    plain.would_starve = false;
    return plain.text() +
           " Not waited for: this thread feeds the buffer; wait in a component with a thread of its own, or use "
           "TransformWaits.";
  }
  const std::string_view argument = at_fixed ? "fixed_frame" : at_target ? "target_frame" : "source_frame";
  const std::string_view wrong = at_target ? target.view() : source.view();
  const std::string on_the_way =
      fmt::format(", when looking up transform from frame [{}] to frame [{}] (at frame [{}]){}", source.view(),
                  target.view(), broken_at.view(), as_cause(skew));
  switch (error) {
    case TransformError::Lookup:
      return fmt::format("\"{}\" passed to lookupTransform argument {} does not exist.", wrong, argument);
    case TransformError::InvalidArgument:
      return fmt::format("Invalid argument \"{}\" passed to lookupTransform argument {} - in tf2 frame_ids cannot {}",
                         wrong, argument, wrong.empty() ? "be empty" : "start with a '/'");
    case TransformError::Connectivity:
      return fmt::format(
          "Could not find a connection between '{}' and '{}' because they are not part of the same tree. "
          "Tf has two or more unconnected trees.",
          target.view(), source.view());
    case TransformError::ForwardExtrapolation:
      return fmt::format(
          "Lookup would require extrapolation into the future.  Requested time {} but the latest data is at time {}{}",
          seconds(requested), seconds(available), on_the_way);
    case TransformError::BackwardExtrapolation:
      return fmt::format(
          "Lookup would require extrapolation into the past.  Requested time {} but the earliest data is at time {}{}",
          seconds(requested), seconds(available), on_the_way);
    case TransformError::NoDataForExtrapolation:
      return fmt::format("Lookup would require extrapolation at time {}, but only time {} is in the buffer{}",
                         seconds(requested), seconds(available), on_the_way);
    case TransformError::Timeout: return fmt::format("Timed out waiting for the transform{}", on_the_way);
    case TransformError::Extrapolation:
    case TransformError::Transform: break;
  }
  return fmt::format("The tf tree is invalid because it contains a loop{}", on_the_way);
}

std::string_view exception_name(TransformError error) {
  switch (error) {
    case TransformError::Lookup: return "LookupException";
    case TransformError::Connectivity: return "ConnectivityException";
    case TransformError::InvalidArgument: return "InvalidArgumentException";
    case TransformError::Timeout: return "TimeoutException";
    case TransformError::Extrapolation: return "ExtrapolationException";
    case TransformError::BackwardExtrapolation: return "BackwardExtrapolationException";
    case TransformError::ForwardExtrapolation: return "ForwardExtrapolationException";
    case TransformError::NoDataForExtrapolation: return "NoDataForExtrapolationException";
    case TransformError::Transform: break;
  }
  return "TransformException";
}

}  // namespace nacelle::spatial
