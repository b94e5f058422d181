// SPDX-License-Identifier: Apache-2.0
#include "transport_dds/wire/user_data.hpp"

#include <fmt/format.h>

#include <iterator>
#include <utility>

#include "nacelle/base/expect.hpp"

namespace nacelle::transport_dds {
namespace {

constexpr std::string_view kHashPrefix = "RIHS01_";

bool is_key_byte(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9'); }

/// Takes one byte after the other; once one is wrong, everything is.
class Pairs {
 public:
  /// False: nothing more is to be read.
  bool take(char c) {
    const char before = std::exchange(last_, c);
    if (in_value_) {
      const bool ends_value = c != ';' && before == ';';
      if (!ends_value) {
        if (c != ';' || before == ';') value_ += c;
        return true;
      }
      if (!keep()) return false;
    }
    return take_key_byte(c, before);
  }

  UserData finished() && {
    if (in_value_) keep();
    if (!key_.empty() || bad_) return {};
    return std::move(pairs_);
  }

 private:
  bool take_key_byte(char c, char before) {
    if (c == '=' && !key_.empty()) {
      in_value_ = true;
    } else if (is_key_byte(c)) {
      key_ += c;
    } else if (c == '\0' && key_.empty() && !pairs_.empty()) {
      return false;
    } else if (c == '=' || before != ';' || !key_.empty()) {
      bad_ = true;
      return false;
    }
    return true;
  }
  bool keep() {
    bad_ = value_.empty();
    pairs_.insert_or_assign(std::exchange(key_, {}), std::exchange(value_, {}));
    in_value_ = false;
    return !bad_;
  }

  UserData pairs_;
  std::string key_, value_;
  char last_ = '\0';
  bool in_value_ = false, bad_ = false;
};

std::string value_of(const UserData& data, std::string_view key, std::size_t most_bytes) {
  const auto found = data.find(key);
  return found == data.end() || found->second.size() > most_bytes ? std::string() : found->second;
}

void append_pair(std::string& out, std::string_view key, std::string_view value) {
  NACELLE_EXPECT(value.find(';') == std::string_view::npos, "a ';' would end the value");
  if (!value.empty()) fmt::format_to(std::back_inserter(out), "{}={};", key, value);
}

}  // namespace

UserData parse_user_data(ByteView bytes) {
  if (bytes.size() > kMostUserDataBytes) return {};
  Pairs pairs;
  for (const char c : as_text(bytes)) {
    if (!pairs.take(c)) break;
  }
  return std::move(pairs).finished();
}

std::optional<std::string> read_participant_user_data(ByteView bytes) {
  auto enclave = value_of(parse_user_data(bytes), "enclave", kMostEnclaveBytes);
  if (enclave.empty()) return std::nullopt;
  return enclave;
}

EndpointUserData read_endpoint_user_data(ByteView bytes) {
  const UserData data = parse_user_data(bytes);
  EndpointUserData read{value_of(data, "typehash", kMostIdTextBytes * 2), value_of(data, "clientid", kMostIdTextBytes),
                        value_of(data, "serviceid", kMostIdTextBytes)};
  if (!is_type_hash(read.type_hash)) read.type_hash.clear();
  for (std::size_t i = kHashPrefix.size(); i < read.type_hash.size(); ++i) {
    char& c = read.type_hash[i];
    if (c >= 'A' && c <= 'F') c = static_cast<char>(c - 'A' + 'a');
  }
  return read;
}

std::string write_participant_user_data(std::string_view enclave) {
  std::string out;
  append_pair(out, "enclave", enclave);
  return out;
}

std::string write_endpoint_user_data(const EndpointUserData& data) {
  std::string out;
  append_pair(out, "clientid", data.client_id);
  append_pair(out, "serviceid", data.service_id);
  append_pair(out, "typehash", data.type_hash);
  return out;
}

bool is_type_hash(std::string_view text) {
  constexpr std::size_t kDigits = 64;
  if (text.size() != kHashPrefix.size() + kDigits || !text.starts_with(kHashPrefix)) return false;
  text.remove_prefix(kHashPrefix.size());
  return text.find_first_not_of("0123456789abcdefABCDEF") == std::string_view::npos;
}

std::string endpoint_id_text(const Gid& participant, std::uint32_t count) {
  std::string text = fmt::format("{:2x}", participant.bytes[0]);
  for (std::size_t i = 1; i < Gid::kPrefixBytes; ++i) text += fmt::format(".{:x}", participant.bytes[i]);
  for (const int shift : {24, 16, 8, 0}) text += fmt::format(".{:x}", (count >> shift) & 0xFF);
  return text;
}

}  // namespace nacelle::transport_dds
