// SPDX-License-Identifier: Apache-2.0
#include "nacelle/io/gpio_lines.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <linux/gpio.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <utility>

#include "nacelle/base/expect.hpp"
#include "nacelle/io/descriptor.hpp"

namespace nacelle::io {
namespace {

static_assert(GpioInputs::kKept <= GPIO_V2_LINES_MAX * 16, "the kernel refuses larger buffers");

std::uint64_t mask_of(const GpioRequest& request) {
  return request.lines.size() >= 64 ? ~std::uint64_t{0} : (std::uint64_t{1} << request.lines.size()) - 1;
}

/// Returns the descriptor of the lines, or errno.
Result<Descriptor, int> request_lines(const GpioRequest& request, std::uint64_t flags, std::uint32_t kept) {
  const Descriptor chip{::open(request.chip.c_str(), O_RDWR | O_CLOEXEC)};
  if (!chip.is_open()) return err(errno);
  gpio_v2_line_request wish{};
  std::copy(request.lines.begin(), request.lines.end(), wish.offsets);
  wish.num_lines = static_cast<std::uint32_t>(request.lines.size());
  wish.config.flags = flags;
  wish.event_buffer_size = kept;
  request.consumer.copy(wish.consumer, sizeof wish.consumer - 1);
  if (::ioctl(chip.number(), GPIO_V2_GET_LINE_IOCTL, &wish) != 0) return err(errno);
  Descriptor lines{wish.fd};
  const int status = ::fcntl(lines.number(), F_GETFL);
  if (status < 0 || ::fcntl(lines.number(), F_SETFL, status | O_NONBLOCK) != 0) return err(errno);
  return lines;
}

class KernelOutputs final : public GpioOutputs {
 public:
  KernelOutputs(GpioRequest request, Descriptor lines) : request_(std::move(request)), lines_(std::move(lines)) {}

  static constexpr std::uint64_t kFlags = GPIO_V2_LINE_FLAG_OUTPUT;

  bool set(std::uint64_t levels) override {
    gpio_v2_line_values values{};
    values.bits = levels;
    values.mask = mask_of(request_);
    return ::ioctl(lines_.number(), GPIO_V2_LINE_SET_VALUES_IOCTL, &values) == 0;
  }
  bool reopen() override {
    lines_ = Descriptor{};  // else they are in use, by us
    auto again = request_lines(request_, kFlags, 0);
    if (!again) return false;
    lines_ = std::move(again).value();
    return true;
  }

 private:
  const GpioRequest request_;
  Descriptor lines_;
};

class KernelInputs final : public GpioInputs {
 public:
  KernelInputs(GpioRequest request, Descriptor lines) : request_(std::move(request)), lines_(std::move(lines)) {}

  static std::uint64_t flags_of(const GpioRequest& request) {
    return GPIO_V2_LINE_FLAG_INPUT | GPIO_V2_LINE_FLAG_EDGE_RISING | GPIO_V2_LINE_FLAG_EDGE_FALLING |
           (request.pulls_up ? std::uint64_t{GPIO_V2_LINE_FLAG_BIAS_PULL_UP} : 0);
  }

  std::optional<std::uint64_t> levels() override {
    gpio_v2_line_values values{};
    values.mask = mask_of(request_);
    if (::ioctl(lines_.number(), GPIO_V2_LINE_GET_VALUES_IOCTL, &values) != 0) return std::nullopt;
    return values.bits;
  }
  std::optional<std::span<const GpioEdge>> take() override {
    const ssize_t bytes = ::read(lines_.number(), events_.data(), sizeof events_);
    if (bytes < 0 && errno != EAGAIN && errno != EINTR) return std::nullopt;
    const std::size_t count = bytes > 0 ? static_cast<std::size_t>(bytes) / sizeof events_[0] : 0;
    std::transform(events_.begin(), events_.begin() + count, edges_.begin(), [this](const gpio_v2_line_event& event) {
      const auto line = std::find(request_.lines.begin(), request_.lines.end(), event.offset) - request_.lines.begin();
      return GpioEdge{static_cast<unsigned>(line), event.id == GPIO_V2_LINE_EVENT_RISING_EDGE,
                      MonotonicTime{Duration{static_cast<std::int64_t>(event.timestamp_ns)}}, event.line_seqno,
                      event.seqno};
    });
    return std::span<const GpioEdge>{edges_.data(), count};
  }
  bool reopen() override {
    lines_ = Descriptor{};
    auto again = request_lines(request_, flags_of(request_), kKept);
    if (!again) return false;
    lines_ = std::move(again).value();
    return true;
  }

 private:
  const GpioRequest request_;
  Descriptor lines_;
  std::array<gpio_v2_line_event, kBatch> events_{};
  std::array<GpioEdge, kBatch> edges_{};
};

}  // namespace

Problem explain_gpio(const GpioRequest& request, int os_code) {
  Problem problem{fmt::format("GPIO line{} {} of {}", request.lines.size() == 1 ? "" : "s",
                              fmt::join(request.lines, ", "), request.chip),
                  fmt::format("cannot be used ({})", std::strerror(os_code)), "`gpioinfo` lists chips and lines"};
  switch (os_code) {
    case ENOENT:
    case ENODEV:
    case ENXIO: problem.what = "no such chip"; break;
    case EACCES:
    case EPERM:
      problem.what = "no permission to open the chip";
      problem.way_out = "`sudo usermod -aG gpio $USER`, then log in again";
      break;
    case EBUSY:
      problem.what = "in use by another program or driver";
      problem.way_out = "`gpioinfo` names it";
      break;
    case EINVAL: problem.what = "the chip has no such line, or cannot do that with it"; break;
    case ENOTTY: problem.what = "no GPIO chip, or one of a kernel before 5.10"; break;
    default: break;
  }
  return problem;
}

Result<std::unique_ptr<GpioOutputs>, Problem> request_gpio_outputs(const GpioRequest& request) {
  NACELLE_EXPECT(!request.lines.empty() && request.lines.size() <= GPIO_V2_LINES_MAX, "one to 64 lines");
  auto lines = request_lines(request, KernelOutputs::kFlags, 0);
  if (!lines) return err(explain_gpio(request, lines.error()));
  return std::unique_ptr<GpioOutputs>{std::make_unique<KernelOutputs>(request, std::move(lines).value())};
}

Result<std::unique_ptr<GpioInputs>, Problem> request_gpio_inputs(const GpioRequest& request) {
  NACELLE_EXPECT(!request.lines.empty() && request.lines.size() <= GPIO_V2_LINES_MAX, "one to 64 lines");
  auto lines = request_lines(request, KernelInputs::flags_of(request), GpioInputs::kKept);
  if (!lines) return err(explain_gpio(request, lines.error()));
  return std::unique_ptr<GpioInputs>{std::make_unique<KernelInputs>(request, std::move(lines).value())};
}

}  // namespace nacelle::io
