// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "nacelle/base/bytes.hpp"
#include "nacelle/base/frame.hpp"
#include "nacelle/base/result.hpp"
#include "nacelle/qos/announced.hpp"
#include "nacelle/qos/qos.hpp"

namespace nacelle::transport_local {

// What two linked processes say to each other over one stream socket. Both run on one host, so that numbers are the host's own
// little-endian ones and times are CLOCK_MONOTONIC's; the other side is hostile all the same. They are cut into frames by nacelle/base/frame.hpp.
//
//   kind          payload; "text" is u16 length and bytes, "id" is u64
//   Hello      H  "NACELINK", u16 version, u32 0x01020304, u64 token, text carrier ("" = none). The first frame, and only it
//   Writer     W  an endpoint (below)
//   Reader     R  an endpoint
//   Gone       G  id of an announced endpoint
//   Gate       g  id of an announced reader, u8 open
//   Life       L  id of an announced writer with liveliness manual_by_topic
//   Data       D  id of the writer, u64 sequence, i64 source time ns, i64 end of the lifespan ns, u16 number of readers,
//                 their ids, CDR with encapsulation
//   Taken      A  id of an announced KEEP_ALL reader, u64 messages that have left its queue since it was announced
//   Lost       O  id of the peer's reader, u64 overwritten, full, expired, inactive: more than before, on this side of the link
//   Carry      C  id of the writer, u8 step (CarryStep)
//   Note       N  for the owner of the link: any bytes
//   Service    S  id of a server or client, u8 is a server, u8 its node is active, text name, node, type of requests, its hash,
//                 type of responses, its hash. These ids are not those of endpoints
//   ServiceGone   s  id of an announced server or client
//   ServiceReady  r  id of a server or client, u8 ready: its node has become active or not (from the side that announced it), or
//                 the client's service is ready or not (from the other side)
//   Call       Q  id of the server or client that the call goes to or comes from, u64 number of the call, CDR with encapsulation
//   Answer     P  u64 number of the call, u8 1 and CDR with encapsulation, or u8 0: there will be no answer
//
//   endpoint      id, u8 open, qos, text topic, type, type hash, node ("" for a tool),
//                 i64 command timeout in ns (0: none), text its parameter, u8 announced (Announced),
//                 u8 1 and the qos that it leaves to another reader (EndpointSpec::unless_offered), or u8 0
//   qos           u8 history, reliability, durability, liveliness, u64 depth, u64 max_samples,
//                 i64 deadline, lifespan, lease in ns (0: infinite)
inline constexpr std::uint16_t kLinkVersion = 4;
/// Longest payload: a message of 256 MiB. Memory is taken as bytes arrive, not as they are announced.
inline constexpr std::size_t kLongestLinkPayload = std::size_t{256} << 20U;
inline constexpr std::size_t kMostTextBytes = 512;
inline constexpr std::size_t kMostReaders = 4096;
inline constexpr std::uint64_t kDeepestQueue = 1'000'000;
/// Longest request or response. A longer one is refused where it is made.
inline constexpr std::size_t kLongestServiceBytes = std::size_t{16} << 20U;
/// No time on a link is further away: sums of two do not overflow.
inline constexpr std::int64_t kLatestNs = std::int64_t{1} << 61U;

enum class LinkFrameKind : std::uint8_t {
  Hello = 'H',
  Writer = 'W',
  Reader = 'R',
  Gone = 'G',
  Gate = 'g',
  Life = 'L',
  Data = 'D',
  Taken = 'A',
  Lost = 'O',
  Carry = 'C',
  Note = 'N',
  Service = 'S',
  ServiceGone = 's',
  ServiceReady = 'r',
  Call = 'Q',
  Answer = 'P',
};
[[nodiscard]] bool is_known(LinkFrameKind kind);

/// How a stream changes from the socket to a carrier. The writer's side speaks first and waits; there is no way back for this.
enum class CarryStep : std::uint8_t {
  Offer = 0,   ///< Writer's side: everything so far went over the socket, and the carrier is connected.
  Accept = 1,  ///< Reader's side: it has been handed on; from now on the carrier's messages are.
  Open = 2,    ///< Writer's side: make your end of the carrier.
  Close = 3,   ///< Either side: the socket for good; the other drains what the carrier still has.
};

/// Why the peer cannot be understood any more; the link ends.
enum class LinkFault : std::uint8_t {
  TooLong,       ///< A frame is announced as longer than kLongestLinkPayload.
  UnknownKind,   ///< Not one of LinkFrameKind.
  NoHello,       ///< The first frame is no greeting, or it came twice.
  OtherVersion,  ///< Another version of the link, or another byte order.
  BadHello,      ///< A greeting with other bytes than a greeting has.
  BadFrame,      ///< A frame whose fields do not fit its length, or are out of range.
};
[[nodiscard]] const char* to_text(LinkFault fault);

using LinkFrame = FrameView<LinkFrameKind>;

/// Cuts a stream of bytes into frames. The first frame, and only that, is a greeting.
class LinkFrameReader : public FrameReader<LinkFrameKind, LinkFault> {
 public:
  LinkFrameReader() : FrameReader(kLongestLinkPayload) {}
  /// The next whole frame, or nothing if more bytes are needed. After a fault nothing is readable any more.
  [[nodiscard]] Result<std::optional<LinkFrame>, LinkFault> next();

