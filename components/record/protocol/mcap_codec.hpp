// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <limits>
#include <optional>
#include <string_view>
#include <type_traits>

#include "record/protocol/mcap_records.hpp"

namespace nacelle::record {

/// Appends the fields of records to bytes.
class McapEncoder {
 public:
  explicit McapEncoder(Bytes& out) : out_(out) {}
  template <class... Fields>
  void operator()(const Fields&... all) {
    (put(all), ...);
  }

 private:
  template <class Number>
  requires std::is_unsigned_v<Number>
  void put(Number number) {
    std::array<std::uint8_t, sizeof number> bytes{};
    for (std::size_t byte = 0; byte < sizeof number; ++byte)
      bytes[byte] = static_cast<std::uint8_t>(number >> (8 * byte));
    out_.insert(out_.end(), bytes.begin(), bytes.end());
  }
  void put(ByteView bytes) { out_.insert(out_.end(), bytes.begin(), bytes.end()); }
  void put(const std::string& text) {
    put(static_cast<std::uint32_t>(text.size()));
    put(as_bytes(text));
  }
  void put(McapBytes32 field) {
    put(static_cast<std::uint32_t>(field.bytes.size()));
    put(field.bytes);
  }
  void put(McapBytes64 field) {
    put(static_cast<std::uint64_t>(field.bytes.size()));
    put(field.bytes);
  }
  void put(McapRest field) { put(field.bytes); }
  template <class First, class Second>
  void put(const std::pair<First, Second>& pair) {
    put(pair.first);
    put(pair.second);
  }
  /// Maps and arrays: their length in bytes goes before them.
  template <class Items>
  requires requires(const Items& items) { typename Items::value_type::first_type; }
  void put(const Items& items) {
    const std::size_t at = out_.size();
    put(std::uint32_t{0});
    for (const auto& item : items) put(item);
    const auto length = static_cast<std::uint32_t>(out_.size() - at - 4);
    for (std::size_t byte = 0; byte < 4; ++byte) out_[at + byte] = static_cast<std::uint8_t>(length >> (8 * byte));
  }

  Bytes& out_;
};

/// Appends opcode, length and content of a record.
template <class Record>
void append_record(const Record& record, Bytes& out) {
  McapEncoder encoder{out};
  encoder(static_cast<std::uint8_t>(Record::kOpcode), std::uint64_t{0});
  const std::size_t begin = out.size();
  Record::fields(encoder, record);
  const std::uint64_t length = out.size() - begin;
  for (std::size_t byte = 0; byte < 8; ++byte) out[begin - 8 + byte] = static_cast<std::uint8_t>(length >> (8 * byte));
}

/// Takes the fields of records from bytes. After a field that reaches beyond the end all others are empty, and ok() is false.
class McapDecoder {
 public:
  explicit McapDecoder(ByteView bytes) : rest_(bytes) {}
  template <class... Fields>
  void operator()(Fields&... all) {
    (get(all), ...);
  }
  [[nodiscard]] bool ok() const { return ok_; }

 private:
  ByteView take(std::uint64_t size) {
    if (size > rest_.size()) {
      ok_ = false;
      rest_ = {};
      return {};
    }
    const ByteView taken = rest_.first(size);
    rest_ = rest_.subspan(size);
    return taken;
  }
  template <class Number>
  requires std::is_unsigned_v<Number>
  void get(Number& number) {
    std::uint64_t sum = 0;
    const ByteView bytes = take(sizeof number);
    for (std::size_t byte = 0; byte < bytes.size(); ++byte) sum |= std::uint64_t{bytes[byte]} << (8 * byte);
    number = static_cast<Number>(sum);
  }
  template <class Number>
  Number number() {
    Number value{};
    get(value);
    return value;
  }
  void get(std::string& text) { text = as_text(take(number<std::uint32_t>())); }
  void get(McapBytes32& field) { field.bytes = take(number<std::uint32_t>()); }
  void get(McapBytes64& field) { field.bytes = take(number<std::uint64_t>()); }
  void get(McapRest& field) { field.bytes = take(rest_.size()); }
  template <class First, class Second>
  void get(std::map<First, Second>& items) {
    McapDecoder inside{take(number<std::uint32_t>())};
    while (inside.ok_ && !inside.rest_.empty()) {
      First first{};
      inside(first);
      inside(items[std::move(first)]);
    }
    ok_ = ok_ && inside.ok_;
  }
  template <class First, class Second>
  void get(std::vector<std::pair<First, Second>>& items) {
    McapDecoder inside{take(number<std::uint32_t>())};
    items.reserve(inside.rest_.size() / (sizeof(First) + sizeof(Second)));
    while (inside.ok_ && !inside.rest_.empty()) {
      auto& [first, second] = items.emplace_back();
      inside(first, second);
    }
    ok_ = ok_ && inside.ok_;
  }

  ByteView rest_;
  bool ok_ = true;
};

/// Returns the record with this content; nullopt if a field reaches beyond it. Bytes after the last field are ignored, as the
/// specification demands.
template <class Record>
[[nodiscard]] std::optional<Record> decode_record(ByteView content) {
  Record record{};
  McapDecoder decoder{content};
  Record::fields(decoder, record);
  if (!decoder.ok()) return std::nullopt;
  return record;
}

}  // namespace nacelle::record
