// SPDX-License-Identifier: Apache-2.0
#include "nacelle/io/byte_stream.hpp"

namespace nacelle::io {

std::string_view explain(StreamFault fault) {
  switch (fault) {
    case StreamFault::HungUp: return "the line hung up (cable pulled, or the other end closed)";
    case StreamFault::ReadFailed: return "reading failed";
    case StreamFault::WriteFailed: return "writing failed";
    case StreamFault::WouldBlock: return "the line does not take bytes";
    case StreamFault::NotFound: return "the device is not there";
    case StreamFault::NotPermitted:
      return "the device is there, but this user may not open it (nacelle doctor names the group)";
    case StreamFault::InUse: return "the device is there, but another program has it open (nacelle doctor names it)";
    case StreamFault::NotUsable: return "the device is there but cannot be opened";
    case StreamFault::NoAnswer: return "no device answers at its address (NAK: wiring, power, or another address?)";
    case StreamFault::BusStuck:
      return "the bus is stuck: a line is held low or another master holds it (wiring, pull-ups; a power cycle frees "
             "it)";
    case StreamFault::LineDown:
      return "the CAN interface is down (`sudo ip link set can0 up type can bitrate 500000`, with the boards' bit "
             "rate)";
    case StreamFault::BusOff:
      return "the CAN controller is off the bus (wiring, termination, bit rate; `ip -details link show can0`)";
  }
  return "unknown fault";
}

}  // namespace nacelle::io
