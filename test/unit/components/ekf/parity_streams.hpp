// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <istream>
#include <random>
#include <string>
#include <string_view>
#include <vector>

/// Input streams for a comparison of two filters, made from a seed. Needs the standard library only, so that a program outside this
/// tree can give another filter the same messages.
///
/// Frames: the world is "odom", the base "base_link". Poses of input i come in the frame "world<i>", its velocities and readings
///         in "sensor<i>", which is fixed to the base.
namespace nacelle::ekf::parity {

enum class Kind : std::uint8_t { Odometry, Pose, Twist, Imu };
using Quaternion = std::array<double, 4>;  ///< x y z w
using Vector = std::array<double, 3>;

struct Mounting {
  Vector p{};
  Quaternion q{0.0, 0.0, 0.0, 1.0};
};
struct Input {
  Kind kind{};
  unsigned mask{};  ///< Bit i: state i is configured.
  bool differential{}, relative{}, pose_of_child{}, remove_gravity{};
  double gate{1e300};  ///< Of every part, not squared.
  double rate_hz{20.0};
  std::int64_t delay_ns{}, jitter_ns{};
  Mounting X_WM, X_BS;
};
struct Message {
  int input{};
  std::int64_t stamp_ns{}, arrival_ns{};
  Vector position{};
  Quaternion orientation{0.0, 0.0, 0.0, 1.0};
  std::array<double, 36> pose_covariance{};  ///< Imu: the orientation's 9.
  Vector linear{}, angular{};
  std::array<double, 36> twist_covariance{};  ///< Imu: the angular velocity's 9.
  Vector acceleration{};
  std::array<double, 9> acceleration_covariance{};
};
struct Command {
  std::int64_t arrival_ns{};
  std::array<double, 6> velocity{};
};
struct Stream {
  std::string family;
  unsigned seed{};
  std::int64_t start_ns{};
  bool two_d{}, dynamic_noise{}, predict_to_now{};
  double frequency_hz{30.0}, sensor_timeout_s{100.0};
  std::array<bool, 6> controlled{};
  double control_timeout_s{0.2};
  std::array<double, 6> limits{}, gains{}, slowing_limits{}, slowing_gains{};
  std::array<double, 225> process_noise{}, initial_covariance{};
  std::array<double, 15> initial_state{};
  std::vector<Input> inputs;
  std::vector<Message> messages;  ///< In the order of their arrival.
  std::vector<Command> commands;
  std::vector<std::int64_t> ticks_ns;
};

inline constexpr std::array<std::string_view, 12> kFamilies{
    "plain", "two_d",      "differential", "relative",       "dynamic_noise",  "control",
    "gates", "correlated", "disorder",     "predict_to_now", "sensor_timeout", "everything_on"};
inline constexpr unsigned kStreamsPerFamily = 6;
inline constexpr std::int64_t kStart_ns = 1'000'000'000'000;
inline constexpr int kSeconds = 8;

/// Numbers that are the same with every standard library.
class Dice {
 public:
  explicit Dice(unsigned seed) : bits_(seed) {}
  double between(double low, double high) {
    return low + (high - low) * (static_cast<double>(bits_() >> 11U) * 0x1.0p-53);
  }
  double normal() {
    const double radius = std::sqrt(-2.0 * std::log(between(1e-12, 1.0)));
    return radius * std::cos(between(0.0, 6.283185307179586));
  }
  bool chance(double share) { return between(0.0, 1.0) < share; }

