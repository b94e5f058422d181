// SPDX-License-Identifier: Apache-2.0
#include "range/component/vl53l0x_component.hpp"

#include <fmt/format.h>

#include <utility>

#include "nacelle/io/i2c_bus.hpp"
#include "nacelle/node/frame_name.hpp"
#include "range/component/descriptors.hpp"

namespace nacelle::range {
namespace {

Result<std::unique_ptr<io::RegisterBus>, Problem> open_i2c(const Vl53l0xOptions& options, const Clock& clock) {
  const io::I2cSettings settings{options.bus, options.sensor.address};
  auto bus = options.device.required ? io::I2cBus::open(settings, clock, options.port_timeout)
                                     : io::I2cBus::open_or_await(settings, clock);
  if (!bus) return err(std::move(bus).error());
  return std::unique_ptr<io::RegisterBus>{std::move(bus).value()};
}

// What the sensor needs between two measurements. Source: ST, VL53L0X API, the overheads of a measurement.
constexpr Duration kBetween = 5ms;

}  // namespace

Vl53l0xComponent::Vl53l0xComponent(const NodeOptions& options) : Vl53l0xComponent(options, open_i2c) {}

Vl53l0xComponent::Vl53l0xComponent(const NodeOptions& options, OpenBus open_bus)
    : LifecycleNode("range", options), open_bus_(std::move(open_bus)) {
  declare_parameters();
  declare_frame_use(frame_name(*this, "frame_id"), "frame_id");
  // A bus is shared; a chip on it is not.
  declare_device_use(fmt::format("{} address 0x{:02x}", get<std::string>("port"), get<std::int64_t>("address")),
                     "port");
  if (const auto read = read_options(); !read) declare_problem(read.error());
  publisher_ = create_publisher<sensor_msgs::msg::Range>("range", QoS(10).best_effort());
}

Vl53l0xComponent::~Vl53l0xComponent() { close(); }

void Vl53l0xComponent::declare_parameters() {
  const Vl53l0xOptions defaults;
  declare_parameter("port", defaults.bus, described("I2C bus of the sensor, e.g. /dev/i2c-1"));
  declare_parameter(
      "address", static_cast<int>(defaults.sensor.address),
      {.description = "I2C address of the sensor; as delivered by default", .integer_range = IntegerRange{8, 0x77}});
  declare_frame_prefix(*this);
  declare_parameter("frame_id", defaults.frame_id, described("frame of the sensor: x where it looks"));
  declare_parameter("rate", 10.0, within("Hz; a measurement takes timing_budget and 5 ms", 0.1, 40.0));
  declare_parameter("timing_budget", to_seconds(defaults.sensor.budget),
                    within("s of a measurement: twice as long is 1.4 times as exact", 0.02, 0.5));
  declare_parameter("min_range", defaults.least_m, within("m; nearer is -Inf", 0.0, 4.0));
  declare_parameter("max_range", defaults.most_m, within("m; farther is +Inf", 0.0, 4.0));
  declare_parameter("field_of_view", defaults.field_of_view_rad, within("rad, of the cone", 0.0, 3.2));
  declare_parameter("port_timeout", to_seconds(defaults.port_timeout),
                    within("s that configure waits for the bus, with required_device", 0.0, 3600.0));
  declare_parameter("silence_limit", to_seconds(defaults.silence_limit),
                    within("s without a result that are a fault, with device_lost: fault", 0.01, 3600.0));
  declare_device_parameters(*this);
}

Result<Vl53l0xOptions, Problem> Vl53l0xComponent::read_options() const {
  Vl53l0xOptions options;
  const auto refusal = [this](const char* name, std::string what, std::string way_out) {
    return err(Problem{Place::of_parameter(name, get_fully_qualified_name()), std::move(what), std::move(way_out)});
  };
  options.bus = get<std::string>("port");
  options.sensor.address = static_cast<std::uint8_t>(get<std::int64_t>("address"));
  options.frame_id = frame_name(*this, "frame_id");
  options.sensor.period = from_seconds(1.0 / get<double>("rate"));
  options.sensor.budget = from_seconds(get<double>("timing_budget"));
  if (options.sensor.period < options.sensor.budget + kBetween) {
    return refusal("timing_budget",
                   fmt::format("{} s and 5 ms are longer than a period of {:.4f} s", to_seconds(options.sensor.budget),
                               to_seconds(options.sensor.period)),
                   "lower it or rate");
  }
  options.least_m = get<double>("min_range");
  options.most_m = get<double>("max_range");
  if (options.least_m >= options.most_m) {
    return refusal("min_range", fmt::format("{} m is not below max_range {} m", options.least_m, options.most_m),
                   "a VL53L0X measures from 0.03 to 2");
  }
  options.field_of_view_rad = get<double>("field_of_view");
  options.port_timeout = from_seconds(get<double>("port_timeout"));
  options.silence_limit = from_seconds(get<double>("silence_limit"));
  auto device = read_device_parameters(*this);
  if (!device) return err(device.error());
  options.device = *device;
  return options;
}

std::string Vl53l0xComponent::title() const {
  return fmt::format("VL53L0X at 0x{:02x} of {}", options_.sensor.address, options_.bus);
}

CallbackReturn Vl53l0xComponent::on_configure(const State&) {
  const auto options = read_options();
  if (!options) return refuse(options.error());
  options_ = *options;
  auto bus = open_bus_(options_, steady_clock());
  if (!bus) return refuse(bus.error());
  stream_ = std::make_unique<Vl53l0xStream>(std::move(bus).value(), options_.sensor, steady_clock());
  absence_.clear();
  if (stream_->is_away()) {
    absence_ = io::explain(io::StreamFault::NotFound);
  } else if (const auto done = stream_->device().set_up(); !done) {
    // One that does not answer may come later; one that says that it is another chip never becomes the right one.
    if (options_.device.required || done.error().fault == io::StreamFault::NotUsable) {
      close();
      return refuse(Problem{title(), done.error().what, done.error().way_out});
    }
    absence_ = done.error().what;
    stream_->start_away();
  }
  return CallbackReturn::SUCCESS;
}

CallbackReturn Vl53l0xComponent::on_activate(const State&) {
  watch_ = std::make_unique<DeviceWatch>(
      *this, options_.device,
      DeviceWatch::Settings{title(), silence_of(options_.sensor.period), "RANGE_SILENT", options_.silence_limit},
      steady_clock().now());
  if (absence_.empty()) {
    if (const auto started = stream_->device().start(); !started) {
      absence_ = started.error().what;
      stream_->start_away();
    }
  }
  if (!absence_.empty()) watch_->lose(absence_);  // reported here, so that the bring-up can name it
  sink_ = std::make_unique<Vl53l0xPublisher>(options_, steady_clock(), publisher_, *watch_);
  reader_ = std::make_unique<io::ReaderThread>(
      *stream_, steady_clock(), *sink_,
      io::ReaderThread::Options{.name = "range",
                                .set_up = [this]() -> Result<void, io::StreamFault> {
                                  auto& device = stream_->device();
                                  if (auto done = device.set_up(); !done) return err(done.error().fault);
                                  if (auto done = device.start(); !done) return err(done.error().fault);
                                  return {};
                                },
                                .on_exception = [this](const std::string& text) { fault("RANGE_ENDED", text); }});
  return CallbackReturn::SUCCESS;
}

CallbackReturn Vl53l0xComponent::on_deactivate(const State&) {
  reader_.reset();
  const bool is_lost = watch_->is_lost();
  const Vl53l0xCounters counters = sink_->counters();
  get_logger().info("{} results, {} that mean nothing, {} transfers tried again; {} published", counters.line.results,
                    counters.invalid, stream_->device().retries(), counters.published);
  sink_.reset();
  watch_.reset();
  absence_.clear();
  if (const auto stopped = stream_->device().stop(); !stopped) {
    absence_ = stopped.error().what;
    stream_->start_away();
    if (!is_lost) get_logger().warn("{}: it could not be stopped: {}", title(), absence_);
  }
  return CallbackReturn::SUCCESS;
}

CallbackReturn Vl53l0xComponent::on_cleanup(const State&) {
  close();
  return CallbackReturn::SUCCESS;
}

void Vl53l0xComponent::close() {
  const bool measures = reader_ != nullptr;
  reader_.reset();
  sink_.reset();
  watch_.reset();
  if (measures) static_cast<void>(stream_->device().stop());
  stream_.reset();
}

}  // namespace nacelle::range
