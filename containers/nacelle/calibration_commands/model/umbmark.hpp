// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "calibration_commands/model/base_fit.hpp"

namespace nacelle::calibration {

/// Where a base really stood after a square, minus where its wheels said. Frame: the base at the beginning, x ahead, y left.
struct SquareError {
  double x_m = 0.0, y_m = 0.0;
};

/// What squares both ways say about a base.
///
/// Type A errors turn each corner too far or not far enough, both ways: the separation is wrong. Type B errors bend each side to
/// the same hand, both ways: the wheels are not equally large. A square one way alone cannot tell them apart.
struct Umbmark {
  SquareError clockwise, counter_clockwise;  ///< Centres of gravity.
  double alpha_rad = 0.0;                    ///< Type A: a corner turns by so much less than the wheels say.
  double beta_rad = 0.0;                     ///< Type B: a side turns the base to the left by so much.
  double separation_ratio = 1.0;             ///< E_b: real over believed.
  double radius_ratio = 1.0;                 ///< E_d: right over left, relative to the believed ratio.
  double worst_m = 0.0;                      ///< E_max,syst: the longer distance of both centres of gravity from zero.
};

/// Computes it from the errors of squares each way; both lists have an entry.
///
/// With L the side, (x, y) the centres of gravity of the errors, cw and ccw the way round, and the means of the results of x and of y:
///   alpha = (x_cw + x_ccw) / (-4 L) = (y_cw - y_ccw) / (-4 L)         E_b = (pi/2) / (pi/2 - alpha)
///   beta  = (x_cw - x_ccw) / (-4 L) = (y_cw + y_ccw) / (-4 L)         R = (L / 2) / sin(beta / 2)
///   E_d = (R + b / 2) / (R - b / 2)                                   E_max,syst = max(|cw|, |ccw|)
/// They are of first order in alpha and beta.
/// Source: Borenstein and Feng, "Measurement and Correction of Systematic Odometry Errors in Mobile Robots", IEEE Transactions on
///         Robotics and Automation 12(6), 1996, pp. 869-880; derived for this frame in docs/ekf.md.
[[nodiscard]] Umbmark umbmark_of(const std::vector<SquareError>& clockwise,
                                 const std::vector<SquareError>& counter_clockwise, double side_m, double separation_m);

/// Returns the base with the separation times E_b, and the radii in the ratio of E_d with the same mean. Source: as above:
/// c_l = 2 / (E_d + 1), c_r = 2 / (1 / E_d + 1). Squares do not show the radii's mean.
[[nodiscard]] BaseGeometry corrected(const BaseGeometry& believed, const Umbmark& found);

}  // namespace nacelle::calibration
