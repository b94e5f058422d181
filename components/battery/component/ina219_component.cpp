// SPDX-License-Identifier: Apache-2.0
#include "battery/component/ina219_component.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string_view>
#include <utility>

#include "nacelle/io/i2c_bus.hpp"

namespace nacelle::battery {
namespace {

using sensor_msgs::msg::BatteryState;

struct Technology {
  std::string_view name;
  std::uint8_t value;
};
constexpr std::array kTechnologies{
    Technology{"unknown", BatteryState::POWER_SUPPLY_TECHNOLOGY_UNKNOWN},
    Technology{"nimh", BatteryState::POWER_SUPPLY_TECHNOLOGY_NIMH},
    Technology{"lion", BatteryState::POWER_SUPPLY_TECHNOLOGY_LION},
    Technology{"lipo", BatteryState::POWER_SUPPLY_TECHNOLOGY_LIPO},
    Technology{"life", BatteryState::POWER_SUPPLY_TECHNOLOGY_LIFE},
    Technology{"nicd", BatteryState::POWER_SUPPLY_TECHNOLOGY_NICD},
    Technology{"limn", BatteryState::POWER_SUPPLY_TECHNOLOGY_LIMN},
    Technology{"ternary", BatteryState::POWER_SUPPLY_TECHNOLOGY_TERNARY},
    Technology{"vrla", BatteryState::POWER_SUPPLY_TECHNOLOGY_VRLA},
};

Result<std::unique_ptr<io::RegisterBus>, Problem> open_i2c(const Ina219Options& options, const Clock& clock) {
  const io::I2cSettings settings{options.bus, options.address};
  auto bus = options.device.required ? io::I2cBus::open(settings, clock, options.port_timeout)
                                     : io::I2cBus::open_or_await(settings, clock);
  if (!bus) return err(std::move(bus).error());
  return std::unique_ptr<io::RegisterBus>{std::move(bus).value()};
}

ParameterDescriptor described(std::string text) { return {.description = std::move(text)}; }
ParameterDescriptor within(std::string text, double from, double to) {
  return {.description = std::move(text), .floating_point_range = FloatingPointRange{from, to}};
}

}  // namespace

Ina219Component::Ina219Component(const NodeOptions& options) : Ina219Component(options, open_i2c) {}

Ina219Component::Ina219Component(const NodeOptions& options, OpenBus open_bus)
    : LifecycleNode("battery", options), open_bus_(std::move(open_bus)) {
  declare_parameters();
  // A bus is shared; a chip on it is not.
  declare_device_use(fmt::format("{} address 0x{:02x}", get<std::string>("port"), get<std::int64_t>("address")),
                     "port");
  if (const auto read = read_options(); !read) declare_problem(read.error());
  publisher_ = create_publisher<BatteryState>("battery_state", QoS(10));
}

Ina219Component::~Ina219Component() { close(); }

void Ina219Component::declare_parameters() {
  const Ina219Options defaults;
  declare_parameter("port", defaults.bus, described("I2C bus of the chip, e.g. /dev/i2c-1"));
  declare_parameter(
      "address", static_cast<int>(defaults.address),
      {.description = "I2C address of the chip, set by its pins A0 and A1", .integer_range = IntegerRange{0x40, 0x4F}});
  declare_parameter("shunt_ohms", defaults.shunt_ohms, within("Ohm, of the shunt between IN+ and IN-", 0.0001, 10.0));
  declare_parameter("max_current", defaults.battery.max_current_a,
                    within("A, the highest that is measured; a lower one is measured in finer steps", 0.001, 1000.0));
  declare_parameter("reversed", defaults.battery.is_reversed,
                    described("the battery is at IN- and the load at IN+; usually it is the other way round"));
  declare_parameter("rate", 1.0, within("Hz; a slow one has more samples in each mean", 0.1, 100.0));
  declare_parameter("empty_voltage", 0.0,
                    within("V of the empty battery, for percentage; 0: no percentage", 0.0, 26.0));
  declare_parameter("full_voltage", 0.0, within("V of the full battery, for percentage; 0: no percentage", 0.0, 26.0));
  declare_parameter("design_capacity", defaults.design_capacity_ah, within("Ah; 0: unknown", 0.0, 10000.0));
  std::string names;
  for (const Technology& technology : kTechnologies)
    names += (names.empty() ? "" : ", ") + std::string(technology.name);
  declare_parameter("power_supply_technology", std::string("unknown"), described("of the battery: " + names));
  declare_parameter("location", defaults.location, described("where the battery is, e.g. its slot; may be empty"));
  declare_parameter("port_timeout", to_seconds(defaults.port_timeout),
                    within("s that configure waits for the bus, with required_device", 0.0, 3600.0));
  declare_parameter("silence_limit", to_seconds(defaults.silence_limit),
                    within("s without a reading that are a fault, with device_lost: fault", 0.01, 3600.0));
  declare_device_parameters(*this);
}

Result<Ina219Options, Problem> Ina219Component::read_options() const {
  Ina219Options options;
  const auto refusal = [this](const char* name, std::string what, std::string way_out) {
    return err(Problem{Place::of_parameter(name, get_fully_qualified_name()), std::move(what), std::move(way_out)});
  };
  options.bus = get<std::string>("port");
  options.address = static_cast<std::uint8_t>(get<std::int64_t>("address"));
  options.shunt_ohms = get<double>("shunt_ohms");
  options.battery.max_current_a = get<double>("max_current");
  options.battery.is_reversed = get<bool>("reversed");
  options.period = from_seconds(1.0 / get<double>("rate"));
  const auto setup = ina219_setup(options.shunt_ohms, options.battery.max_current_a, options.period);
  if (!setup) {
    return refusal("max_current",
                   fmt::format("{} A are {:.3f} V over a shunt of {} Ohm, and an INA219 measures up to {} V",
                               options.battery.max_current_a, options.battery.max_current_a * options.shunt_ohms,
                               options.shunt_ohms, kIna219WidestShunt_v),
                   fmt::format("lower it to {:.3g}, or fit a smaller shunt and set shunt_ohms",
                               kIna219WidestShunt_v / options.shunt_ohms));
  }
  options.setup = *setup;
  const double empty_v = get<double>("empty_voltage"), full_v = get<double>("full_voltage");
  if (full_v > 0.0 || empty_v > 0.0) {
    if (!(full_v > empty_v)) {
      return refusal("full_voltage", fmt::format("{} V is not above empty_voltage {} V", full_v, empty_v),
                     "for three cells of LiPo: 9.9 and 12.6; both 0 for no percentage");
    }
    options.battery.empty_v = empty_v;
    options.battery.full_v = full_v;
  }
  options.design_capacity_ah = get<double>("design_capacity");
  const auto name = get<std::string>("power_supply_technology");
  const auto technology = std::find_if(kTechnologies.begin(), kTechnologies.end(),
                                       [&](const Technology& known) { return known.name == name; });
  if (technology == kTechnologies.end()) {
    std::vector<std::string> names;
    for (const Technology& known : kTechnologies) names.emplace_back(known.name);
    return refusal("power_supply_technology", fmt::format("'{}' is no technology", name), suggestion(name, names));
  }
  options.technology = technology->value;
  options.location = get<std::string>("location");
  options.port_timeout = from_seconds(get<double>("port_timeout"));
  options.silence_limit = from_seconds(get<double>("silence_limit"));
  auto device = read_device_parameters(*this);
  if (!device) return err(device.error());
  options.device = *device;
  return options;
}

std::string Ina219Component::title() const {
  return fmt::format("INA219 at 0x{:02x} of {}", options_.address, options_.bus);
}

CallbackReturn Ina219Component::on_configure(const State&) {
  const auto options = read_options();
  if (!options) return refuse(options.error());
  options_ = *options;
  auto bus = open_bus_(options_, steady_clock());
  if (!bus) return refuse(bus.error());
  stream_ = std::make_unique<io::RegisterStream>(std::move(bus).value(), ina219_blocks(options_.address),
                                                 options_.period, steady_clock());
  absence_.clear();
  if (stream_->is_away()) {
    absence_ = io::explain(io::StreamFault::NotFound);
  } else if (const auto done = chip().set_up(); !done) {
    // One that does not answer may come later; one that is another chip never becomes the right one.
    if (options_.device.required || done.error().fault == io::StreamFault::NotUsable) {
      const Problem problem{title(), done.error().what, done.error().way_out};
      close();
      return refuse(problem);
    }
    absence_ = done.error().what;
    stream_->start_away();
  } else {
    static_cast<void>(chip().power_down());  // only an active node measures
  }
  return CallbackReturn::SUCCESS;
}

CallbackReturn Ina219Component::on_activate(const State&) {
  watch_ = std::make_unique<DeviceWatch>(
      *this, options_.device,
      DeviceWatch::Settings{title(), silence_of(options_.period), "BATTERY_SILENT", options_.silence_limit},
      steady_clock().now());
  if (absence_.empty()) {
    if (const auto done = chip().set_up(); !done) {
      absence_ = done.error().what;
      stream_->start_away();
    }
  }
  if (!absence_.empty()) watch_->lose(absence_);  // reported here, so that the bring-up can name it
  sink_ = std::make_unique<Ina219Publisher>(options_, steady_clock(), publisher_, get_logger(), *watch_);
  reader_ = std::make_unique<io::ReaderThread>(
      *stream_, steady_clock(), *sink_,
      io::ReaderThread::Options{.name = "battery",
                                .set_up = [this]() -> Result<void, io::StreamFault> {
                                  if (auto done = chip().set_up(); !done) return err(done.error().fault);
                                  return {};
                                },
                                .on_exception = [this](const std::string& text) { fault("BATTERY_ENDED", text); }});
  return CallbackReturn::SUCCESS;
}

CallbackReturn Ina219Component::on_deactivate(const State&) {
  reader_.reset();
  const bool is_lost = watch_->is_lost();
  const Ina219Counters counters = sink_->counters();
  get_logger().info(
      "{} readings, {} without a current, {} of a chip without its settings, {} transfers tried again; {} published",
      counters.line.readings, counters.unmeasurable, counters.strange, stream_->retries(), counters.published);
  sink_.reset();
  watch_.reset();
  absence_.clear();
  if (const auto done = chip().power_down(); !done) {
    absence_ = io::explain(done.error());
    stream_->start_away();
    if (!is_lost) get_logger().warn("{}: it could not be powered down: {}", title(), absence_);
  }
  return CallbackReturn::SUCCESS;
}

CallbackReturn Ina219Component::on_cleanup(const State&) {
  close();
  return CallbackReturn::SUCCESS;
}

void Ina219Component::close() {
  const bool measures = reader_ != nullptr;
  reader_.reset();
  sink_.reset();
  watch_.reset();
  if (measures) static_cast<void>(chip().power_down());
  stream_.reset();
}

}  // namespace nacelle::battery
