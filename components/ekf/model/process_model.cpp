// SPDX-License-Identifier: Apache-2.0
#include "ekf/model/process_model.hpp"

#include <cmath>

#include "ekf/model/row.hpp"
#include "nacelle/spatial/angles.hpp"

namespace nacelle::ekf {
namespace {

using spatial::wrap_to_pi;

struct Angles {
  explicit Angles(const StateVector& x)
      : sr(std::sin(x[kRoll])),
        cr(std::cos(x[kRoll])),
        sp(std::sin(x[kPitch])),
        cp(std::cos(x[kPitch])),
        sy(std::sin(x[kYaw])),
        cy(std::cos(x[kYaw])),
        over_cp(1.0 / cp),
        tp(sp * over_cp) {}
  double sr, cr, sp, cp, sy, cy, over_cp, tp;
};

// The parts of the Jacobian that are neither 0 nor 1. Rows and columns of 3: position p, angles q, velocity v, rates w.
struct Blocks {
  double pq[3][3];  // d position / d (roll, pitch, yaw)
  double R[3][3];   // d position / d velocity = R dt, d position / d acceleration = R dt^2/2
  double qq[3][2];  // d angles / d (roll, pitch), without the 1 of the diagonal; yaw never enters
  double qw[3][3];  // d angles / d rates
};

Blocks blocks_of(const StateVector& x, const Angles& a, double dt) {
  Blocks b{};
  const double h = 0.5 * dt * dt;
  const double dx = x[kVx] * dt + x[kAx] * h;  // the step along the body's axes
  const double dy = x[kVy] * dt + x[kAy] * h;
  const double dz = x[kVz] * dt + x[kAz] * h;
  const double R[3][3] = {{a.cy * a.cp, a.cy * a.sp * a.sr - a.sy * a.cr, a.cy * a.sp * a.cr + a.sy * a.sr},
                          {a.sy * a.cp, a.sy * a.sp * a.sr + a.cy * a.cr, a.sy * a.sp * a.cr - a.cy * a.sr},
                          {-a.sp, a.cp * a.sr, a.cp * a.cr}};
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) b.R[i][j] = R[i][j];
    b.pq[i][0] = R[i][2] * dy - R[i][1] * dz;  // turning about the body's x axis takes y to z and z to -y
  }
  const double forward = -a.sp * dx + a.cp * a.sr * dy + a.cp * a.cr * dz;
  b.pq[0][1] = a.cy * forward;
  b.pq[1][1] = a.sy * forward;
  b.pq[2][1] = -a.cp * dx - a.sp * a.sr * dy - a.sp * a.cr * dz;
  b.pq[0][2] = -(R[1][0] * dx + R[1][1] * dy + R[1][2] * dz);  // turning about the world's z axis takes x to y
  b.pq[1][2] = R[0][0] * dx + R[0][1] * dy + R[0][2] * dz;
  b.pq[2][2] = 0.0;

  const double across = a.cr * x[kVpitch] - a.sr * x[kVyaw];
  const double along = a.sr * x[kVpitch] + a.cr * x[kVyaw];
  b.qq[0][0] = dt * across * a.tp;
  b.qq[0][1] = dt * along * a.over_cp * a.over_cp;
  b.qq[1][0] = -dt * along;
  b.qq[1][1] = 0.0;
  b.qq[2][0] = dt * across * a.over_cp;
  b.qq[2][1] = dt * along * a.tp * a.over_cp;

  b.qw[0][0] = dt;
  b.qw[0][1] = dt * a.sr * a.tp;
  b.qw[0][2] = dt * a.cr * a.tp;
  b.qw[1][0] = 0.0;
  b.qw[1][1] = dt * a.cr;
  b.qw[1][2] = -dt * a.sr;
  b.qw[2][0] = 0.0;
  b.qw[2][1] = dt * a.sr * a.over_cp;
  b.qw[2][2] = dt * a.cr * a.over_cp;
  return b;
}

StateVector propagate(const StateVector& x, const Blocks& b, double dt) {
  StateVector to = x;
  const double h = 0.5 * dt * dt;
  const double step[3] = {x[kVx] * dt + x[kAx] * h, x[kVy] * dt + x[kAy] * h, x[kVz] * dt + x[kAz] * h};
  for (int i = 0; i < 3; ++i) {
    to[kX + i] += b.R[i][0] * step[0] + b.R[i][1] * step[1] + b.R[i][2] * step[2];
    const double turn = b.qw[i][0] * x[kVroll] + b.qw[i][1] * x[kVpitch] + b.qw[i][2] * x[kVyaw];
    to[kRoll + i] = wrap_to_pi(x[kRoll + i] + turn);
    to[kVx + i] += dt * x[kAx + i];
  }
  return to;
}

}  // namespace

StateVector propagate(const StateVector& from, double dt_s) {
  return propagate(from, blocks_of(from, Angles{from}, dt_s), dt_s);
}

