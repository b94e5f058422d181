// SPDX-License-Identifier: Apache-2.0
#include "transport_local/wire/frame.hpp"

#include <algorithm>
#include <cstring>

namespace nacelle::transport_local {
namespace {

constexpr std::string_view kMagic = "NACELINK";
constexpr std::uint32_t kByteOrder = 0x01020304;

template <typename T>
T load(const std::uint8_t* at) {
  T value{};
  std::memcpy(&value, at, sizeof value);
  return value;
}

template <typename T>
void put(Bytes& out, T value) {
  const auto* const bytes = reinterpret_cast<const std::uint8_t*>(&value);
  out.insert(out.end(), bytes, bytes + sizeof value);
}

void put_text(Bytes& out, std::string_view text) {
  put(out, static_cast<std::uint16_t>(text.size()));
  out.insert(out.end(), text.begin(), text.end());
}

/// Reads one field after the other; once one is not there, nothing is.
class Fields {
 public:
  explicit Fields(ByteView bytes) : bytes_(bytes) {}
  template <typename T>
  T number() {
    if (!take(sizeof(T))) return T{};
    return load<T>(bytes_.data() + at_ - sizeof(T));
  }
  std::string text() {
    const auto size = number<std::uint16_t>();
    if (size > kMostTextBytes || !take(size)) {
      good_ = false;
      return {};
    }
    return std::string(as_text(bytes_.subspan(at_ - size, size)));
  }
  Duration duration() {
    const auto ns = number<std::int64_t>();
    if (ns == kBestAvailableDuration.count()) return kBestAvailableDuration;
    if (ns < 0 || ns > kLatestNs) good_ = false;
    return Duration{good_ ? ns : 0};
  }
  std::uint64_t depth() {
    const auto n = number<std::uint64_t>();
    if (n > kDeepestQueue) good_ = false;
    return good_ ? n : 0;
  }
  /// One of the values of a resolved QoS's enumeration.
  template <typename T>
  T choice(std::initializer_list<T> known) {
    const auto value = static_cast<T>(number<std::uint8_t>());
    if (std::find(known.begin(), known.end(), value) == known.end()) good_ = false;
    return good_ ? value : *known.begin();
  }
  bool flag() {
    const auto value = number<std::uint8_t>();
    if (value > 1) good_ = false;
    return value == 1;
  }
  ByteView rest() {
    const ByteView all = bytes_.subspan(at_);
    at_ = bytes_.size();
    return all;
  }
  [[nodiscard]] bool good() const { return good_; }
  [[nodiscard]] bool all_read() const { return good_ && at_ == bytes_.size(); }

