// SPDX-License-Identifier: Apache-2.0
#include "nacelle/msgs/cdr.hpp"
#include "nacelle/msgs/cdr_apart.hpp"
#include "nacelle/msgs/message_type.hpp"
#include "step_shape.hpp"

#include <algorithm>
#include <cstring>
#include <new>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>

namespace nacelle::msgs {
namespace {

/// The least bytes that a text takes: its length.
constexpr std::size_t kLeastText = 4;

void swap_bytes(void* numbers, std::size_t width, std::size_t count) {
  auto* at = static_cast<std::uint8_t*>(numbers);
  for (std::size_t i = 0; i < count; ++i, at += width) std::reverse(at, at + width);
}

/// Reads one message. Every read is checked against the end; after a fault nothing is read any more, and each function
/// answers false.
class Reader {
 public:
  Reader(ByteView body, bool big_endian, std::span<LentPart> parts = {})
      : body_(body), parts_(parts), big_endian_(big_endian) {}

  bool message(const MessageType& type, std::uint8_t* message) {
    for (const Step& step : type.steps) {
      if (!run(step, message + step.offset)) return false;
    }
    return true;
  }
  [[nodiscard]] std::size_t left() const { return body_.size() - at_; }
  [[nodiscard]] bool has_parts_left() const { return !parts_.empty(); }
  [[nodiscard]] DecodeFault fault() const { return fault_; }

 private:
  bool fail(DecodeFault fault) {
    fault_ = fault;
    return false;
  }

  bool align(std::size_t to) {
    const std::size_t aligned = (at_ + to - 1) & ~(to - 1);
    if (aligned > body_.size()) return fail(DecodeFault::Truncated);
    at_ = aligned;
    return true;
  }

  bool numbers(void* into, std::size_t width, std::size_t count) {
    if (!align(width)) return false;
    if (count > left() / width) return fail(DecodeFault::Truncated);
    if (count == 0) return true;
    std::memcpy(into, body_.data() + at_, count * width);
    at_ += count * width;
    if (big_endian_ && width > 1) swap_bytes(into, width, count);
    return true;
  }

  // A bool in memory that is neither 0 nor 1 is undefined behaviour, so hostile ones are mended here.
  bool bools(void* into, std::size_t count) {
    if (count > left()) return fail(DecodeFault::Truncated);
    auto* const to = static_cast<bool*>(into);
    for (std::size_t i = 0; i < count; ++i) to[i] = body_[at_ + i] != 0;
    at_ += count;
    return true;
  }

  /// Reads a count that is believed only if as many elements of the least size can follow.
  bool count(std::size_t least_element, std::uint32_t bound, std::size_t& n) {
    std::uint32_t announced = 0;
    if (!numbers(&announced, 4, 1)) return false;
    if (announced > left() / least_element) return fail(DecodeFault::ImpossibleCount);
    if (bound != 0 && announced > bound) return fail(DecodeFault::BoundExceeded);
    n = announced;
    return true;
  }

  bool text(std::string& into, std::uint32_t bound) {
    std::uint32_t length = 0;
    if (!numbers(&length, 4, 1)) return false;
    if (length == 0) {
      into.clear();
      return true;
    }
    if (length > left()) return fail(DecodeFault::Truncated);
    const auto* const characters = reinterpret_cast<const char*>(body_.data() + at_);
    if (characters[length - 1] != '\0') return fail(DecodeFault::TextNotTerminated);
    if (bound != 0 && length - 1 > bound) return fail(DecodeFault::BoundExceeded);
    into.assign(characters, length - 1);
    at_ += length;
    return true;
  }

  bool wide_text(std::u16string& into, std::uint32_t bound) {
    std::size_t units = 0;
    if (!count(sizeof(std::uint32_t), 0, units)) return false;
    into.clear();
    into.reserve(units);
    for (std::size_t i = 0; i < units; ++i) {
      std::uint32_t unit = 0;
      if (!numbers(&unit, 4, 1)) return false;
      if (unit <= 0xFFFF) {
        into.push_back(static_cast<char16_t>(unit));
      } else if (unit <= 0x10FFFF) {
        // A peer that keeps UTF-32 in its wide strings (Python does) puts a whole character into one unit.
        into.push_back(static_cast<char16_t>(0xD7C0 + (unit >> 10)));
        into.push_back(static_cast<char16_t>(0xDC00 + (unit & 0x3FF)));
      } else {
        return fail(DecodeFault::BadCharacter);
      }
    }
    if (bound != 0 && into.size() > bound) return fail(DecodeFault::BoundExceeded);
    return true;
  }

  bool messages(const MessageType& type, std::uint8_t* first, std::size_t n) {
    if (const std::size_t width = solid_width(type); width != 0 && n != 0) {
      return numbers(first, width, n * (type.size / width));
    }
    for (std::size_t i = 0; i < n; ++i) {
      if (!message(type, first + i * type.size)) return false;
    }
    return true;
  }

  bool run(const Step& step, std::uint8_t* into) {
    switch (step.kind) {
      case StepKind::Numbers: return numbers(into, step.width, step.count);
      case StepKind::Bools: return bools(into, step.count);
      case StepKind::Texts: return texts(reinterpret_cast<std::string*>(into), step.count, step.text_bound);
      case StepKind::WideTexts: return wide_texts(reinterpret_cast<std::u16string*>(into), step.count, step.text_bound);
      case StepKind::Messages: return messages(step.message(), into, step.count);
      default: return sequence(step, into);
    }
  }

