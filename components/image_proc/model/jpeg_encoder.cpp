// SPDX-License-Identifier: Apache-2.0
#include "image_proc/model/jpeg_encoder.hpp"

#include <algorithm>
#include <array>
#include <csetjmp>
#include <cstddef>
#include <cstdio>
#include <new>
#include <vector>

#include <jpeglib.h>

namespace nacelle::image_proc {
namespace {

// SIMD code of libjpeg-turbo reads whole registers: rows begin at, and are as long as, multiples of this.
constexpr std::size_t kAlignment = 64;
constexpr std::size_t kLeastOutput = std::size_t{16} << 10U;

std::size_t aligned(std::size_t bytes) { return (bytes + kAlignment - 1) / kAlignment * kAlignment; }

/// Blocks that are given out in order, and again in the same order for the next picture.
class Blocks {
 public:
  // Null when the heap is empty or there are too many: no exception may pass through libjpeg's frames.
  void* take(std::size_t bytes) noexcept {
    if (next_ == kMost) return nullptr;
    Block& block = blocks_[next_];
    if (block.size < bytes) {
      auto* const memory = static_cast<std::byte*>(::operator new (bytes, std::align_val_t{kAlignment}, std::nothrow));
      if (memory == nullptr) return nullptr;
      block.memory.reset(memory);
      block.size = bytes;
    }
    ++next_;
    return block.memory.get();
  }
  void reset() noexcept { next_ = 0; }

 private:
  static constexpr std::size_t kMost = 256;  // a picture of three components takes some forty
  struct Free {
    void operator()(std::byte* memory) const { ::operator delete (memory, std::align_val_t{kAlignment}); }
  };
  struct Block {
    std::unique_ptr<std::byte, Free> memory;
    std::size_t size = 0;
  };
  std::array<Block, kMost> blocks_;
  std::size_t next_ = 0;
};

J_COLOR_SPACE colours_of(std::string_view encoding) {
  if (encoding == "mono8") return JCS_GRAYSCALE;
  if (encoding == "rgb8") return JCS_EXT_RGB;
  if (encoding == "bgr8") return JCS_EXT_BGR;
  if (encoding == "rgba8") return JCS_EXT_RGBX;
  if (encoding == "bgra8") return JCS_EXT_BGRX;
  return JCS_UNKNOWN;
}

}  // namespace

struct JpegEncoder::State {
  jpeg_compress_struct info{};
  jpeg_error_mgr errors{};
  jpeg_memory_mgr heap{};  // libjpeg's own functions
  jpeg_destination_mgr destination{};
  std::jmp_buf on_error{};
  bool out_of_memory = false;
  Buffer<std::uint8_t>* out = nullptr;
  Blocks blocks;