StateMatrix jacobian(const StateVector& from, double dt_s) {
  const Blocks b = blocks_of(from, Angles{from}, dt_s);
  StateMatrix J = StateMatrix::Identity();
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      J(kX + i, kRoll + j) = b.pq[i][j];
      J(kX + i, kVx + j) = b.R[i][j] * dt_s;
      J(kX + i, kAx + j) = b.R[i][j] * 0.5 * dt_s * dt_s;
      J(kRoll + i, kVroll + j) = b.qw[i][j];
    }
    J(kRoll + i, kRoll) += b.qq[i][0];
    J(kRoll + i, kPitch) += b.qq[i][1];
    J(kVx + i, kAx + i) = dt_s;
  }
  return J;
}

void advance(Belief& belief, double dt_s, const ProcessNoise& noise) { advance(belief, belief.mean, dt_s, noise); }

void advance(Belief& belief, const StateVector& commanded, double dt_s, const ProcessNoise& noise) {
  const Blocks b = blocks_of(belief.mean, Angles{belief.mean}, dt_s);
  belief.mean = propagate(commanded, b, dt_s);
  StateCovariance& P = belief.covariance;

  // T = J P by rows. Position sees velocity and acceleration only as R dt (v + dt/2 a): one combined row instead of two.
  Row T[kStates];
  Row step[3];
  for (int i = 0; i < 3; ++i) {
    const Row velocity = Row::load(P.row(kVx + i));
    T[kAx + i] = Row::load(P.row(kAx + i));
    T[kVroll + i] = Row::load(P.row(kVroll + i));
    step[i] = velocity;
    step[i].add(0.5 * dt_s, T[kAx + i]);
    step[i].scale(dt_s);
    T[kVx + i] = velocity;
    T[kVx + i].add(dt_s, T[kAx + i]);
  }
  const Row roll = Row::load(P.row(kRoll));
  const Row pitch = Row::load(P.row(kPitch));
  const Row yaw = Row::load(P.row(kYaw));
  const Row* const angles[3] = {&roll, &pitch, &yaw};
  for (int i = 0; i < 3; ++i) {
    Row position = Row::load(P.row(kX + i));
    position.add(b.pq[i][0], roll);
    position.add(b.pq[i][1], pitch);
    if (i < 2) position.add(b.pq[i][2], yaw);
    for (int k = 0; k < 3; ++k) position.add(b.R[i][k], step[k]);
    T[kX + i] = position;

    Row angle = *angles[i];
    angle.add(b.qq[i][0], roll);
    if (i != 1) angle.add(b.qq[i][1], pitch);
    if (i == 0) angle.add(b.qw[i][0], T[kVroll]);
    angle.add(b.qw[i][1], T[kVpitch]);
    angle.add(b.qw[i][2], T[kVyaw]);
    T[kRoll + i] = angle;
  }

  // T J^T + dt Q by columns, the lower triangle only: rows before a group of columns do not need it.
  for (int i = 0; i < kStates; ++i) {
    alignas(16) double t[StateCovariance::kStride];
    T[i].store(t);
    double* const row = P.row(i);
    const double s[3] = {dt_s * (t[kVx] + 0.5 * dt_s * t[kAx]), dt_s * (t[kVy] + 0.5 * dt_s * t[kAy]),
                         dt_s * (t[kVz] + 0.5 * dt_s * t[kAz])};
    for (int c = 0; c < 3; ++c) {
      row[kX + c] = t[kX + c] + b.pq[c][0] * t[kRoll] + b.pq[c][1] * t[kPitch] + b.pq[c][2] * t[kYaw] +
                    b.R[c][0] * s[0] + b.R[c][1] * s[1] + b.R[c][2] * s[2];
    }
    if (i >= kRoll) {
      for (int c = 0; c < 3; ++c) {
        row[kRoll + c] = t[kRoll + c] + b.qq[c][0] * t[kRoll] + b.qq[c][1] * t[kPitch] + b.qw[c][0] * t[kVroll] +
                         b.qw[c][1] * t[kVpitch] + b.qw[c][2] * t[kVyaw];
      }
    }
    if (i >= kVx) {
      for (int c = 0; c < 3; ++c) row[kVx + c] = t[kVx + c] + dt_s * t[kAx + c];
    }
    for (int c = kVroll; c <= i; ++c) row[c] = t[c];
    const double* const Q = noise.rate.row(i);
    for (int c = noise.diagonal ? i : 0; c <= i; ++c) row[c] += dt_s * Q[c];
    for (int c = 0; c < i; ++c) P.row(c)[i] = row[c];
  }
}

ProcessNoise scaled_by_velocity(const ProcessNoise& noise, const StateVector& state) {
  ProcessNoise scaled = noise;
  const double factor = state.segment<6>(kVx).squaredNorm();
  for (int i = 0; i < 6; ++i) {
    for (int j = 0; j < 6; ++j) scaled.rate(i, j) *= factor;
  }
  return scaled;
}

}  // namespace nacelle::ekf
