// SPDX-License-Identifier: Apache-2.0
#include "nacelle/base/expect.hpp"
#include "nacelle/msgs/cdr.hpp"
#include "nacelle/msgs/cdr_apart.hpp"
#include "nacelle/msgs/message_type.hpp"
#include "step_shape.hpp"

#include <bit>
#include <cstring>
#include <limits>
#include <string>

namespace nacelle::msgs {
namespace {

constexpr std::uint8_t kLittleEndianCdr[kEncapsulationSize] = {0, 1, 0, 0};
static_assert(std::endian::native == std::endian::little, "what is written is the memory's own byte order");

/// Counts what a Writer would write. Positions are offsets in the body.
class Counter {
 public:
  void align(std::size_t to) { at_ = (at_ + to - 1) & ~(to - 1); }
  void copy(const void*, std::size_t bytes) { at_ += bytes; }
  void u32(std::uint32_t) {
    align(4);
    at_ += 4;
  }
  void byte(std::uint8_t) { ++at_; }
  static bool takes_apart(const Step&, const void*, std::size_t) { return false; }
  [[nodiscard]] std::size_t position() const { return at_; }

 private:
  std::size_t at_ = 0;
};

/// Counts what stays, and lists what goes apart.
class ApartCounter : public Counter {
 public:
  explicit ApartCounter(PartList& parts) : parts_(parts) { parts_.count = 0; }
  bool takes_apart(const Step& step, const void* numbers, std::size_t bytes) {
    if (bytes < kLeastPartBytes || parts_.count == kMostParts) return false;
    parts_.parts[parts_.count++] = {numbers, bytes, &step};
    return true;
  }

 private:
  PartList& parts_;
};

class Writer {
 public:
  explicit Writer(std::uint8_t* body) : body_(body) {}
  void align(std::size_t to) {
    while ((at_ & (to - 1)) != 0) body_[at_++] = 0;
  }
  void copy(const void* from, std::size_t bytes) {
    if (bytes == 0) return;  // An empty Buffer has no data pointer to copy from.
    std::memcpy(body_ + at_, from, bytes);
    at_ += bytes;
  }
  void u32(std::uint32_t value) {
    align(4);
    copy(&value, sizeof value);
  }
  void byte(std::uint8_t value) { body_[at_++] = value; }
  static bool takes_apart(const Step&, const void*, std::size_t) { return false; }

 private:
  std::uint8_t* body_;
  std::size_t at_ = 0;
};

class ApartWriter : public Writer {
 public:
  explicit ApartWriter(std::uint8_t* body) : Writer(body) {}
  bool takes_apart(const Step&, const void*, std::size_t bytes) {
    if (bytes < kLeastPartBytes || parts_ == kMostParts) return false;
    ++parts_;
    return true;
  }

 private:
  std::size_t parts_ = 0;
};

std::uint32_t as_count(std::size_t n) {
  NACELLE_EXPECT(n <= std::numeric_limits<std::uint32_t>::max(), "CDR counts elements in 32 bits");
  return static_cast<std::uint32_t>(n);
}

template <typename Sink>
void put_text(Sink& sink, const std::string& text) {
  sink.u32(as_count(text.size() + 1));
  sink.copy(text.data(), text.size());
  sink.byte(0);
}

template <typename Sink>
void put_wide_text(Sink& sink, const std::u16string& text) {
  sink.u32(as_count(text.size()));
  for (const char16_t unit : text) sink.u32(unit);
}

template <typename Sink>
void put_message(Sink& sink, const MessageType& type, const std::uint8_t* message);

template <typename Sink>
void put_messages(Sink& sink, const MessageType& type, const std::uint8_t* first, std::size_t count) {
  if (const std::size_t width = solid_width(type); width != 0 && count != 0) {
    sink.align(width);
    sink.copy(first, count * type.size);
    return;
  }
  for (std::size_t i = 0; i < count; ++i) put_message(sink, type, first + i * type.size);
}

template <typename Sink>
void put_message(Sink& sink, const MessageType& type, const std::uint8_t* message) {
  for (const Step& step : type.steps) {
    const std::uint8_t* const from = message + step.offset;
    switch (step.kind) {
      case StepKind::Numbers:
        sink.align(step.width);
        sink.copy(from, std::size_t{step.width} * step.count);
        break;
      case StepKind::Bools: sink.copy(from, step.count); break;
      case StepKind::Texts:
        for (std::size_t i = 0; i < step.count; ++i) put_text(sink, reinterpret_cast<const std::string*>(from)[i]);
        break;
      case StepKind::WideTexts:
        for (std::size_t i = 0; i < step.count; ++i) {
          put_wide_text(sink, reinterpret_cast<const std::u16string*>(from)[i]);
        }
        break;
      case StepKind::Messages: put_messages(sink, step.message(), from, step.count); break;
      case StepKind::NumberSequence:
      case StepKind::BoolSequence: {
        const std::size_t count = step.sequence->size(from);
        sink.u32(as_count(count));
        if (count == 0) break;  // Nothing follows an empty sequence, not even its elements' alignment.
        if (step.kind == StepKind::NumberSequence &&
            sink.takes_apart(step, step.sequence->data(from), count * step.width)) {
          break;
        }
        sink.align(step.width);
        sink.copy(step.sequence->data(from), count * step.width);
        break;
      }
      case StepKind::TextSequence:
      case StepKind::WideTextSequence: {
        const std::size_t count = step.sequence->size(from);
        sink.u32(as_count(count));
        const void* const texts = step.sequence->data(from);
        for (std::size_t i = 0; i < count; ++i) {
          if (step.kind == StepKind::TextSequence) {
            put_text(sink, static_cast<const std::string*>(texts)[i]);
          } else {
            put_wide_text(sink, static_cast<const std::u16string*>(texts)[i]);
          }
        }
        break;
      }
      case StepKind::MessageSequence: {
        const std::size_t count = step.sequence->size(from);
        sink.u32(as_count(count));
        put_messages(sink, step.message(), static_cast<const std::uint8_t*>(step.sequence->data(from)), count);
        break;
      }
    }
  }
}

}  // namespace

std::size_t encoded_size(const MessageType& type, const void* message) {
  Counter counter;
  put_message(counter, type, static_cast<const std::uint8_t*>(message));
  return kEncapsulationSize + counter.position();
}

void encode(const MessageType& type, const void* message, std::uint8_t* out) {
  std::memcpy(out, kLittleEndianCdr, kEncapsulationSize);
  Writer writer{out + kEncapsulationSize};
  put_message(writer, type, static_cast<const std::uint8_t*>(message));
}

std::size_t encoded_size_apart(const MessageType& type, const void* message, PartList& parts) {
  ApartCounter counter{parts};
  put_message(counter, type, static_cast<const std::uint8_t*>(message));
  return kEncapsulationSize + counter.position();
}

void encode_apart(const MessageType& type, const void* message, std::uint8_t* out) {
  std::memcpy(out, kLittleEndianCdr, kEncapsulationSize);
  ApartWriter writer{out + kEncapsulationSize};
  put_message(writer, type, static_cast<const std::uint8_t*>(message));
}

}  // namespace nacelle::msgs