 private:
  bool greeted_ = false;
};

struct HelloFrame {
  std::uint64_t token = 0;  ///< Of this end of the link; no other of the host has it.
  std::string carrier;
};
struct EndpointFrame {
  std::uint64_t id = 0;
  bool is_writer = false;  ///< By the frame's kind.
  bool open = true;
  QoS qos{1};
  std::string topic, type, hash, node;
  Duration command_timeout{};  ///< EndpointSpec::command_timeout.
  std::string command_parameter;
  Announced announced = Announced::Always;  ///< EndpointSpec's, as the next.
  std::optional<QoS> unless_offered{};
};
struct DataFrame {
  std::uint64_t writer = 0, sequence = 0;
  std::int64_t source_ns = 0, expires_ns = 0;
  ByteView cdr;
};
struct ServiceFrame {
  std::uint64_t id = 0;
  bool is_server = false, open = true;
  std::string name, node, request, request_hash, response, response_hash;
};
struct CallFrame {
  std::uint64_t end = 0, number = 0;
  ByteView cdr;
};
struct AnswerFrame {
  std::uint64_t number = 0;
  bool answered = false;
  ByteView cdr;
};
struct LostFrame {
  std::uint64_t reader = 0, overwritten = 0, full = 0, expired = 0, inactive = 0;
};

// Reading. Errors: nothing if the payload is not exactly such a frame.
[[nodiscard]] Result<HelloFrame, LinkFault> read_hello(ByteView payload);
[[nodiscard]] std::optional<EndpointFrame> read_endpoint(const LinkFrame& frame);
[[nodiscard]] std::optional<std::uint64_t> read_id(ByteView payload);  // Gone, Life, ServiceGone
[[nodiscard]] std::optional<std::pair<std::uint64_t, std::uint8_t>> read_id_and_byte(
    ByteView payload);  // Gate, Carry, ServiceReady
[[nodiscard]] std::optional<std::pair<std::uint64_t, std::uint64_t>> read_id_and_count(ByteView payload);  // Taken
[[nodiscard]] std::optional<LostFrame> read_lost(ByteView payload);
[[nodiscard]] std::optional<ServiceFrame> read_service(ByteView payload);
[[nodiscard]] std::optional<CallFrame> read_call(ByteView payload);
[[nodiscard]] std::optional<AnswerFrame> read_answer(ByteView payload);
/// `readers` is filled anew, keeping its memory.
[[nodiscard]] std::optional<DataFrame> read_data(ByteView payload, std::vector<std::uint64_t>& readers);

// Writing: each appends a whole frame.
void append_hello(Bytes& out, std::string_view carrier, std::uint64_t token = 0);
void append_endpoint(Bytes& out, const EndpointFrame& endpoint);
void append_id(Bytes& out, LinkFrameKind kind, std::uint64_t id);
void append_id_and_byte(Bytes& out, LinkFrameKind kind, std::uint64_t id, std::uint8_t byte);
void append_id_and_count(Bytes& out, LinkFrameKind kind, std::uint64_t id, std::uint64_t count);
void append_lost(Bytes& out, const LostFrame& lost);
void append_note(Bytes& out, ByteView note);
void append_service(Bytes& out, const ServiceFrame& service);
// Everything but the CDR, for which they make room: write `cdr_bytes` bytes to what they return.
[[nodiscard]] std::uint8_t* append_call(Bytes& out, std::uint64_t end, std::uint64_t number, std::size_t cdr_bytes);
[[nodiscard]] std::uint8_t* append_answer(Bytes& out, std::uint64_t number, std::size_t cdr_bytes);
/// There will be no answer.
void append_no_answer(Bytes& out, std::uint64_t number);
[[nodiscard]] std::uint8_t* append_data(Bytes& out, const DataFrame& head, const std::vector<std::uint64_t>& readers,
                                        std::size_t cdr_bytes);

}  // namespace nacelle::transport_local
