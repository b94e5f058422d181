// SPDX-License-Identifier: Apache-2.0
#include "camera/model/pattern_scene.hpp"
#include "camera/model/pixel_format.hpp"
#include "camera/protocol/jpeg_decoder.hpp"
#include "devices/device_runs.hpp"
#include "nacelle/base/time.hpp"
#include "ratios/ratio.hpp"
#include "support/arguments.hpp"
#include "support/usage.hpp"
#include "unit/components/camera/jpeg_picture.hpp"

namespace nacelle::bench {
namespace {

constexpr std::uint32_t kWidth = 1280, kHeight = 720;
constexpr int kPicturesPerBlock = 10;

Bytes picture() {
  const camera::PatternScene scene{kWidth, kHeight, camera::kRgb24};
  Bytes pixels(scene.frame_bytes());
  scene.render(7, pixels);
  return camera::encode_jpeg(pixels, kWidth, kHeight);
}

/// libjpeg's example: one row a call.
void decode_plainly(const Bytes& jpeg, Bytes& out) {
  jpeg_decompress_struct decoder{};
  jpeg_error_mgr errors{};
  decoder.err = jpeg_std_error(&errors);
  jpeg_create_decompress(&decoder);
  jpeg_mem_src(&decoder, jpeg.data(), jpeg.size());
  jpeg_read_header(&decoder, TRUE);
  jpeg_start_decompress(&decoder);
  while (decoder.output_scanline < decoder.output_height) {
    JSAMPROW row = out.data() + std::size_t{decoder.output_scanline} * kWidth * 3;
    jpeg_read_scanlines(&decoder, &row, 1);
  }
  jpeg_finish_decompress(&decoder);
  jpeg_destroy_decompress(&decoder);
}

template <typename Decode>
double block(const Clock& clock, const Decode& decode) {
  const MonotonicTime begin = clock.now();
  for (int i = 0; i < kPicturesPerBlock; ++i) decode();
  return to_seconds(clock.now() - begin) * 1e9 / kPicturesPerBlock;
}

}  // namespace

void run_jpeg(std::uint64_t blocks) {
  const Bytes jpeg = picture();
  Bytes out(std::size_t{kWidth} * kHeight * 3);
  const SystemClock clock;
  camera::JpegDecoder decoder;
  std::uint64_t refused = 0;
  const auto decode = [&] {
    if (!decoder.decode(jpeg, kWidth, kHeight, camera::JpegColours::Rgb, out)) ++refused;
  };
  const Ratio ratio = interleave(
      blocks, [&] { return block(clock, decode); }, [&] { return block(clock, [&] { decode_plainly(jpeg, out); }); });
  const Usage before = Usage::now();
  decode();
  print_figures({{"a_ns", ratio.a_ns},
                 {"b_ns", ratio.b_ns},
                 {"ratio", ratio.value()},
                 {"refused", static_cast<double>(refused)},
                 {"mallocs", static_cast<double>((Usage::now() - before).mallocs)}});
}

}  // namespace nacelle::bench
