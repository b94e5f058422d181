// SPDX-License-Identifier: Apache-2.0
#include "record/model/message_diff.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <type_traits>

#include "nacelle/msgs/utf16.hpp"
#include "record/model/field_path.hpp"

namespace nacelle::record {
namespace {

using msgs::Field;
using msgs::Kind;
using msgs::MessageType;
using msgs::Shape;

constexpr std::size_t kLongestText = 60;

/// Two numbers, their distance, and how they are written.
struct Numbers {
  double distance = 0.0;
  std::string a, b;
};

template <typename Number>
double distance_of(Number a, Number b) {
  if constexpr (std::is_floating_point_v<Number>) {
    if (a == b || (std::isnan(a) && std::isnan(b))) return 0.0;
    if (!std::isfinite(a) || !std::isfinite(b)) return std::numeric_limits<double>::infinity();
    return std::abs(static_cast<double>(a) - static_cast<double>(b));
  } else {
    // Without overflow, and exact up to the last conversion.
    using Unsigned = std::make_unsigned_t<Number>;
    const auto less = static_cast<Unsigned>(a < b ? a : b), more = static_cast<Unsigned>(a < b ? b : a);
    return static_cast<double>(static_cast<Unsigned>(more - less));
  }
}

/// Hands two numbers of this kind to `use`. Returns false if it is no kind of number.
template <typename Use>
bool with_numbers(Kind kind, const void* a, const void* b, Use use) {
  const auto both = [&]<typename Number>(Number x) {
    Number y{};
    std::memcpy(&x, a, sizeof x);
    std::memcpy(&y, b, sizeof y);
    use(x, y);
    return true;
  };
  switch (kind) {
    case Kind::Byte:
    case Kind::Char:
    case Kind::Uint8: return both(std::uint8_t{});
    case Kind::Int8: return both(std::int8_t{});
    case Kind::Int16: return both(std::int16_t{});
    case Kind::Uint16: return both(std::uint16_t{});
    case Kind::Int32: return both(std::int32_t{});
    case Kind::Uint32: return both(std::uint32_t{});
    case Kind::Int64: return both(std::int64_t{});
    case Kind::Uint64: return both(std::uint64_t{});
    case Kind::Float32: return both(float{});
    case Kind::Float64: return both(double{});
    case Kind::Bool:
    case Kind::String:
    case Kind::WString:
    case Kind::Message: break;
  }
  return false;
}

/// The length of the part of two texts before their first difference, of whole characters.
std::size_t common_length(std::string_view a, std::string_view b) {
  std::size_t at = 0;
  while (at < a.size() && at < b.size() && a[at] == b[at]) ++at;
  return at;
}

/// Returns a text in quotes; of a long one what is around `at`.
std::string text_in_quotes(std::string_view text, std::size_t at) {
  const auto continues = [&](std::size_t i) {
    return i < text.size() && (static_cast<unsigned char>(text[i]) & 0xC0U) == 0x80U;
  };
  if (text.size() <= kLongestText) return fmt::format("'{}'", text);
  std::size_t begin = at < kLongestText / 2 ? 0 : std::min(at - kLongestText / 2, text.size() - kLongestText);
  while (begin > 0 && continues(begin)) --begin;
  std::size_t end = std::min(begin + kLongestText, text.size());
  while (continues(end)) ++end;
  return fmt::format("'{}{}{}'", begin > 0 ? "..." : "", text.substr(begin, end - begin),
                     end < text.size() ? "..." : "");
}

std::string seconds_text(std::int64_t nanoseconds) {
  const std::int64_t seconds = nanoseconds / 1'000'000'000, rest = nanoseconds % 1'000'000'000;
  return fmt::format("{}{}.{:09} s", nanoseconds < 0 ? "-" : "", std::abs(seconds), std::abs(rest));
}

const void* add(const void* at, std::size_t bytes) { return static_cast<const std::byte*>(at) + bytes; }

struct Elements {
  const void* first = nullptr;
  std::size_t count = 0, stride = 0;
};
Elements elements_of(const Field& field, const void* at) {
  if (field.shape == Shape::Array) return {at, field.bound, msgs::element_size(field)};
  return {field.sequence->data(at), field.sequence->size(at), field.sequence->stride};
}

}  // namespace

class MessageDiff::ElementPath {
 public:
  ElementPath(MessageDiff& diff, std::size_t index)
      : diff_(diff), path_(diff.path_.size()), pattern_(diff.pattern_.size()) {
    diff_.path_ += fmt::format("[{}]", index);
    diff_.pattern_ += "[*]";
  }
  ~ElementPath() {
    diff_.path_.resize(path_);
    diff_.pattern_.resize(pattern_);
  }
  ElementPath(const ElementPath&) = delete;
  ElementPath& operator=(const ElementPath&) = delete;

