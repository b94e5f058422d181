// SPDX-License-Identifier: Apache-2.0
#pragma once

// Used by generated sources only: how a C++ type becomes a MessageType.
#include "nacelle/msgs/message_type.hpp"

#include <cstddef>
#include <new>
#include <utility>
#include <vector>

namespace nacelle::msgs {

/// Not generated per type: one place knows how fields are walked.
void recycle(const MessageType& type, void* message) noexcept;
void poison(const MessageType& type, void* message);
/// Empties every text and sequence in the message, fixed parts included.
void clear_texts_and_sequences(const MessageType& type, void* message) noexcept;

namespace detail {

template <typename T>
struct Functions {
  static void construct(void* memory) { ::new (memory) T; }
  static void destroy(void* message) noexcept { static_cast<T*>(message)->~T(); }
  static void copy_assign(void* to, const void* from) { *static_cast<T*>(to) = *static_cast<const T*>(from); }
  static void move_assign(void* to, void* from) { *static_cast<T*>(to) = std::move(*static_cast<T*>(from)); }
  static void recycle(void* message) noexcept { msgs::recycle(T::message_type(), message); }
  static void poison(void* message) { msgs::poison(T::message_type(), message); }
  static std::size_t encoded_size(const void* message) { return msgs::encoded_size(T::message_type(), message); }
  static void encode(const void* message, std::uint8_t* out) { msgs::encode(T::message_type(), message, out); }
  static Result<void, DecodeFault> decode(ByteView bytes, void* message) {
    return msgs::decode(T::message_type(), bytes, message);
  }
};

/// `DefaultsAllocate`: a default-made element takes memory of its own (long default texts, default sequences).
template <typename T, bool DefaultsAllocate>
struct VectorFunctions {
  using Vector = std::vector<T>;
  static std::size_t size(const void* sequence) { return static_cast<const Vector*>(sequence)->size(); }
  static const void* data(const void* sequence) { return static_cast<const Vector*>(sequence)->data(); }
  static void* mutable_data(void* sequence) { return static_cast<Vector*>(sequence)->data(); }
  static void resize(void* sequence, std::size_t size) { static_cast<Vector*>(sequence)->resize(size); }
  static void resize_for_decoding(void* sequence, std::size_t size) {
    if constexpr (DefaultsAllocate) {
      // Hostile bytes name a count; what an element costs must not depend on how long its default texts are.
      static const T empty = [] {
        T made;
        clear_texts_and_sequences(T::message_type(), &made);
        return made;
      }();
      static_cast<Vector*>(sequence)->resize(size, empty);
    } else {
      static_cast<Vector*>(sequence)->resize(size);
    }
  }
};

template <typename T, bool DefaultsAllocate>
inline constexpr SequenceAccess kVectorOf{&VectorFunctions<T, DefaultsAllocate>::size,
                                          &VectorFunctions<T, DefaultsAllocate>::data,
                                          &VectorFunctions<T, DefaultsAllocate>::mutable_data,
                                          &VectorFunctions<T, DefaultsAllocate>::resize,
                                          &VectorFunctions<T, DefaultsAllocate>::resize_for_decoding,
                                          nullptr,
                                          sizeof(T)};

struct Names {
  const char* name;
  const char* dds_name;
  const char* hash;
  const char* definition;
};

template <typename T>
constexpr MessageType make_message_type(const Names& names, std::span<const Field> fields, std::span<const Step> steps,
                                        std::size_t least_encoded_size, bool holds_buffers) {
  using F = Functions<T>;
  return {names.name,  names.dds_name, names.hash,         names.definition, sizeof(T),
          alignof(T),  &F::construct,  &F::destroy,        &F::copy_assign,  &F::move_assign,
          &F::recycle, &F::poison,     &F::encoded_size,   &F::encode,       &F::decode,
          fields,      steps,          least_encoded_size, holds_buffers};
}

}  // namespace detail
}  // namespace nacelle::msgs