 private:
  std::mt19937_64 bits_;
};

inline Quaternion product(const Quaternion& a, const Quaternion& b) {
  return {a[3] * b[0] + a[0] * b[3] + a[1] * b[2] - a[2] * b[1], a[3] * b[1] - a[0] * b[2] + a[1] * b[3] + a[2] * b[0],
          a[3] * b[2] + a[0] * b[1] - a[1] * b[0] + a[2] * b[3], a[3] * b[3] - a[0] * b[0] - a[1] * b[1] - a[2] * b[2]};
}
inline Quaternion inverse(const Quaternion& q) { return {-q[0], -q[1], -q[2], q[3]}; }
inline Vector turned(const Quaternion& q, const Vector& v) {
  const Quaternion r = product(product(q, {v[0], v[1], v[2], 0.0}), inverse(q));
  return {r[0], r[1], r[2]};
}
/// The rotation by a vector: its length is the angle.
inline Quaternion rotation(const Vector& v) {
  const double angle = std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
  const double k = angle < 1e-12 ? 0.5 : std::sin(0.5 * angle) / angle;
  return {k * v[0], k * v[1], k * v[2], std::cos(0.5 * angle)};
}
inline Vector cross(const Vector& a, const Vector& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
inline Vector sum(const Vector& a, const Vector& b) { return {a[0] + b[0], a[1] + b[1], a[2] + b[2]}; }
inline Mounting product(const Mounting& a, const Mounting& b) {
  return {sum(a.p, turned(a.q, b.p)), product(a.q, b.q)};
}
inline Mounting inverse(const Mounting& a) {
  const Vector p = turned(inverse(a.q), a.p);
  return {{-p[0], -p[1], -p[2]}, inverse(a.q)};
}

/// One millisecond of a smooth motion.
struct Truth {
  Mounting X_WB;
  Vector v_B{}, w_B{}, a_B{};
};
inline std::vector<Truth> motion(Dice& dice, bool flat) {
  std::array<double, 12> size{}, rate{}, phase{};
  for (std::size_t i = 0; i < 12; ++i) {
    size[i] = dice.between(0.1, 0.5) * (i < 6 ? 1.0 : 0.6);
    rate[i] = dice.between(0.5, 2.5);
    phase[i] = dice.between(0.0, 6.28);
  }
  const auto wave = [&](std::size_t i, double t) { return size[i] * std::sin(rate[i] * t + phase[i]); };
  std::vector<Truth> all;
  Mounting X;
  for (int k = 0; k <= kSeconds * 1000; ++k) {
    const double t = 1e-3 * k;
    Truth now{X,
              {0.6 + wave(0, t), 0.0, 0.0},
              {0.0, 0.0, wave(3, t)},
              {size[0] * rate[0] * std::cos(rate[0] * t + phase[0]), 0.0, 0.0}};
    if (!flat) {
      now.v_B[1] = wave(1, t);
      now.v_B[2] = wave(2, t);
      now.w_B[0] = wave(6, t);
      now.w_B[1] = wave(7, t);
      now.a_B[1] = wave(8, t);
    }
    all.push_back(now);
    X.p = sum(X.p, turned(X.q, {1e-3 * now.v_B[0], 1e-3 * now.v_B[1], 1e-3 * now.v_B[2]}));
    X.q = product(X.q, rotation({1e-3 * now.w_B[0], 1e-3 * now.w_B[1], 1e-3 * now.w_B[2]}));
  }
  return all;
}

/// A covariance of n rows; with correlations if asked for.
template <std::size_t Size>
void fill_covariance(Dice& dice, std::size_t n, double scale, double correlation, std::array<double, Size>& out) {
  std::array<double, 15 * 15> half{};
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t j = 0; j < n; ++j) {
      if (i == j) half[i * n + j] = dice.between(0.5, 1.5);
      if (i != j && correlation > 0.0) half[i * n + j] = dice.between(-correlation, correlation);
    }
  }
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t j = 0; j < n; ++j) {
      double c = 0.0;
      for (std::size_t k = 0; k < n; ++k) c += half[i * n + k] * half[j * n + k];
      out[i * n + j] = scale * c;
    }
  }
}

/// The same variance for the three axes of each vector: a mounting that is turned gives no correlations.
template <std::size_t Size>
void make_isotropic(std::size_t n, std::array<double, Size>& covariance) {
  for (std::size_t i = 0; i < n; ++i) covariance[i * (n + 1)] = covariance[i / 3 * 3 * (n + 1)];
}

