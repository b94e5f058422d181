// SPDX-License-Identifier: Apache-2.0
#include "diff_drive/protocol/number_lines.hpp"

#include <charconv>
#include <cmath>
#include <cstring>

#include "nacelle/base/expect.hpp"
#include "nacelle/base/result.hpp"

namespace nacelle::diff_drive {
namespace {

constexpr std::string_view kSpaces = " \t,";

bool is_letter(char c) { return (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z'); }

/// Removes the next word from the text; empty at its end.
std::string_view take_token(std::string_view& text) {
  const std::size_t begin = std::min(text.find_first_not_of(kSpaces), text.size());
  const std::size_t end = std::min(text.find_first_of(kSpaces, begin), text.size());
  const std::string_view token = text.substr(begin, end - begin);
  text.remove_prefix(end);
  return token;
}

std::optional<double> number_in(std::string_view token) {
  // std::from_chars also takes "inf" and "nan".
  const std::size_t first = token.starts_with('-') ? 1 : 0;
  if (token.size() == first || is_letter(token[first])) return std::nullopt;
  double value = 0.0;
  const auto [end, fault] = std::from_chars(token.data(), token.data() + token.size(), value);
  if (fault != std::errc{} || end != token.data() + token.size() || !std::isfinite(value)) return std::nullopt;
  return value;
}

/// Takes "*123" off the end of the text, and tells whether it is right.
Result<std::string_view, NumberLineFault> without_checksum(std::string_view text) {
  const std::size_t star = text.rfind('*');
  if (star == std::string_view::npos) return text;
  std::string_view digits = text.substr(star + 1);
  digits = digits.substr(0, std::min(digits.find_first_of(kSpaces), digits.size()));
  unsigned sum = 256;
  const auto [end, fault] = std::from_chars(digits.data(), digits.data() + digits.size(), sum);
  if (fault != std::errc{} || end != digits.data() + digits.size()) return err(NumberLineFault::Malformed);
  const std::string_view content = text.substr(0, star);
  if (sum != line_checksum(content)) return err(NumberLineFault::BadChecksum);
  return content;
}

Result<NumberLine, NumberLineFault> read(std::string_view text) {
  const auto content = without_checksum(text.substr(0, std::min(text.find(';'), text.size())));
  if (!content) return err(content.error());
  std::string_view rest = *content;
  NumberLine line;
  for (bool is_first = true;; is_first = false) {
    const std::string_view token = take_token(rest);
    if (token.empty()) break;
    if (is_first && std::all_of(token.begin(), token.end(), is_letter)) {
      line.word = token;
      continue;
    }
    const auto number = number_in(token);
    if (!number || line.count == NumberLine::kMostNumbers) return err(NumberLineFault::Malformed);
    line.numbers[line.count++] = *number;
  }
  return line;
}

}  // namespace

std::uint8_t line_checksum(std::string_view text) {
  std::uint8_t sum = 0;
  for (const char c : text) sum = static_cast<std::uint8_t>(sum ^ static_cast<std::uint8_t>(c));
  return sum;
}

void NumberLineDecoder::restart() {
  stats_.malformed_bytes += pending_;
  if (pending_ != 0) ++stats_.malformed_lines;
  pending_ = 0;
}

NumberLineDecoder::Took NumberLineDecoder::take(ByteView& bytes) {
  const auto end = std::find(bytes.begin(), bytes.end(), static_cast<std::uint8_t>('\n'));
  const auto part = static_cast<std::size_t>(end - bytes.begin());
  const bool ends = end != bytes.end();
  if (pending_ + part <= kMaxLineBytes)
    std::copy_n(bytes.begin(), part, text_.begin() + static_cast<std::ptrdiff_t>(pending_));
  pending_ += part;
  const std::size_t taken = part + (ends ? 1 : 0);
  stats_.bytes += taken;
  bytes = bytes.subspan(taken);
  if (!ends) return Took::Nothing;
  const std::size_t line_bytes = pending_ + 1;
  if (pending_ > kMaxLineBytes) {
    ++stats_.overlong_lines;
    stats_.overlong_bytes += line_bytes;
    pending_ = 0;
    return Took::BadLine;
  }
  return finish(line_bytes);
}

NumberLineDecoder::Took NumberLineDecoder::finish(std::size_t line_bytes) {
  std::string_view text{text_.data(), pending_};
  pending_ = 0;
  if (text.ends_with('\r')) text.remove_suffix(1);
  if (text.find_first_not_of(kSpaces) == std::string_view::npos) {
    stats_.blank_bytes += line_bytes;
    return Took::Nothing;
  }
  const auto line = read(text);
  if (!line || (line.value().word.empty() && line.value().count == 0)) {
    ++stats_.malformed_lines;
    stats_.malformed_bytes += line_bytes;
    if (!line && line.error() == NumberLineFault::BadChecksum) ++stats_.bad_checksums;
    return Took::BadLine;
  }
  line_ = line.value();
  line_.first_byte = stats_.bytes - line_bytes;
  ++stats_.lines;
  stats_.line_bytes += line_bytes;
  return Took::Line;
}

NumberLinePrinter& NumberLinePrinter::text(std::string_view part) {
  NACELLE_EXPECT(size_ + part.size() <= kCapacity, "the commands fit their buffer");
  std::memcpy(text_.data() + size_, part.data(), part.size());
  size_ += part.size();
  return *this;
}

NumberLinePrinter& NumberLinePrinter::integer(std::int64_t value) {
  const auto result = std::to_chars(text_.data() + size_, text_.data() + kCapacity, value);
  NACELLE_EXPECT(result.ec == std::errc{}, "the commands fit their buffer");
  size_ = static_cast<std::size_t>(result.ptr - text_.data());
  return *this;
}

NumberLinePrinter& NumberLinePrinter::decimal(double value) {
  const std::int64_t millionths = std::llround(value * 1e6);
  const std::int64_t magnitude = millionths < 0 ? -millionths : millionths;
  if (millionths < 0) text("-");
  integer(magnitude / 1'000'000);
  std::int64_t rest = magnitude % 1'000'000;
  if (rest == 0) return *this;
  text(".");
  for (std::int64_t digit = 100'000; rest != 0; digit /= 10) {
    integer(rest / digit);
    rest %= digit;
  }
  return *this;
}

NumberLinePrinter& NumberLinePrinter::end_checked() {
  const std::uint8_t sum = line_checksum({text_.data() + begun_, size_ - begun_});
  return text("*").integer(sum).end();
}

}  // namespace nacelle::diff_drive