 private:
  MessageDiff& diff_;
  const std::size_t path_, pattern_;
};

std::optional<ValueDifference> MessageDiff::compare(const void* a, const void* b) {
  first_.reset();
  look_at_message(type_, a, b, allowed_);
  ++round_;
  return std::move(first_);
}

void MessageDiff::note(std::string a, std::string b, const double* difference) {
  FieldDifference& field = fields_[pattern_];
  if (field.values++ == 0) {
    field.is_number = difference != nullptr;
    field.path = path_;
    field.round = round_;
  }
  if (difference != nullptr && *difference > field.largest) {
    field.largest = *difference;
    field.path = path_;
    field.round = round_;
  }
  if (!first_) first_ = {path_, std::move(a), std::move(b)};
}

void MessageDiff::look_at_message(const MessageType& type, const void* a, const void* b, const ToleranceScope& scope) {
  const std::size_t path = path_.size(), pattern = pattern_.size();
  for (const Field& field : type.fields) {
    path_ += (path == 0 ? "" : ".") + std::string{field.name};
    pattern_ += (pattern == 0 ? "" : ".") + std::string{field.name};
    look_at_field(field, add(a, field.offset), add(b, field.offset), scope.field(field.name));
    path_.resize(path);
    pattern_.resize(pattern);
  }
}

void MessageDiff::look_at_field(const Field& field, const void* a, const void* b, const ToleranceScope& scope) {
  if (field.shape == Shape::Single) return look_at_value(field, a, b, scope);
  const Elements of_a = elements_of(field, a), of_b = elements_of(field, b);
  if (of_a.count != of_b.count) {
    if (!scope.allowance().ignore)
      note(fmt::format("{} elements", of_a.count), fmt::format("{} elements", of_b.count), nullptr);
    return;
  }
  const std::size_t size = msgs::number_size(field.kind);
  if (of_a.count == 0 || (size != 0 && std::memcmp(of_a.first, of_b.first, size * of_a.count) == 0)) return;
  const ToleranceScope every = scope.element(0);
  const bool alike = scope.elements_are_alike();
  for (std::size_t i = 0; i < of_a.count; ++i) {
    const void* const at_a = add(of_a.first, i * of_a.stride);
    const void* const at_b = add(of_b.first, i * of_b.stride);
    if (size != 0 && std::memcmp(at_a, at_b, size) == 0) continue;
    const ElementPath inside{*this, i};
    look_at_value(field, at_a, at_b, alike ? every : scope.element(i));
  }
}

void MessageDiff::look_at_value(const Field& field, const void* a, const void* b, const ToleranceScope& scope) {
  if (field.kind == Kind::Message && !is_time(field.message())) return look_at_message(field.message(), a, b, scope);
  const Allowance& allowed = scope.allowance();
  if (allowed.ignore) return;
  const auto compare_numbers = [&](auto x, auto y) {
    const double distance = distance_of(x, y);
    if (distance > allowed.tolerance) note(fmt::format("{}", +x), fmt::format("{}", +y), &distance);
  };
  if (with_numbers(field.kind, a, b, compare_numbers)) return;
  switch (field.kind) {
    case Kind::Message: {
      const std::int64_t x = nanoseconds_of(field.message(), a), y = nanoseconds_of(field.message(), b);
      const double distance = distance_of(x, y) / 1e9;
      if (distance > allowed.tolerance) note(seconds_text(x), seconds_text(y), &distance);
      break;
    }
    case Kind::Bool: {
      const bool x = *static_cast<const std::uint8_t*>(a) != 0, y = *static_cast<const std::uint8_t*>(b) != 0;
      if (x != y) note(x ? "true" : "false", y ? "true" : "false", nullptr);
      break;
    }
    case Kind::WString: {
      const auto& x = *static_cast<const std::u16string*>(a);
      const auto& y = *static_cast<const std::u16string*>(b);
      if (x == y) break;
      const std::string of_x = msgs::utf8_of(x), of_y = msgs::utf8_of(y);
      const std::size_t at = common_length(of_x, of_y);
      note(text_in_quotes(of_x, at), text_in_quotes(of_y, at), nullptr);
      break;
    }
    default: {
      const auto& x = *static_cast<const std::string*>(a);
      const auto& y = *static_cast<const std::string*>(b);
      if (x == y) break;
      const std::size_t at = common_length(x, y);
      note(text_in_quotes(x, at), text_in_quotes(y, at), nullptr);
      break;
    }
  }
}

}  // namespace nacelle::record
