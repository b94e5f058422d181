// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "nacelle/msgs/message_type.hpp"

#include <new>
#include <utility>

namespace nacelle::msgs {

/// A message of a type that is known at run time only, on the heap. One that was moved from holds none.
class AnyMessage {
 public:
  /// Every field has its default.
  explicit AnyMessage(const MessageType& type)
      : type_(&type), memory_(::operator new (type.size, std::align_val_t{type.alignment})) {
    type.construct(memory_);
  }
  AnyMessage(AnyMessage&& other) noexcept : type_(other.type_), memory_(std::exchange(other.memory_, nullptr)) {}
  AnyMessage& operator=(AnyMessage&&) = delete;
  ~AnyMessage() {
    if (memory_ == nullptr) return;
    type_->destroy(memory_);
    ::operator delete (memory_, std::align_val_t{type_->alignment});
  }

  [[nodiscard]] const MessageType& type() const { return *type_; }
  [[nodiscard]] void* get() { return memory_; }
  [[nodiscard]] const void* get() const { return memory_; }
  [[nodiscard]] Bytes encoded() const {
    Bytes bytes(type_->encoded_size(memory_));
    type_->encode(memory_, bytes.data());
    return bytes;
  }

 private:
  const MessageType* type_;
  void* memory_;
};

}  // namespace nacelle::msgs
