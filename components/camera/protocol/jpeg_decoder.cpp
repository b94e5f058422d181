// SPDX-License-Identifier: Apache-2.0
#include "camera/protocol/jpeg_decoder.hpp"

#include <algorithm>
#include <array>
#include <csetjmp>
#include <cstddef>
#include <cstdio>
#include <vector>

#include <jpeglib.h>
// After jpeglib.h, which it needs.
#include <jerror.h>

namespace nacelle::camera {
namespace {

// SIMD code of libjpeg-turbo reads whole registers: rows begin at, and are as long as, multiples of this.
constexpr std::size_t kAlignment = 64;

/// Memory that is given out in order and taken back all at once.
class Arena {
 public:
  // Null when the limit is reached or the heap is empty: no exception may pass through libjpeg's frames.
  void* take(std::size_t bytes) noexcept {
    if (bytes > JpegDecoder::kMostWorkingBytes) return nullptr;
    bytes = (bytes + kAlignment - 1) / kAlignment * kAlignment;
    for (; current_ < chunks_.size(); ++current_, used_ = 0) {
      if (chunks_[current_].size - used_ >= bytes) {
        std::byte* const at = chunks_[current_].memory.get() + used_;
        used_ += bytes;
        return at;
      }
    }
    const std::size_t size = std::max(bytes, kChunkBytes);
    if (total_ + size > JpegDecoder::kMostWorkingBytes || chunks_.size() == kMostChunks) return nullptr;
    auto* const memory = static_cast<std::byte*>(::operator new (size, std::align_val_t{kAlignment}, std::nothrow));
    if (memory == nullptr) return nullptr;
    chunks_.push_back({Memory{memory}, size});  // reserved in the constructor: does not throw
    total_ += size;
    used_ = bytes;
    return memory;
  }
  void reset() noexcept { current_ = used_ = 0; }
  Arena() { chunks_.reserve(kMostChunks); }

 private:
  static constexpr std::size_t kChunkBytes = std::size_t{256} << 10U, kMostChunks = 256;
  struct Free {
    void operator()(std::byte* memory) const { ::operator delete (memory, std::align_val_t{kAlignment}); }
  };
  using Memory = std::unique_ptr<std::byte, Free>;
  struct Chunk {
    Memory memory;
    std::size_t size;
  };
  std::vector<Chunk> chunks_;
  std::size_t current_ = 0, used_ = 0, total_ = 0;
};

}  // namespace

struct JpegDecoder::State {
  jpeg_decompress_struct info{};
  jpeg_error_mgr errors{};
  jpeg_memory_mgr heap{};  // libjpeg's own functions
  std::jmp_buf on_error{};
  bool damaged = false;
  Arena arena;

