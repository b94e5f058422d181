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

// The protocol between two linked processes over one stream socket. Both run on one host, so numbers are little-endian
// like the host's, and times are those of CLOCK_MONOTONIC. Received bytes are hostile nevertheless.
// nacelle/base/frame.hpp cuts the stream into frames.
//
//   kind          payload; "text" is u16 length and bytes, "id" is u64
//   Hello      H  "NACELINK", u16 version, u32 0x01020304, u64 token, text carrier ("" = none). The first frame only
//   Writer     W  an endpoint (below)
//   Reader     R  an endpoint
//   Gone       G  id of an announced endpoint
//   Gate       g  id of an announced reader, u8 open
//   Life       L  id of an announced writer with liveliness manual_by_topic
//   Data       D  id of the writer, u64 sequence, i64 source time ns, i64 end of the lifespan ns, u16 number of
//                 readers, their ids, CDR with encapsulation
//   Taken      A  id of an announced KEEP_ALL reader, u64 messages that have left its queue since it was announced
//   Lost       O  id of the peer's reader, u64 overwritten, full, expired, inactive: messages that its stand-in on this
//                 side has lost since the last Lost frame
//   Carry      C  id of the writer, u8 step (CarryStep)
//   Note       N  any bytes, for the owner of the link
//   Service    S  id of a server or client, u8 is a server, u8 its node is active, text name, node, type of requests,
//                 its hash, type of responses, its hash. These ids are not those of endpoints
//   ServiceGone   s  id of an announced server or client
//   ServiceReady  r  id of a server or client, u8 ready. From the announcing side, of a server: whether its node is
//                 active. From the other side, of a client: whether its service is ready
//   Call       Q  id of the server or client that the call goes to or comes from, u64 number of the call, CDR with
//                 encapsulation
//   Answer     P  u64 number of the call, u8 1 and CDR with encapsulation; or u8 0: there will be no answer
//
//   endpoint      id, u8 open, qos, text topic, type, type hash, node ("" for a tool),
//                 i64 command timeout in ns (0: none), text its parameter, u8 announced (Announced),
//                 u8 1 and the qos of EndpointSpec::unless_offered, or u8 0
//   qos           u8 history, reliability, durability, liveliness, u64 depth, u64 max_samples,
//                 i64 deadline, lifespan, lease in ns (0: infinite)
inline constexpr std::uint16_t kLinkVersion = 4;
/// Longest payload of a frame that is accepted. Memory is allocated as bytes arrive, not as they are announced. A link
/// drops messages with more than half as many bytes instead of sending them.
inline constexpr std::size_t kLongestLinkPayload = std::size_t{256} << 20U;
inline constexpr std::size_t kMostTextBytes = 512;
inline constexpr std::size_t kMostReaders = 4096;
inline constexpr std::uint64_t kDeepestQueue = 1'000'000;
/// Longest request or response. The sending side refuses longer ones.
inline constexpr std::size_t kLongestServiceBytes = std::size_t{16} << 20U;
/// Latest source time, and longest duration of a QoS, that a peer may send: the sum of two does not overflow.
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

/// The steps by which a stream changes from the socket to a carrier. The writer's side sends Open, then Offer, and
/// pauses the stream until Accept or Close arrives.
enum class CarryStep : std::uint8_t {
  Offer = 0,   ///< Writer's side: all messages so far went over the socket, and the carrier is connected.
  Accept = 1,  ///< Reader's side: all these messages are delivered; the next ones may use the carrier.
  Open = 2,    ///< Writer's side: asks the peer to make its end of the carrier.
  Close = 3,   ///< Either side: the stream uses the socket permanently. The reader's side drains the carrier first.
};

/// Why a peer breaks the protocol, which ends the link.
enum class LinkFault : std::uint8_t {
  TooLong,       ///< A frame is announced as longer than kLongestLinkPayload.
  UnknownKind,   ///< Not one of LinkFrameKind.
  NoHello,       ///< The first frame is not a greeting, or a later one is.
  OtherVersion,  ///< Another version of the link, or another byte order.
  BadHello,      ///< A greeting without the magic, or with missing or surplus bytes.
  BadFrame,      ///< A frame whose fields do not match its length, are out of range, or exceed a limit.
};
[[nodiscard]] const char* to_text(LinkFault fault);

using LinkFrame = FrameView<LinkFrameKind>;

/// Cuts a stream of bytes into frames. Requires a greeting as the first frame, and as no other.
class LinkFrameReader : public FrameReader<LinkFrameKind, LinkFault> {
 public:
  LinkFrameReader() : FrameReader(kLongestLinkPayload) {}
  /// Returns the next whole frame, or nothing if more bytes are needed. After a fault the reader is unusable.
  [[nodiscard]] Result<std::optional<LinkFrame>, LinkFault> next();

 private:
  bool greeted_ = false;
};

struct HelloFrame {
  std::uint64_t token = 0;  ///< Identifies this end of the link; unique on the host.
  std::string carrier;
};
struct EndpointFrame {
  std::uint64_t id = 0;
  bool is_writer = false;  ///< Given by the frame's kind.
  bool open = true;
  QoS qos{1};
  std::string topic, type, hash, node;
  Duration command_timeout{};  ///< EndpointSpec::command_timeout.
  std::string command_parameter;
  Announced announced = Announced::Always;  ///< As in EndpointSpec, like unless_offered.
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

// Reading. Errors: nothing (read_hello(): a LinkFault) if the payload is not exactly such a frame.
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
/// Replaces the contents of `readers` and keeps its memory.
[[nodiscard]] std::optional<DataFrame> read_data(ByteView payload, std::vector<std::uint64_t>& readers);

// Writing: each function appends a whole frame.
void append_hello(Bytes& out, std::string_view carrier, std::uint64_t token = 0);
void append_endpoint(Bytes& out, const EndpointFrame& endpoint);
void append_id(Bytes& out, LinkFrameKind kind, std::uint64_t id);
void append_id_and_byte(Bytes& out, LinkFrameKind kind, std::uint64_t id, std::uint8_t byte);
void append_id_and_count(Bytes& out, LinkFrameKind kind, std::uint64_t id, std::uint64_t count);
void append_lost(Bytes& out, const LostFrame& lost);
void append_note(Bytes& out, ByteView note);
void append_service(Bytes& out, const ServiceFrame& service);
// These leave room for the CDR: the caller writes `cdr_bytes` bytes to the returned place before `out` changes.
[[nodiscard]] std::uint8_t* append_call(Bytes& out, std::uint64_t end, std::uint64_t number, std::size_t cdr_bytes);
[[nodiscard]] std::uint8_t* append_answer(Bytes& out, std::uint64_t number, std::size_t cdr_bytes);
/// Notifies the peer that there will be no answer.
void append_no_answer(Bytes& out, std::uint64_t number);
[[nodiscard]] std::uint8_t* append_data(Bytes& out, const DataFrame& head, const std::vector<std::uint64_t>& readers,
                                        std::size_t cdr_bytes);

}  // namespace nacelle::transport_local
