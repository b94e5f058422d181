// SPDX-License-Identifier: Apache-2.0
#include "nacelle/msgs/type_support.hpp"

#include <algorithm>
#include <cstring>
#include <limits>
#include <string>

namespace nacelle::msgs {
namespace {

/// An integer that is unlikely to occur on purpose.
constexpr int kPoisonByte = 0xCD;

template <typename Visit>
void for_each_message(const MessageType& type, std::uint8_t* first, std::size_t count, Visit visit) {
  for (std::size_t i = 0; i < count; ++i) visit(first + i * type.size);
}

void poison_numbers(Kind kind, std::uint8_t* at, std::size_t count) {
  switch (kind) {
    case Kind::Bool:  // Any other byte in a bool is undefined behaviour.
      std::fill_n(reinterpret_cast<bool*>(at), count, true);
      break;
    case Kind::Float32:
      std::fill_n(reinterpret_cast<float*>(at), count, std::numeric_limits<float>::quiet_NaN());
      break;
    case Kind::Float64:
      std::fill_n(reinterpret_cast<double*>(at), count, std::numeric_limits<double>::quiet_NaN());
      break;
    default: std::memset(at, kPoisonByte, count * number_size(kind));
  }
}

}  // namespace

void recycle(const MessageType& type, void* message) noexcept {
  if (!type.holds_buffers) return;
  for (const Step& step : type.steps) {
    auto* const at = static_cast<std::uint8_t*>(message) + step.offset;
    const auto recycle_one = [&step](void* one) { recycle(step.message(), one); };
    switch (step.kind) {
      case StepKind::NumberSequence:
      case StepKind::BoolSequence: step.sequence->give_back(at); break;
      case StepKind::Messages: for_each_message(step.message(), at, step.count, recycle_one); break;
      case StepKind::MessageSequence:
        if (!step.message().holds_buffers) break;
        for_each_message(step.message(), static_cast<std::uint8_t*>(step.sequence->mutable_data(at)),
                         step.sequence->size(at), recycle_one);
        break;
      default: break;
    }
  }
}

void poison(const MessageType& type, void* message) {
  for (const Field& field : type.fields) {
    if (field.sequence != nullptr || field.kind == Kind::String || field.kind == Kind::WString) continue;
    auto* const at = static_cast<std::uint8_t*>(message) + field.offset;
    const std::size_t count = field.shape == Shape::Array ? field.bound : 1;
    if (field.kind == Kind::Message) {
      for_each_message(field.message(), at, count, [&field](void* one) { poison(field.message(), one); });
    } else {
      poison_numbers(field.kind, at, count);
    }
  }
}

void clear_texts_and_sequences(const MessageType& type, void* message) noexcept {
  for (const Step& step : type.steps) {
    auto* const at = static_cast<std::uint8_t*>(message) + step.offset;
    switch (step.kind) {
      case StepKind::Numbers:
      case StepKind::Bools: break;
      case StepKind::Texts:
        for (std::size_t i = 0; i < step.count; ++i) reinterpret_cast<std::string*>(at)[i].clear();
        break;
      case StepKind::WideTexts:
        for (std::size_t i = 0; i < step.count; ++i) reinterpret_cast<std::u16string*>(at)[i].clear();
        break;
      case StepKind::Messages:
        for_each_message(step.message(), at, step.count,
                         [&step](void* one) { clear_texts_and_sequences(step.message(), one); });
        break;
      default: step.sequence->resize(at, 0);  // Shrinking: takes no memory.
    }
  }
}

}  // namespace nacelle::msgs