  static State& of(j_common_ptr info) { return *static_cast<State*>(info->client_data); }
  void* take(j_common_ptr common, std::size_t bytes) {
    void* const memory = arena.take(bytes);
    if (memory == nullptr) common->err->error_exit(common);
    return memory;
  }
  void use_arena();
  void forget_last_frame();
};

// From now on all memory is a frame's: also the tables, which libjpeg would keep for the next frame.
void JpegDecoder::State::use_arena() {
  heap = *info.mem;
  jpeg_memory_mgr& memory = *info.mem;
  memory.alloc_small = [](j_common_ptr common, int, std::size_t bytes) { return of(common).take(common, bytes); };
  memory.alloc_large = [](j_common_ptr common, int, std::size_t bytes) { return of(common).take(common, bytes); };
  memory.alloc_sarray = [](j_common_ptr common, int, JDIMENSION samples, JDIMENSION rows) -> JSAMPARRAY {
    State& state = of(common);
    const std::size_t row_bytes = (samples * sizeof(JSAMPLE) + kAlignment - 1) / kAlignment * kAlignment;
    auto* const table = static_cast<JSAMPARRAY>(state.take(common, rows * sizeof(JSAMPROW)));
    auto* const samples_of_all = static_cast<JSAMPLE*>(state.take(common, row_bytes * rows));
    for (JDIMENSION row = 0; row < rows; ++row) table[row] = samples_of_all + row_bytes * row;
    return table;
  };
  memory.alloc_barray = [](j_common_ptr common, int, JDIMENSION blocks, JDIMENSION rows) -> JBLOCKARRAY {
    State& state = of(common);
    auto* const table = static_cast<JBLOCKARRAY>(state.take(common, rows * sizeof(JBLOCKROW)));
    auto* const blocks_of_all = static_cast<JBLOCK*>(state.take(common, sizeof(JBLOCK) * blocks * rows));
    for (JDIMENSION row = 0; row < rows; ++row) table[row] = blocks_of_all + std::size_t{blocks} * row;
    return table;
  };
  memory.free_pool = [](j_common_ptr common, int pool) {
    State& state = of(common);
    if (pool == JPOOL_IMAGE) state.arena.reset();
    state.heap.free_pool(common, pool);
  };
}

// A frame without its own tables would be decoded with those of the previous frame, into a wrong picture.
void JpegDecoder::State::forget_last_frame() {
  damaged = false;
  info.src = nullptr;
  std::ranges::fill(info.quant_tbl_ptrs, nullptr);
  std::ranges::fill(info.dc_huff_tbl_ptrs, nullptr);
  std::ranges::fill(info.ac_huff_tbl_ptrs, nullptr);
}

const char* to_text(JpegFault fault) {
  switch (fault) {
    case JpegFault::Corrupt: return "not a JPEG picture, or a broken one";
    case JpegFault::Damaged: return "a JPEG picture with parts missing";
    case JpegFault::WrongSize: return "a JPEG picture of another size than agreed";
    case JpegFault::Unsupported: return "a progressive or arithmetic-coded JPEG picture";
  }
  return "unknown";
}

JpegDecoder::JpegDecoder() : state_(std::make_unique<State>()) {
  State& state = *state_;
  state.info.err = jpeg_std_error(&state.errors);
  state.errors.error_exit = [](j_common_ptr common) { std::longjmp(State::of(common).on_error, 1); };
  // Called for each warning; a counter instead of libjpeg's line on stderr. "Extraneous bytes before marker" is what
  // many webcams always send, so only what costs picture content counts as damage.
  state.errors.emit_message = [](j_common_ptr common, int level) {
    if (level >= 0) return;
    const int code = common->err->msg_code;
    if (code == JWRN_JPEG_EOF || code == JWRN_HIT_MARKER || code == JWRN_HUFF_BAD_CODE || code == JWRN_MUST_RESYNC) {
      State::of(common).damaged = true;
    }
  };
  state.errors.output_message = [](j_common_ptr) {};
  state.info.client_data = &state;
  if (setjmp(state.on_error) != 0) throw std::bad_alloc{};
  jpeg_create_decompress(&state.info);  // keeps err and client_data
  state.use_arena();
}

JpegDecoder::~JpegDecoder() { jpeg_destroy_decompress(&state_->info); }

Result<void, JpegFault> JpegDecoder::decode(ByteView jpeg, std::uint32_t width, std::uint32_t height, JpegColours to,
                                            ByteSpan out) {
  State& state = *state_;
  jpeg_decompress_struct& info = state.info;
  const std::size_t line = std::size_t{width} * (to == JpegColours::Mono ? 1 : 3);
  if (width == 0 || height == 0 || out.size() < line * height) return err(JpegFault::WrongSize);
  if (jpeg.size() < 4) return err(JpegFault::Corrupt);
  state.forget_last_frame();
  // Nothing between here and the end of the function has a destructor: longjmp() would skip it.
  if (setjmp(state.on_error) != 0) {
    jpeg_abort_decompress(&info);
    return err(JpegFault::Corrupt);
  }
  jpeg_mem_src(&info, jpeg.data(), static_cast<unsigned long>(jpeg.size()));
  if (jpeg_read_header(&info, TRUE) != JPEG_HEADER_OK) {
    jpeg_abort_decompress(&info);
    return err(JpegFault::Corrupt);
  }
  const bool refused_coding = info.progressive_mode != 0 || info.arith_code != 0 || jpeg_has_multiple_scans(&info) != 0;
  if (refused_coding || info.image_width != width || info.image_height != height) {
    jpeg_abort_decompress(&info);
    return err(refused_coding ? JpegFault::Unsupported : JpegFault::WrongSize);
  }
  info.out_color_space = to == JpegColours::Mono ? JCS_GRAYSCALE : to == JpegColours::Rgb ? JCS_EXT_RGB : JCS_EXT_BGR;
  // Colours of the sensor are half as wide already; smoothing them would take a fifth more time.
  info.do_fancy_upsampling = FALSE;
  jpeg_start_decompress(&info);
  while (info.output_scanline < info.output_height) {
    std::array<JSAMPROW, 4> rows{};
    const std::size_t left = info.output_height - info.output_scanline;
    const auto wanted = static_cast<JDIMENSION>(std::min(left, rows.size()));
    for (JDIMENSION i = 0; i < wanted; ++i) rows[i] = out.data() + (std::size_t{info.output_scanline} + i) * line;
    if (jpeg_read_scanlines(&info, rows.data(), wanted) == 0) break;
  }
  // Damage in the last rows shows when the end marker is looked for.
  if (info.output_scanline < info.output_height) {
    jpeg_abort_decompress(&info);
    return err(JpegFault::Corrupt);
  }
  jpeg_finish_decompress(&info);
  if (state.damaged) return err(JpegFault::Damaged);
  return {};
}

}  // namespace nacelle::camera