/// What the inputs say of a motion, one message each period, with noise and, if asked for, with outliers.
inline void add_messages(Dice& dice, const std::vector<Truth>& truth, int number, double outliers, bool correlated,
                         Stream& s) {
  const Input& in = s.inputs[static_cast<std::size_t>(number)];
  const auto noisy = [&](const Vector& v, double sigma) {
    return Vector{v[0] + sigma * dice.normal(), v[1] + sigma * dice.normal(), v[2] + sigma * dice.normal()};
  };
  for (double t = dice.between(0.01, 0.05); t < kSeconds; t += 1.0 / in.rate_hz) {
    const auto ms = static_cast<std::size_t>(t * 1000.0);
    const Truth& now = truth[std::min(ms, truth.size() - 1)];
    Message m;
    m.input = number;
    // No two inputs have one stamp: at a rejection threshold the order in which they are fused would count.
    m.stamp_ns = kStart_ns + static_cast<std::int64_t>(ms) * 1'000'000 + number * 1000;
    m.arrival_ns = m.stamp_ns + in.delay_ns +
                   static_cast<std::int64_t>(dice.between(0.0, 1.0) * static_cast<double>(in.jitter_ns));
    const double wrong = dice.chance(in.gate < 1e300 ? outliers : 0.0) ? 30.0 : 1.0;
    const Quaternion q_SB = inverse(in.X_BS.q);
    const Vector lever = cross(now.w_B, in.X_BS.p);
    m.angular = noisy(turned(q_SB, now.w_B), 0.01 * wrong);
    if (in.kind == Kind::Imu) {
      m.orientation = product(product(now.X_WB.q, in.X_BS.q), rotation(noisy({}, 0.01 * wrong)));
      const Vector up = turned(inverse(m.orientation), {0.0, 0.0, 9.80665});
      m.acceleration = noisy(turned(q_SB, sum(now.a_B, cross(now.w_B, lever))), 0.05 * wrong);
      if (in.remove_gravity) m.acceleration = sum(m.acceleration, up);
      fill_covariance(dice, 3, 1e-4, correlated ? 0.4 : 0.0, m.pose_covariance);
      fill_covariance(dice, 3, 1e-4, correlated ? 0.4 : 0.0, m.twist_covariance);
      fill_covariance(dice, 3, 3e-3, correlated ? 0.4 : 0.0, m.acceleration_covariance);
    } else {
      Mounting pose = product(inverse(in.X_WM), now.X_WB);
      if (in.pose_of_child) pose = product(pose, in.X_BS);
      m.position = noisy(pose.p, 0.02 * wrong);
      m.orientation = product(pose.q, rotation(noisy({}, 0.01 * wrong)));
      m.linear = noisy(turned(q_SB, sum(now.v_B, lever)), 0.02 * wrong);
      fill_covariance(dice, 6, 4e-4, correlated ? 0.4 : 0.0, m.pose_covariance);
      fill_covariance(dice, 6, 4e-4, correlated ? 0.4 : 0.0, m.twist_covariance);
    }
    if (s.two_d) {  // robot_localization keeps correlations of what it holds at zero; see docs/ekf.md
      make_isotropic(in.kind == Kind::Imu ? 3 : 6, m.pose_covariance);
      make_isotropic(in.kind == Kind::Imu ? 3 : 6, m.twist_covariance);
      make_isotropic(3, m.acceleration_covariance);
    }
    s.messages.push_back(m);
  }
}

inline Mounting tilted(Dice& dice, double most_rad, bool flat) {
  const auto any = [&](double most) { return dice.between(-most, most); };
  const double tilt_rad = flat ? 0.0 : most_rad;
  return {{any(0.4), any(0.3), any(0.5)}, rotation({any(tilt_rad), any(tilt_rad), any(2.0 * most_rad)})};
}

