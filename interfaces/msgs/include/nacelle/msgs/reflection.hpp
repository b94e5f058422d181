// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>

namespace nacelle {
struct ReleaseHook;
}

namespace nacelle::msgs {

struct MessageType;
/// `&T::message_type`: a table can name a type of another library by it before that library has run any code.
using MessageTypeFunction = const MessageType& (*)();

/// The type of one value of a field, in the words of the definition. Byte and Char are std::uint8_t in C++.
enum class Kind : std::uint8_t {
  Bool,
  Byte,
  Char,
  Int8,
  Uint8,
  Int16,
  Uint16,
  Int32,
  Uint32,
  Int64,
  Uint64,
  Float32,
  Float64,
  String,
  WString,
  Message,
};

/// How many values a field holds: `T`, `T[N]`, `T[<=N]`, `T[]`.
enum class Shape : std::uint8_t { Single, Array, BoundedSequence, Sequence };

/// How to reach the elements of a sequence without knowing its C++ type (nacelle::Buffer<T> or std::vector<T>).
struct SequenceAccess {
  std::size_t (*size)(const void* sequence);
  /// The first element; the others follow at `stride` bytes. Null when empty.
  const void* (*data)(const void* sequence);
  void* (*mutable_data)(void* sequence);
  /// New elements hold their type's default values. Errors: std::bad_alloc.
  void (*resize)(void* sequence, std::size_t size);
  /// For a reader that writes every element next: new numbers hold anything, new messages have empty texts and
  /// sequences whatever their defaults are, so that the memory taken depends on `size` alone.
  void (*resize_for_decoding)(void* sequence, std::size_t size);
  /// Returns foreign memory to its owner; null when the sequence can hold none.
  void (*give_back)(void* sequence) noexcept;
  std::size_t stride;
  /// Lends it memory (Buffer::adopt); null when the sequence can hold none but its own. Errors: none; the old memory goes.
  void (*adopt)(void* sequence, void* memory, std::size_t size, std::size_t capacity, ReleaseHook hook) = nullptr;
};

/// One field of a message as its definition has it.
///
/// The address of the field is the message's address plus `offset`. Elements of an Array follow each other at the
/// size of the C++ type; those of a sequence are reached through `sequence`.
struct Field {
  const char* name;  ///< As on the wire; the C++ member of a name that is a C++ keyword has a trailing underscore.
  Kind kind;
  Shape shape;
  std::uint32_t bound;             ///< N of `T[N]` and `T[<=N]`, else 0.
  std::uint32_t text_bound;        ///< N of `string<=N` (bytes) and `wstring<=N` (code units), else 0.
  std::uint32_t offset;            ///< In bytes from the start of the message.
  MessageTypeFunction message;     ///< The type of a Message value, else null.
  const SequenceAccess* sequence;  ///< Null unless the shape is a sequence.
  const char* default_json;        ///< The definition's default as JSON; null when it gives none.
};

/// The definition's word: "uint8", "float64", "string"; "" for Message.
[[nodiscard]] const char* kind_name(Kind kind);
/// The size in memory, and on the wire, of one number or bool; 0 for texts and messages.
[[nodiscard]] std::size_t number_size(Kind kind);
/// The bytes from one element of a fixed array to the next.
[[nodiscard]] std::size_t element_size(const Field& field);

/// The accesses of all sequences that are not sequences of messages.
namespace access {
extern const SequenceAccess kBool, kInt8, kUint8, kInt16, kUint16, kInt32, kUint32, kInt64, kUint64, kFloat32, kFloat64,
    kString, kWString;
}  // namespace access

}  // namespace nacelle::msgs
