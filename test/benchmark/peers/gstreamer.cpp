// SPDX-License-Identifier: Apache-2.0
// peers_gstreamer path=inline|busy [messages=1000]
// GStreamer's hand-over of a 44-byte buffer of a pool: a pad that pushes into a pad (inline), and the same with the element
// `queue`, which has a thread of its own, between them (busy).
#include <gst/gst.h>

#include <atomic>
#include <cstdio>
#include <cstdlib>
#include <string>

#include "support/arguments.hpp"
#include "support/usage.hpp"

namespace {

using nacelle::bench::Usage;

constexpr guint kBytes = 44;
constexpr std::uint64_t kBurst = 500;
std::atomic<std::uint64_t> delivered{0};

void must(bool good, const char* what) {
  if (good) return;
  std::fprintf(stderr, "peers_gstreamer: %s\n", what);
  std::exit(1);
}

GstFlowReturn take(GstPad*, GstObject*, GstBuffer* buffer) {
  gst_buffer_unref(buffer);
  delivered.fetch_add(1, std::memory_order_release);
  delivered.notify_one();
  return GST_FLOW_OK;
}

// Source pad, perhaps a queue, sink pad.
class Line {
 public:
  explicit Line(bool with_queue) {
    source_ = gst_pad_new("src", GST_PAD_SRC);
    sink_ = gst_pad_new("sink", GST_PAD_SINK);
    gst_pad_set_chain_function(sink_, take);
    if (with_queue) {
      GstElement* const queue = gst_element_factory_make("queue", nullptr);
      must(queue != nullptr, "there is no element 'queue' (libgstreamer1.0-0 brings it)");
      g_object_set(queue, "max-size-buffers", 2 * kBurst, "max-size-bytes", 0, "max-size-time", guint64{0}, nullptr);
      link(source_, gst_element_get_static_pad(queue, "sink"));
      link(gst_element_get_static_pad(queue, "src"), sink_);
      gst_pad_set_active(sink_, TRUE);
      gst_element_set_state(queue, GST_STATE_PLAYING);
    } else {
      link(source_, sink_);
      gst_pad_set_active(sink_, TRUE);
    }
    gst_pad_set_active(source_, TRUE);
    gst_pad_push_event(source_, gst_event_new_stream_start("bench"));
    GstSegment segment;
    gst_segment_init(&segment, GST_FORMAT_TIME);
    gst_pad_push_event(source_, gst_event_new_segment(&segment));
    pool_ = gst_buffer_pool_new();
    GstStructure* const config = gst_buffer_pool_get_config(pool_);
    gst_buffer_pool_config_set_params(config, nullptr, kBytes, 2 * kBurst, 0);
    must(gst_buffer_pool_set_config(pool_, config) != FALSE, "the pool refuses its size");
    must(gst_buffer_pool_set_active(pool_, TRUE) != FALSE, "the pool cannot be made");
  }
  void send() {
    GstBuffer* buffer = nullptr;
    must(gst_buffer_pool_acquire_buffer(pool_, &buffer, nullptr) == GST_FLOW_OK, "the pool is dry");
    must(gst_pad_push(source_, buffer) == GST_FLOW_OK, "gst_pad_push failed");
  }

 private:
  static void link(GstPad* from, GstPad* to) {
    must(gst_pad_link_full(from, to, GST_PAD_LINK_CHECK_NOTHING) == GST_PAD_LINK_OK, "the pads cannot be linked");
  }
  GstPad* source_ = nullptr;
  GstPad* sink_ = nullptr;
  GstBufferPool* pool_ = nullptr;
};

void send_all(Line& line, std::uint64_t messages) {
  for (std::uint64_t sent = 0; sent < messages; sent += kBurst) {
    const std::uint64_t until = delivered.load() + kBurst;
    for (std::uint64_t i = 0; i < kBurst; ++i) line.send();
    for (std::uint64_t seen = delivered; seen < until; seen = delivered) delivered.wait(seen);
  }
}

}  // namespace

int main(int count, char** words) {
  const nacelle::bench::Arguments arguments(count, words);
  const std::uint64_t messages = arguments.number("messages", 1000);
  gst_init(nullptr, nullptr);
  Line line(arguments.text("path", "inline") == "busy");
  send_all(line, kBurst);
  const Usage before = Usage::now();
  send_all(line, messages);
  const Usage used = Usage::now() - before;
  nacelle::bench::print_figures({{"delivered", static_cast<double>(messages)},
                                 {"mallocs", static_cast<double>(used.mallocs)},
                                 {"switches", static_cast<double>(used.switches)},
                                 {"ns", static_cast<double>(used.at.nanoseconds())}});
  std::fflush(stdout);
  std::_Exit(0);  // the queue's thread waits for a buffer that never arrives
}
