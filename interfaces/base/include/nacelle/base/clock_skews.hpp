// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <string_view>

#include "nacelle/base/guarded.hpp"
#include "nacelle/base/time.hpp"

namespace nacelle {

/// How another machine's clock differs from this one's. A value that allocates nothing, so that faults can hold one.
class ClockSkew {
 public:
  ClockSkew() = default;  ///< None.
  enum class Sureness : std::uint8_t {
    Guessed,  ///< If it is behind: what is late looks the same.
    Proven
  };
  /// `ahead`: negative is behind; positive is proven always, since nothing comes before it was sent. A longer name than 47
  /// bytes is cut.
  ClockSkew(std::string_view host, Duration ahead, Sureness sureness = Sureness::Guessed)
      : size_(static_cast<std::uint8_t>(host.copy(host_.data(), host_.size()))),
        is_certain_(ahead > Duration::zero() || sureness == Sureness::Proven),
        ahead_(ahead) {}

  explicit operator bool() const { return ahead_ != Duration::zero(); }
  [[nodiscard]] std::string_view host() const { return {host_.data(), size_}; }
  /// It is off by so much at least if that is certain; else it is behind by that or less.
  [[nodiscard]] Duration ahead() const { return ahead_; }
  [[nodiscard]] bool is_certain() const { return is_certain_; }
  /// "host laptop is 150 ms ahead", "host laptop is 30 ms behind" or, if that is not certain, "host laptop is 150 ms behind,
  /// or its messages come that late"; "" for none.
  [[nodiscard]] std::string text() const;

 private:
  std::array<char, 47> host_{};
  std::uint8_t size_ = 0;
  bool is_certain_ = false;
  Duration ahead_{};
};

/// The writers whose stamps come from a clock that is known to differ: what a complaint about stamps asks for its cause.
///
/// One per container; a transport that sees other machines fills it. Within a machine there is one clock and nothing to know.
/// Threads: any. Allocates: the one that fills it.
class ClockSkews {
 public:
  using Table = std::map<std::uint64_t, ClockSkew>;  ///< By MessageInfo::writer_id.

  /// From now on these, and no others.
  void replace(Table table);
  /// Of the writer's machine; none if it is not known to differ. Allocates: nothing.
  [[nodiscard]] ClockSkew of_writer(std::uint64_t writer_id) const;
  /// "; clock skew: host laptop is 150 ms ahead", to be put behind a complaint about the writer's stamps; "" for none.
  [[nodiscard]] std::string cause(std::uint64_t writer_id) const;

 private:
  std::atomic<bool> any_{false};
  Guarded<Table> table_;
};

/// For Node::shared_object(): the table of a container.
inline constexpr const char* kClockSkewsName = "nacelle.clock_skews";
[[nodiscard]] std::shared_ptr<void> make_clock_skews();

/// "; clock skew: host laptop is 150 ms ahead"; "" for none.
[[nodiscard]] std::string as_cause(const ClockSkew& skew);

}  // namespace nacelle