  /// Numbers that may lie apart: what is long enough does while there are parts, as encode_apart() has it.
  bool number_sequence(const Step& step, void* into) {
    std::uint32_t announced = 0;
    if (!numbers(&announced, 4, 1)) return false;
    const std::size_t bytes = std::size_t{announced} * step.width;
    const bool is_apart = bytes >= kLeastPartBytes;
    if (bytes > (is_apart ? parts_.front().bytes : left())) return fail(DecodeFault::ImpossibleCount);
    if (step.bound != 0 && announced > step.bound) return fail(DecodeFault::BoundExceeded);
    // What an earlier message was lent is not written to: others may read it.
    if (step.sequence->give_back != nullptr) step.sequence->give_back(into);
    if (!is_apart) {
      step.sequence->resize_for_decoding(into, announced);
      return announced == 0 || numbers(step.sequence->mutable_data(into), step.width, announced);
    }
    LentPart& part = parts_.front();
    parts_ = parts_.subspan(1);
    if (part.bytes != bytes) return fail(DecodeFault::ImpossibleCount);
    if (part.hook.release != nullptr && step.sequence->adopt != nullptr) {
      step.sequence->adopt(into, part.memory, announced, announced, std::exchange(part.hook, {}));
    } else {
      step.sequence->resize_for_decoding(into, announced);
      std::memcpy(step.sequence->mutable_data(into), part.memory, bytes);
    }
    return true;
  }

  bool sequence(const Step& step, void* into) {
    if (step.kind == StepKind::NumberSequence && !parts_.empty()) return number_sequence(step, into);
    const MessageType* const type = step.kind == StepKind::MessageSequence ? &step.message() : nullptr;
    const bool holds_texts = step.kind == StepKind::TextSequence || step.kind == StepKind::WideTextSequence;
    const std::size_t least = type != nullptr ? type->least_encoded_size : holds_texts ? kLeastText : step.width;
    std::size_t n = 0;
    if (!count(least, step.bound, n)) return false;
    step.sequence->resize_for_decoding(into, n);
    if (n == 0) return true;
    void* const first = step.sequence->mutable_data(into);
    switch (step.kind) {
      case StepKind::NumberSequence: return numbers(first, step.width, n);
      case StepKind::BoolSequence: return bools(first, n);
      case StepKind::TextSequence: return texts(static_cast<std::string*>(first), n, step.text_bound);
      case StepKind::WideTextSequence: return wide_texts(static_cast<std::u16string*>(first), n, step.text_bound);
      default: return messages(step.message(), static_cast<std::uint8_t*>(first), n);
    }
  }

  bool texts(std::string* into, std::size_t n, std::uint32_t bound) {
    return std::all_of(into, into + n, [&](std::string& one) { return text(one, bound); });
  }
  bool wide_texts(std::u16string* into, std::size_t n, std::uint32_t bound) {
    return std::all_of(into, into + n, [&](std::u16string& one) { return wide_text(one, bound); });
  }

  ByteView body_;
  std::span<LentPart> parts_;
  std::size_t at_ = 0;
  bool big_endian_;
  DecodeFault fault_ = DecodeFault::Truncated;
};

std::optional<DecodeFault> read_all(const MessageType& type, ByteView bytes, void* message,
                                    std::span<LentPart> parts = {}) {
  if (bytes.size() < kEncapsulationSize) return DecodeFault::Truncated;
  if (bytes[0] != 0 || bytes[1] > 1) return DecodeFault::UnknownEncoding;
  const bool big_endian = bytes[1] == 0;
  if (big_endian && !parts.empty()) return DecodeFault::UnknownEncoding;
  Reader reader{bytes.subspan(kEncapsulationSize), big_endian, parts};
  if (!reader.message(type, static_cast<std::uint8_t*>(message))) return reader.fault();
  if (reader.left() > kMostPadding || reader.has_parts_left()) return DecodeFault::TrailingBytes;
  return std::nullopt;
}

// Counts are checked against the bytes, so that only a process without memory throws here.
template <typename Read>
Result<void, DecodeFault> guarded(Read read) {
  try {
    if (const auto fault = read()) return err(*fault);
    return {};
  } catch (const std::bad_alloc&) { return err(DecodeFault::OutOfMemory); } catch (const std::length_error&) {
    return err(DecodeFault::OutOfMemory);
  }
}

}  // namespace

Result<void, DecodeFault> decode(const MessageType& type, ByteView bytes, void* message) {
  return guarded([&] { return read_all(type, bytes, message); });
}

Result<void, DecodeFault> decode_apart(const MessageType& type, ByteView bytes, std::span<LentPart> parts,
                                       void* message) {
  return guarded([&] { return read_all(type, bytes, message, parts); });
}

const char* explain(DecodeFault fault) {
  switch (fault) {
    case DecodeFault::Truncated: return "the bytes end before the message does";
    case DecodeFault::UnknownEncoding: return "the bytes do not begin with 00 01 or 00 00 (plain CDR)";
    case DecodeFault::ImpossibleCount: return "a sequence announces more elements than the bytes can hold";
    case DecodeFault::BoundExceeded: return "a sequence or text is longer than its definition allows";
    case DecodeFault::TextNotTerminated: return "a string does not end in a zero byte";
    case DecodeFault::BadCharacter: return "a wide string holds a character above U+10FFFF";
    case DecodeFault::TrailingBytes: return "bytes are left behind the message: is it of another type?";
    case DecodeFault::OutOfMemory: return "there is no memory for a message of that size";
  }
  return "unknown fault";
}

}  // namespace nacelle::msgs