  static State& of(j_common_ptr common) { return *static_cast<State*>(common->client_data); }
  static State& of(j_compress_ptr info) { return *static_cast<State*>(info->client_data); }
  void* take(std::size_t bytes) {
    void* const memory = blocks.take(bytes);
    if (memory == nullptr) fail_without_memory();
    return memory;
  }
  [[noreturn]] void fail_without_memory() {
    out_of_memory = true;
    std::longjmp(on_error, 1);
  }
  void use_blocks();
  void use_output();
  // No exception may pass through libjpeg's frames.
  [[nodiscard]] bool grow(std::size_t bytes) noexcept {
    try {
      out->resize_uninitialized(bytes);
      return true;
    } catch (const std::bad_alloc&) { return false; }
  }
};

// What belongs to one picture comes from the blocks; tables that libjpeg keeps for all pictures are its own.
void JpegEncoder::State::use_blocks() {
  heap = *info.mem;
  jpeg_memory_mgr& memory = *info.mem;
  memory.alloc_small = [](j_common_ptr common, int pool, std::size_t bytes) {
    State& state = of(common);
    return pool == JPOOL_IMAGE ? state.take(bytes) : state.heap.alloc_small(common, pool, bytes);
  };
  memory.alloc_large = [](j_common_ptr common, int pool, std::size_t bytes) {
    State& state = of(common);
    return pool == JPOOL_IMAGE ? state.take(bytes) : state.heap.alloc_large(common, pool, bytes);
  };
  memory.alloc_sarray = [](j_common_ptr common, int, JDIMENSION samples, JDIMENSION rows) -> JSAMPARRAY {
    State& state = of(common);
    const std::size_t row_bytes = aligned(samples * sizeof(JSAMPLE));
    auto* const table = static_cast<JSAMPARRAY>(state.take(rows * sizeof(JSAMPROW)));
    auto* const samples_of_all = static_cast<JSAMPLE*>(state.take(row_bytes * rows));
    for (JDIMENSION row = 0; row < rows; ++row) table[row] = samples_of_all + row_bytes * row;
    return table;
  };
  memory.alloc_barray = [](j_common_ptr common, int, JDIMENSION blocks_of_row, JDIMENSION rows) -> JBLOCKARRAY {
    State& state = of(common);
    auto* const table = static_cast<JBLOCKARRAY>(state.take(rows * sizeof(JBLOCKROW)));
    auto* const all = static_cast<JBLOCK*>(state.take(sizeof(JBLOCK) * blocks_of_row * rows));
    for (JDIMENSION row = 0; row < rows; ++row) table[row] = all + std::size_t{blocks_of_row} * row;
    return table;
  };
  memory.free_pool = [](j_common_ptr common, int pool) {
    State& state = of(common);
    if (pool == JPOOL_IMAGE) state.blocks.reset();
    state.heap.free_pool(common, pool);
  };
}

// The JPEG is written into the output itself, which grows to twice its size whenever it is full.
void JpegEncoder::State::use_output() {
  destination.init_destination = [](j_compress_ptr compress) {
    State& state = of(compress);
    if (!state.grow(std::max(state.out->capacity(), kLeastOutput))) state.fail_without_memory();
    state.destination.next_output_byte = state.out->data();
    state.destination.free_in_buffer = state.out->size();
  };
  destination.empty_output_buffer = [](j_compress_ptr compress) -> boolean {
    State& state = of(compress);
    const std::size_t full = state.out->size();  // what libjpeg promises, whatever free_in_buffer says
    if (!state.grow(2 * full)) state.fail_without_memory();
    state.destination.next_output_byte = state.out->data() + full;
    state.destination.free_in_buffer = state.out->size() - full;
    return TRUE;
  };
  destination.term_destination = [](j_compress_ptr compress) {
    State& state = of(compress);
    state.out->resize_uninitialized(state.out->size() -
                                    state.destination.free_in_buffer);  // smaller: it does not throw
  };
  info.dest = &destination;
}

const char* to_text(EncodeFault fault) {
  return fault == EncodeFault::OutOfMemory ? "there is not enough memory to encode it" : "libjpeg does not take it";
}

JpegEncoder::JpegEncoder() : state_(std::make_unique<State>()) {
  State& state = *state_;
  state.info.err = jpeg_std_error(&state.errors);
  state.errors.error_exit = [](j_common_ptr common) { std::longjmp(State::of(common).on_error, 1); };
  state.errors.output_message = [](j_common_ptr) {};
  state.info.client_data = &state;
  if (setjmp(state.on_error) != 0) throw std::bad_alloc{};
  jpeg_create_compress(&state.info);  // keeps err and client_data
  state.use_blocks();
  state.use_output();
}

JpegEncoder::~JpegEncoder() { jpeg_destroy_compress(&state_->info); }

Result<void, EncodeFault> JpegEncoder::encode(const Picture& picture, int quality, Buffer<std::uint8_t>& out) {
  State& state = *state_;
  jpeg_compress_struct& info = state.info;
  info.in_color_space = colours_of(picture.encoding.name);
  if (info.in_color_space == JCS_UNKNOWN) return err(EncodeFault::Refused);
  state.out = &out;
  state.out_of_memory = false;
  // Nothing between here and the end of the function has a destructor: longjmp() would skip it.
  if (setjmp(state.on_error) != 0) {
    jpeg_abort_compress(&info);
    out.clear();
    return err(state.out_of_memory ? EncodeFault::OutOfMemory : EncodeFault::Refused);
  }
  info.image_width = picture.width;
  info.image_height = picture.height;
  info.input_components = picture.encoding.channels;
  jpeg_set_defaults(&info);
  jpeg_set_quality(&info, quality, TRUE);
  jpeg_start_compress(&info, TRUE);
  while (info.next_scanline < info.image_height) {
    // libjpeg does not write into the rows.
    auto* row = const_cast<JSAMPROW>(picture.pixels + std::size_t{info.next_scanline} * picture.step);
    if (jpeg_write_scanlines(&info, &row, 1) == 0) break;
  }
  jpeg_finish_compress(&info);
  return {};
}

}  // namespace nacelle::image_proc
