// SPDX-License-Identifier: Apache-2.0
#include "ekf/model/update.hpp"

#include <algorithm>
#include <cmath>

#include "ekf/model/row.hpp"
#include "nacelle/spatial/angles.hpp"

namespace nacelle::ekf {
namespace {

using spatial::wrap_to_pi;

// Above this ratio of prior to measured variance, rounding (2e-16 of the prior) is no longer small beside the posterior.
constexpr double kDelicateRatio = 1e10;

// L with L L^T = S in place (lower), the diagonal replaced by its inverse. False if a pivot is not positive.
bool factor(double (*S)[kStates], int n) {
  for (int j = 0; j < n; ++j) {
    double pivot = S[j][j];
    for (int k = 0; k < j; ++k) pivot -= S[j][k] * S[j][k];
    if (!(pivot > 0.0) || !std::isfinite(pivot)) return false;
    const double inverse = 1.0 / std::sqrt(pivot);
    S[j][j] = inverse;
    for (int i = j + 1; i < n; ++i) {
      double sum = S[i][j];
      for (int k = 0; k < j; ++k) sum -= S[i][k] * S[j][k];
      S[i][j] = sum * inverse;
    }
  }
  return true;
}

bool restore_definiteness(StateCovariance& covariance) {
  if (is_positive_definite(covariance)) return false;
  double lift = 0.0;
  for (int i = 0; i < kStates; ++i) lift = std::max(lift, 1e-16 * std::abs(covariance(i, i)));
  do {
    for (int i = 0; i < kStates; ++i) covariance(i, i) += lift;
    lift *= 2.0;
  } while (!is_positive_definite(covariance));
  return true;
}

// The reading beside the prior: innovation, R and rows of H P.
struct Comparison {
  int rows{};
  int at[kStates];
  double innovation[kStates];
  double R[kStates][kStates];
  Row HP[kStates];
  bool finite{}, independent{true};
  double largest_ratio{};
};

void compare(const Belief& prior, const Reading& reading, Comparison& c) {
  c.rows = reading.rows;
  double check = 0.0;  // becomes NaN if anything is not finite
  double coupling = 0.0;
  for (int k = 0; k < c.rows; ++k) {
    const auto n = static_cast<std::size_t>(k);
    const int at = reading.index[n];
    c.at[k] = at;
    c.HP[k] = Row::load(prior.covariance.row(at));
    const double gap = reading.value[n] - prior.mean[at];
    c.innovation[k] = at >= kRoll && at <= kYaw ? wrap_to_pi(gap) : gap;
    check += c.innovation[k] * 0.0;
    for (int l = 0; l < k; ++l) {
      const double r = reading.covariance[n * kStates + static_cast<std::size_t>(l)];
      c.R[k][l] = c.R[l][k] = r;
      coupling += std::abs(r);
    }
    c.R[k][k] = std::max(std::abs(reading.covariance[n * (kStates + 1)]), kSmallestVariance);
    check += c.R[k][k] * 0.0;
    c.largest_ratio = std::max(c.largest_ratio, c.HP[k][at] / c.R[k][k]);
  }
  c.independent = coupling == 0.0;
  c.finite = !std::isnan(check + coupling * 0.0);
}

// The posterior covariance, `K` holding K^T. With M the measured states and U the others:
//   columns M: K R. This is Joseph's (I-KH) P (I-KH)^T + K R K^T there, for I - K_M = R S^-1, and nothing cancels in it;
//   U by U:    Joseph's form, with T = (I-KH) P: T - (T H^T - K R) K^T.
void write_posterior(const Comparison& c, const Row* K, StateCovariance& P) {
  const int m = c.rows;
  alignas(16) double k_of[kStates][StateCovariance::kStride];   // K^T
  alignas(16) double kr_of[kStates][StateCovariance::kStride];  // (K R)^T
  for (int k = 0; k < m; ++k) {
    K[k].store(k_of[k]);
    Row kr = Row::zero();
    if (c.independent) {
      kr.add(c.R[k][k], K[k]);
    } else {
      for (int l = 0; l < m; ++l) kr.add(c.R[k][l], K[l]);
    }
    kr.store(kr_of[k]);
  }
  unsigned measured = 0;
  for (int k = 0; k < m; ++k) measured |= 1U << c.at[k];
  int others[kStates];
  int n = 0;
  for (int i = 0; i < kStates; ++i) {
    others[n] = i;
    n += static_cast<int>(~measured >> i & 1U);
  }
  for (int u = 0; u < n; ++u) {
    const int i = others[u];
    double* const row = P.row(i);
    Row t = Row::load(row);
    for (int k = 0; k < m; ++k) t.subtract(k_of[k][i], c.HP[k]);
    double g[kStates];
    for (int k = 0; k < m; ++k) g[k] = t[c.at[k]] - kr_of[k][i];
    for (int k = 0; k < m; ++k) t.subtract(g[k], K[k]);
    t.store(row);
    for (int v = 0; v < u; ++v) P.row(others[v])[i] = row[others[v]];  // the lower triangle counts
  }
  for (int k = 0; k < m; ++k) {
    double* const row = P.row(c.at[k]);
    for (int u = 0; u < n; ++u) row[others[u]] = P.row(others[u])[c.at[k]] = kr_of[k][others[u]];
    for (int l = 0; l < k; ++l) row[c.at[l]] = P.row(c.at[l])[c.at[k]] = kr_of[k][c.at[l]];
    row[c.at[k]] = kr_of[k][c.at[k]];
  }
}

}  // namespace

bool is_positive_definite(const StateCovariance& covariance) {
  double S[kStates][kStates];
  for (int i = 0; i < kStates; ++i) {
    for (int j = 0; j <= i; ++j) S[i][j] = covariance(i, j);
  }
  return factor(S, kStates);
}

Result<Fused, UpdateFault> fuse(Belief& belief, const Reading& reading) {
  const int m = reading.rows;
  if (m <= 0) return err(UpdateFault::NoRows);
  Comparison c;
  compare(belief, reading, c);
  if (!c.finite) return err(UpdateFault::NotFinite);
  double S[kStates][kStates];
  for (int k = 0; k < m; ++k) {
    for (int l = 0; l <= k; ++l) S[k][l] = belief.covariance(c.at[k], c.at[l]) + c.R[k][l];
  }
  if (!factor(S, m)) return err(UpdateFault::SingularInnovation);

  // |L^-1 innovation|^2 is the squared Mahalanobis distance.
  double distance_squared = 0.0;
  double white[kStates];
  for (int k = 0; k < m; ++k) {
    double sum = c.innovation[k];
    for (int l = 0; l < k; ++l) sum -= S[k][l] * white[l];
    white[k] = sum * S[k][k];
    distance_squared += white[k] * white[k];
  }
  if (distance_squared >= reading.gate * reading.gate) return err(UpdateFault::OutsideGate);

  // K^T, row by row: S K^T = H P, by forward and backward substitution.
  Row K[kStates];
  for (int k = 0; k < m; ++k) {
    Row w = c.HP[k];
    for (int l = 0; l < k; ++l) w.subtract(S[k][l], K[l]);
    w.scale(S[k][k]);
    K[k] = w;
  }
  Row correction = Row::zero();
  for (int k = m - 1; k >= 0; --k) {
    Row w = K[k];
    for (int l = k + 1; l < m; ++l) w.subtract(S[l][k], K[l]);
    w.scale(S[k][k]);
    K[k] = w;
    correction.add(c.innovation[k], w);
  }

  for (int i = 0; i < kStates; ++i) belief.mean[i] += correction[i];
  for (int i = kRoll; i <= kYaw; ++i) belief.mean[i] = wrap_to_pi(belief.mean[i]);
  write_posterior(c, K, belief.covariance);
  const bool repaired = c.largest_ratio > kDelicateRatio && restore_definiteness(belief.covariance);
  return Fused{distance_squared, repaired};
}

}  // namespace nacelle::ekf