/// The stream of a family and a seed.
inline Stream make_stream(std::string_view family, unsigned seed) {
  const auto is = [&](std::string_view name) { return family == name || family == "everything_on"; };
  const bool all = family == "everything_on";
  Dice dice{seed * 7919U + static_cast<unsigned>(family.size()) * 104729U + static_cast<unsigned char>(family[0])};
  Stream s;
  s.family = family;
  s.seed = seed;
  s.start_ns = kStart_ns;
  s.two_d = family == "two_d" || (all && seed % 2 == 0) || (family == "control" && seed % 2 == 0);
  s.dynamic_noise = is("dynamic_noise");
  s.predict_to_now = is("predict_to_now");
  s.frequency_hz = seed % 2 == 0 ? 30.0 : 50.0;
  if (is("sensor_timeout")) s.sensor_timeout_s = family == "everything_on" ? 0.15 : 1.0 / s.frequency_hz;
  const bool correlated = is("correlated") && !s.two_d;
  const double tilt = is("differential") || is("relative") ? 0.35 : seed % 3 == 0 ? 0.1 : 0.0;

  Input wheels{.kind = Kind::Odometry, .mask = 0x0FC0, .rate_hz = 20.0};
  Input imu{.kind = Kind::Imu, .mask = 0x0E38, .rate_hz = 60.0};
  Input pose{.kind = Kind::Pose, .mask = 0x003F, .rate_hz = 5.0};
  Input twist{.kind = Kind::Twist, .mask = 0x0FC0, .rate_hz = 10.0};
  if (seed % 2 == 1 && family != "control") imu.mask |= 0x7000;
  if (is("differential")) {
    wheels.mask = 0x003F;
    wheels.differential = imu.differential = true;
    wheels.pose_of_child = seed % 3 == 1;
    pose.differential = seed % 3 == 2;
  }
  if (is("relative")) {
    if (!all) imu.relative = true;
    pose.relative = true;
    if (!all) wheels.mask = 0x0FFF;
    if (!all) wheels.relative = true;
  }
  if (family == "plain" || family == "correlated") wheels.mask = 0x0FFF;
  if (family == "two_d" && seed % 3 == 0) {  // what a wheeled robot gives
    wheels.mask = 0x00C0;
    imu.mask = 0x0800;
  }
  imu.remove_gravity = seed % 4 == 1 && !all;
  if (is("gates")) wheels.gate = pose.gate = 4.0;
  if (family == "gates") imu.gate = twist.gate = 4.0;
  if (is("disorder")) {
    wheels.delay_ns = 30'000'000;
    imu.delay_ns = seed % 3 == 0 ? -20'000'000 : 5'000'000;
    pose.delay_ns = 150'000'000;
    twist.delay_ns = 70'000'000;
    wheels.jitter_ns = imu.jitter_ns = pose.jitter_ns = twist.jitter_ns = 40'000'000;
  }
  if (family == "sensor_timeout") wheels.rate_hz = imu.rate_hz = twist.rate_hz = 7.0;
  for (Input* const in : {&wheels, &imu, &pose, &twist}) {
    in->X_BS = tilted(dice, tilt, s.two_d);
    if (tilt > 0.0 && (in == &pose || seed % 2 == 0)) in->X_WM = tilted(dice, tilt, s.two_d);
  }
  s.inputs = {wheels, imu, pose, twist};

  // Scaled by the velocity, correlations of the pose with the rest would make no covariance of it.
  fill_covariance(dice, 15, 0.03, correlated && !s.dynamic_noise ? 0.4 : 0.0, s.process_noise);
  fill_covariance(dice, 15, family == "gates" ? 0.1 : 1e-3, correlated ? 0.02 : 0.0, s.initial_covariance);
  for (std::size_t i = 0; i < 15; ++i) s.initial_state[i] = 0.1 * dice.normal();
  const auto truth = motion(dice, s.two_d);
  for (int i = 0; i < 4; ++i) add_messages(dice, truth, i, is("gates") ? 0.1 : 0.0, correlated, s);
  std::stable_sort(s.messages.begin(), s.messages.end(),
                   [](const Message& a, const Message& b) { return a.arrival_ns < b.arrival_ns; });
  if (is("control")) {
    s.controlled = {true, seed % 3 == 0, false, false, false, true};
    if (all && (imu.mask & 0x7000U) != 0) s.controlled[0] = s.controlled[1] = false;
    for (std::size_t i = 0; i < 6; ++i) {
      s.limits[i] = dice.between(0.5, 2.0);
      s.gains[i] = dice.between(0.5, 2.0);
      s.slowing_limits[i] = dice.between(0.5, 2.0);
      s.slowing_gains[i] = dice.between(0.5, 2.0);
    }
    for (int k = 0; k < 10 * kSeconds; ++k) {
      if (k % 20 > 14) continue;  // the commands stop, and time out
      Command c{kStart_ns + std::int64_t{k} * 100'000'000, {}};
      for (double& v : c.velocity) v = dice.between(-1.0, 1.0);
      s.commands.push_back(c);
    }
  }
  const auto period_ns = static_cast<std::int64_t>(1e9 / s.frequency_hz);
  for (std::int64_t at = period_ns; at < std::int64_t{kSeconds} * 1'000'000'000; at += period_ns)
    s.ticks_ns.push_back(kStart_ns + at);
  return s;
}

/// A recording of robot_localization's tests, with the parameters that are theirs. `lines` are those of
/// test/data/ekf_parity/ros1_bag_messages.py. Source: test/test_ekf_localization_node_bag1.test and bag2.test of its branch noetic-devel.
inline Stream read_recording(std::istream& lines, unsigned number) {
  Stream s;
  s.family = "recording";
  s.seed = number;
  s.frequency_hz = number == 1 ? 30.0 : 50.0;
  s.sensor_timeout_s = 0.1;
  const std::array<double, 15> first{0.05, 0.05, 0.06, 0.03, 0.03, 0.06, 0.025, 0.025,
                                     0.04, 0.01, 0.01, 0.02, 0.01, 0.01, 0.015};
  const std::array<double, 15> second{0.03, 0.03,  0.04,  0.03,  0.03, 0.06, 0.025, 0.025,
                                      0.05, 0.002, 0.002, 0.004, 0.01, 0.01, 0.01};
  for (std::size_t i = 0; i < 15; ++i) {
    s.process_noise[i * 16] = (number == 1 ? first : second)[i];
    s.initial_covariance[i * 16] = 1e-9;
  }
  Input wheels{.kind = Kind::Odometry, .mask = number == 1 ? 0x01C0U : 0x09C0U};
  Input imu{.kind = Kind::Imu, .mask = number == 1 ? 0x7638U : 0x7E38U, .remove_gravity = true};
  const double half = std::sqrt(0.5);
  if (number == 1)
    imu.X_BS = {{0.0, -0.3, 0.52}, product(Quaternion{0.0, 0.0, -half, half}, Quaternion{half, 0.0, 0.0, half})};
  s.inputs = {wheels, imu};
  std::string kind, topic;
  Message m;
  const auto read = [&lines](auto& numbers, std::size_t count) {
    for (std::size_t i = 0; i < count; ++i) lines >> numbers[i];
  };
  while (lines >> kind >> topic >> m.arrival_ns >> m.stamp_ns) {
    m.input = kind == "imu" ? 1 : 0;
    if (kind == "imu") {
      read(m.orientation, 4);
      read(m.pose_covariance, 9);
      read(m.angular, 3);
      read(m.twist_covariance, 9);
      read(m.acceleration, 3);
      read(m.acceleration_covariance, 9);
    } else {
      read(m.position, 3);
      read(m.orientation, 4);
      read(m.pose_covariance, 36);
      read(m.linear, 3);
      read(m.angular, 3);
      read(m.twist_covariance, 36);
    }
    s.messages.push_back(m);
  }
  if (s.messages.empty()) return s;
  s.start_ns = s.messages.front().arrival_ns;
  const auto period_ns = static_cast<std::int64_t>(1e9 / s.frequency_hz);
  for (std::int64_t at = s.start_ns + period_ns; at <= s.messages.back().arrival_ns + period_ns; at += period_ns)
    s.ticks_ns.push_back(at);
  return s;
}

/// 46 numbers that say where a filter ended: the stamp in s from the stream's start, 15 of the mean, 15 variances, and 15 sums of the covariance's
/// rows with the weights 1, 2, ... 15, which depend on every correlation.
template <typename Covariance>
std::array<double, 46> end_state(const Stream& stream, std::int64_t stamp_ns, const std::array<double, 15>& mean,
                                 const Covariance& P) {
  std::array<double, 46> row{};
  row[0] = static_cast<double>(stamp_ns - stream.start_ns) * 1e-9;
  for (int i = 0; i < 15; ++i) {
    const auto n = static_cast<std::size_t>(i);
    row[1 + n] = mean[n];
    row[16 + n] = P(i, i);
    for (int j = 0; j < 15; ++j) row[31 + n] += (j + 1) * P(i, j);
  }
  return row;
}

}  // namespace nacelle::ekf::parity