 private:
  bool take(std::size_t n) {
    if (!good_ || bytes_.size() - at_ < n) {
      good_ = false;
      return false;
    }
    at_ += n;
    return true;
  }
  ByteView bytes_;
  std::size_t at_ = 0;
  bool good_ = true;
};

QoS read_qos(Fields& fields) {
  QoS qos{1};
  qos.history(fields.choice({History::KeepLast, History::KeepAll}));
  qos.reliability(fields.choice({Reliability::Reliable, Reliability::BestEffort, Reliability::BestAvailable}));
  qos.durability(fields.choice({Durability::Volatile, Durability::TransientLocal, Durability::BestAvailable}));
  qos.liveliness(fields.choice({Liveliness::Automatic, Liveliness::ManualByTopic, Liveliness::BestAvailable}));
  const auto depth = fields.depth();
  if (qos.history() == History::KeepAll) {
    qos.keep_all();
  } else {
    qos.keep_last(std::max<std::uint64_t>(1, depth));
  }
  qos.max_samples(std::max<std::uint64_t>(1, fields.depth()));
  qos.deadline(fields.duration());
  qos.lifespan(fields.duration());
  qos.liveliness_lease_duration(fields.duration());
  return qos;
}

void put_qos(Bytes& out, const QoS& given) {
  const QoS qos = given.resolved();
  put(out, qos.history());
  put(out, qos.reliability());
  put(out, qos.durability());
  put(out, qos.liveliness());
  put(out, std::min<std::uint64_t>(kDeepestQueue, qos.depth()));
  put(out, std::min<std::uint64_t>(kDeepestQueue, qos.max_samples()));
  for (const Duration time : {qos.deadline(), qos.lifespan(), qos.liveliness_lease_duration()}) put(out, time.count());
}

}  // namespace

const char* to_text(LinkFault fault) {
  switch (fault) {
    case LinkFault::TooLong: return "it announces a frame that is longer than a link carries";
    case LinkFault::UnknownKind: return "it sent a frame of an unknown kind";
    case LinkFault::NoHello: return "its first frame, and only that, must be a greeting";
    case LinkFault::OtherVersion: return "it speaks another version of the link";
    case LinkFault::BadHello: return "its greeting is not that of a link";
    case LinkFault::BadFrame: return "it sent a frame whose fields do not fit";
  }
  return "?";
}

bool is_known(LinkFrameKind kind) {
  switch (kind) {
    case LinkFrameKind::Hello:
    case LinkFrameKind::Writer:
    case LinkFrameKind::Reader:
    case LinkFrameKind::Gone:
    case LinkFrameKind::Gate:
    case LinkFrameKind::Life:
    case LinkFrameKind::Data:
    case LinkFrameKind::Taken:
    case LinkFrameKind::Lost:
    case LinkFrameKind::Carry:
    case LinkFrameKind::Note:
    case LinkFrameKind::Service:
    case LinkFrameKind::ServiceGone:
    case LinkFrameKind::ServiceReady:
    case LinkFrameKind::Call:
    case LinkFrameKind::Answer: return true;
  }
  return false;
}

Result<std::optional<LinkFrame>, LinkFault> LinkFrameReader::next() {
  auto frame = FrameReader::next([this](LinkFrameKind kind) {
    return greeted_ == (kind == LinkFrameKind::Hello) ? std::optional{LinkFault::NoHello} : std::nullopt;
  });
  if (frame && frame.value()) greeted_ = true;
  return frame;
}

// --- reading ------------------------------------------------------------------------------------------------------------

Result<HelloFrame, LinkFault> read_hello(ByteView payload) {
  if (payload.size() < kMagic.size() || as_text(payload.first(kMagic.size())) != kMagic)
    return err(LinkFault::BadHello);
  Fields fields{payload.subspan(kMagic.size())};
  const bool same = fields.number<std::uint16_t>() == kLinkVersion && fields.number<std::uint32_t>() == kByteOrder;
  if (fields.good() && !same) return err(LinkFault::OtherVersion);
  HelloFrame hello;
  hello.token = fields.number<std::uint64_t>();
  hello.carrier = fields.text();
  if (!fields.all_read()) return err(LinkFault::BadHello);
  return hello;
}

std::optional<EndpointFrame> read_endpoint(const LinkFrame& frame) {
  Fields fields{frame.payload};
  EndpointFrame endpoint;
  endpoint.is_writer = frame.kind == LinkFrameKind::Writer;
  endpoint.id = fields.number<std::uint64_t>();
  endpoint.open = fields.flag();
  endpoint.qos = read_qos(fields);
  endpoint.topic = fields.text();
  endpoint.type = fields.text();
  endpoint.hash = fields.text();
  endpoint.node = fields.text();
  endpoint.command_timeout = fields.duration();
  endpoint.command_parameter = fields.text();
  endpoint.announced = fields.choice({Announced::Always, Announced::ByDefault, Announced::WithItsPublisher});
  if (fields.flag()) endpoint.unless_offered = read_qos(fields);
  if (!fields.all_read() || endpoint.id == 0 || endpoint.topic.empty() || endpoint.type.empty()) return std::nullopt;
  return endpoint;
}

std::optional<std::uint64_t> read_id(ByteView payload) {
  if (payload.size() != 8) return std::nullopt;
  return load<std::uint64_t>(payload.data());
}

std::optional<std::pair<std::uint64_t, std::uint8_t>> read_id_and_byte(ByteView payload) {
  if (payload.size() != 9) return std::nullopt;
  return std::pair{load<std::uint64_t>(payload.data()), payload[8]};
}

std::optional<std::pair<std::uint64_t, std::uint64_t>> read_id_and_count(ByteView payload) {
  if (payload.size() != 16) return std::nullopt;
  return std::pair{load<std::uint64_t>(payload.data()), load<std::uint64_t>(payload.data() + 8)};
}

std::optional<LostFrame> read_lost(ByteView payload) {
  Fields fields{payload};
  LostFrame lost;
  for (auto* value : {&lost.reader, &lost.overwritten, &lost.full, &lost.expired, &lost.inactive})
    *value = fields.number<std::uint64_t>();
  if (!fields.all_read()) return std::nullopt;
  return lost;
}

std::optional<ServiceFrame> read_service(ByteView payload) {
  Fields fields{payload};
  ServiceFrame service;
  service.id = fields.number<std::uint64_t>();
  service.is_server = fields.flag();
  service.open = fields.flag();
  for (auto* text : {&service.name, &service.node, &service.request, &service.request_hash, &service.response,
                     &service.response_hash})
    *text = fields.text();
  if (!fields.all_read() || service.id == 0 || service.name.empty() || service.request.empty()) return std::nullopt;
  return service;
}

std::optional<CallFrame> read_call(ByteView payload) {
  Fields fields{payload};
  CallFrame call;
  call.end = fields.number<std::uint64_t>();
  call.number = fields.number<std::uint64_t>();
  call.cdr = fields.rest();
  if (!fields.good() || call.cdr.size() > kLongestServiceBytes) return std::nullopt;
  return call;
}

std::optional<AnswerFrame> read_answer(ByteView payload) {
  Fields fields{payload};
  AnswerFrame answer;
  answer.number = fields.number<std::uint64_t>();
  answer.answered = fields.flag();
  answer.cdr = fields.rest();
  if (!fields.good() || answer.cdr.size() > kLongestServiceBytes) return std::nullopt;
  if (!answer.answered && !answer.cdr.empty()) return std::nullopt;
  return answer;
}

std::optional<DataFrame> read_data(ByteView payload, std::vector<std::uint64_t>& readers) {
  Fields fields{payload};
  DataFrame data;
  data.writer = fields.number<std::uint64_t>();
  data.sequence = fields.number<std::uint64_t>();
  data.source_ns = fields.number<std::int64_t>();
  data.expires_ns = fields.number<std::int64_t>();
  const std::size_t count = fields.number<std::uint16_t>();
  readers.clear();
  if (count == 0 || count > kMostReaders) return std::nullopt;
  for (std::size_t i = 0; i < count && fields.good(); ++i) readers.push_back(fields.number<std::uint64_t>());
  if (!fields.good() || data.source_ns < 0 || data.source_ns > kLatestNs) return std::nullopt;
  data.cdr = fields.rest();
  return data;
}

// --- writing ------------------------------------------------------------------------------------------------------------

void append_hello(Bytes& out, std::string_view carrier, std::uint64_t token) {
  const std::size_t begin = begin_frame(out, LinkFrameKind::Hello);
  out.insert(out.end(), kMagic.begin(), kMagic.end());
  put(out, kLinkVersion);
  put(out, kByteOrder);
  put(out, token);
  put_text(out, carrier.substr(0, kMostTextBytes));
  end_frame(out, begin);
}

void append_endpoint(Bytes& out, const EndpointFrame& endpoint) {
  const std::size_t begin = begin_frame(out, endpoint.is_writer ? LinkFrameKind::Writer : LinkFrameKind::Reader);
  put(out, endpoint.id);
  put(out, static_cast<std::uint8_t>(endpoint.open));
  put_qos(out, endpoint.qos);
  put_text(out, endpoint.topic);
  put_text(out, endpoint.type);
  put_text(out, endpoint.hash);
  put_text(out, endpoint.node);
  put(out, endpoint.command_timeout.count());
  put_text(out, endpoint.command_parameter);
  put(out, endpoint.announced);
  put(out, static_cast<std::uint8_t>(endpoint.unless_offered.has_value()));
  if (endpoint.unless_offered) put_qos(out, *endpoint.unless_offered);
  end_frame(out, begin);
}

void append_id(Bytes& out, LinkFrameKind kind, std::uint64_t id) {
  const std::size_t begin = begin_frame(out, kind);
  put(out, id);
  end_frame(out, begin);
}

void append_id_and_byte(Bytes& out, LinkFrameKind kind, std::uint64_t id, std::uint8_t byte) {
  const std::size_t begin = begin_frame(out, kind);
  put(out, id);
  put(out, byte);
  end_frame(out, begin);
}

void append_id_and_count(Bytes& out, LinkFrameKind kind, std::uint64_t id, std::uint64_t count) {
  const std::size_t begin = begin_frame(out, kind);
  put(out, id);
  put(out, count);
  end_frame(out, begin);
}

void append_lost(Bytes& out, const LostFrame& lost) {
  const std::size_t begin = begin_frame(out, LinkFrameKind::Lost);
  for (const auto value : {lost.reader, lost.overwritten, lost.full, lost.expired, lost.inactive}) put(out, value);
  end_frame(out, begin);
}

void append_note(Bytes& out, ByteView note) { append_frame(out, LinkFrameKind::Note, as_text(note)); }

void append_service(Bytes& out, const ServiceFrame& service) {
  const std::size_t begin = begin_frame(out, LinkFrameKind::Service);
  put(out, service.id);
  put(out, static_cast<std::uint8_t>(service.is_server));
  put(out, static_cast<std::uint8_t>(service.open));
  for (const auto* text : {&service.name, &service.node, &service.request, &service.request_hash, &service.response,
                           &service.response_hash})
    put_text(out, *text);
  end_frame(out, begin);
}

std::uint8_t* append_call(Bytes& out, std::uint64_t end, std::uint64_t number, std::size_t cdr_bytes) {
  const std::size_t begin = begin_frame(out, LinkFrameKind::Call);
  put(out, end);
  put(out, number);
  out.resize(out.size() + cdr_bytes);
  end_frame(out, begin);
  return out.data() + out.size() - cdr_bytes;
}

std::uint8_t* append_answer(Bytes& out, std::uint64_t number, std::size_t cdr_bytes) {
  const std::size_t begin = begin_frame(out, LinkFrameKind::Answer);
  put(out, number);
  put(out, std::uint8_t{1});
  out.resize(out.size() + cdr_bytes);
  end_frame(out, begin);
  return out.data() + out.size() - cdr_bytes;
}

void append_no_answer(Bytes& out, std::uint64_t number) { append_id_and_byte(out, LinkFrameKind::Answer, number, 0); }

std::uint8_t* append_data(Bytes& out, const DataFrame& head, const std::vector<std::uint64_t>& readers,
                          std::size_t cdr_bytes) {
  const std::size_t begin = begin_frame(out, LinkFrameKind::Data);
  put(out, head.writer);
  put(out, head.sequence);
  put(out, head.source_ns);
  put(out, head.expires_ns);
  put(out, static_cast<std::uint16_t>(readers.size()));
  for (const auto reader : readers) put(out, reader);
  out.resize(out.size() + cdr_bytes);
  end_frame(out, begin);
  return out.data() + out.size() - cdr_bytes;
}

}  // namespace nacelle::transport_local
