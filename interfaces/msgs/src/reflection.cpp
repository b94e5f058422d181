// SPDX-License-Identifier: Apache-2.0
#include "nacelle/msgs/reflection.hpp"

#include "nacelle/base/buffer.hpp"
#include "nacelle/msgs/message_type.hpp"

#include <array>
#include <string>
#include <type_traits>
#include <vector>

namespace nacelle::msgs {
namespace {

template <typename T>
struct IsBuffer : std::false_type {};
template <typename T>
struct IsBuffer<Buffer<T>> : std::true_type {};

template <typename Sequence>
struct Access {
  static std::size_t size(const void* sequence) { return static_cast<const Sequence*>(sequence)->size(); }
  static const void* data(const void* sequence) { return static_cast<const Sequence*>(sequence)->data(); }
  static void* mutable_data(void* sequence) { return static_cast<Sequence*>(sequence)->data(); }
  static void resize(void* sequence, std::size_t size) { static_cast<Sequence*>(sequence)->resize(size); }
  static void resize_for_decoding(void* sequence, std::size_t size) {
    auto& elements = *static_cast<Sequence*>(sequence);
    if constexpr (IsBuffer<Sequence>::value) {
      elements.clear();  // What it held is not worth copying into grown memory.
      elements.resize_uninitialized(size);
    } else {
      elements.resize(size);
    }
  }
  static void give_back(void* sequence) noexcept {
    if constexpr (IsBuffer<Sequence>::value) static_cast<Sequence*>(sequence)->give_back();
  }
  static void adopt(void* sequence, void* memory, std::size_t size, std::size_t capacity, ReleaseHook hook) {
    if constexpr (IsBuffer<Sequence>::value) {
      using Value = typename Sequence::value_type;
      static_cast<Sequence*>(sequence)->adopt(static_cast<Value*>(memory), size, capacity, hook);
    }
  }

  static constexpr SequenceAccess kTable{&size,
                                         &data,
                                         &mutable_data,
                                         &resize,
                                         &resize_for_decoding,
                                         IsBuffer<Sequence>::value ? &give_back : nullptr,
                                         sizeof(typename Sequence::value_type),
                                         IsBuffer<Sequence>::value ? &adopt : nullptr};
};

struct KindFacts {
  const char* name;
  std::size_t size;
};
constexpr std::array<KindFacts, 16> kKinds{{{"bool", 1},
                                            {"byte", 1},
                                            {"char", 1},
                                            {"int8", 1},
                                            {"uint8", 1},
                                            {"int16", 2},
                                            {"uint16", 2},
                                            {"int32", 4},
                                            {"uint32", 4},
                                            {"int64", 8},
                                            {"uint64", 8},
                                            {"float32", 4},
                                            {"float64", 8},
                                            {"string", 0},
                                            {"wstring", 0},
                                            {"", 0}}};

}  // namespace

namespace access {
constinit const SequenceAccess kBool = Access<Buffer<bool>>::kTable;
constinit const SequenceAccess kInt8 = Access<Buffer<std::int8_t>>::kTable;
constinit const SequenceAccess kUint8 = Access<Buffer<std::uint8_t>>::kTable;
constinit const SequenceAccess kInt16 = Access<Buffer<std::int16_t>>::kTable;
constinit const SequenceAccess kUint16 = Access<Buffer<std::uint16_t>>::kTable;
constinit const SequenceAccess kInt32 = Access<Buffer<std::int32_t>>::kTable;
constinit const SequenceAccess kUint32 = Access<Buffer<std::uint32_t>>::kTable;
constinit const SequenceAccess kInt64 = Access<Buffer<std::int64_t>>::kTable;
constinit const SequenceAccess kUint64 = Access<Buffer<std::uint64_t>>::kTable;
constinit const SequenceAccess kFloat32 = Access<Buffer<float>>::kTable;
constinit const SequenceAccess kFloat64 = Access<Buffer<double>>::kTable;
constinit const SequenceAccess kString = Access<std::vector<std::string>>::kTable;
constinit const SequenceAccess kWString = Access<std::vector<std::u16string>>::kTable;
}  // namespace access

const char* kind_name(Kind kind) { return kKinds[static_cast<std::size_t>(kind)].name; }
std::size_t number_size(Kind kind) { return kKinds[static_cast<std::size_t>(kind)].size; }
std::size_t element_size(const Field& field) {
  switch (field.kind) {
    case Kind::String: return sizeof(std::string);
    case Kind::WString: return sizeof(std::u16string);
    case Kind::Message: return field.message().size;
    default: return number_size(field.kind);
  }
}

}  // namespace nacelle::msgs
