#include "geometry/surface_invariants.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

namespace darboux {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kSingularSine = 1e-12;

// Derivatives of sigma by parameter index.
struct Derivatives {
  std::array<Vector3d, 2> d;
  std::array<std::array<Vector3d, 2>, 2> dd;
  std::array<std::array<std::array<Vector3d, 2>, 2>, 2> ddd;
};

Derivatives ByIndex(const SurfaceJet& jet) {
  Derivatives s;
  s.d = {jet.x_u, jet.x_v};
  s.dd = {{{jet.x_uu, jet.x_uv}, {jet.x_uv, jet.x_vv}}};
  const Vector3d third[4] = {jet.x_uuu, jet.x_uuv, jet.x_uvv, jet.x_vvv};
  for (int a = 0; a < 2; ++a) {
    for (int b = 0; b < 2; ++b) {
      for (int c = 0; c < 2; ++c) s.ddd[a][b][c] = third[a + b + c];
    }
  }
  return s;
}

// Forms, Christoffel symbols, normal, and their derivatives.
void EvaluateForms(const Derivatives& s, SurfaceInvariants* out) {
  const Vector3d cross = s.d[0].cross(s.d[1]);
  out->area_element = cross.norm();
  out->n = cross / out->area_element;
  for (int a = 0; a < 2; ++a) {
    for (int b = 0; b < 2; ++b) {
      out->first_form(a, b) = s.d[a].dot(s.d[b]);
      out->second_form(a, b) = s.dd[a][b].dot(out->n);
    }
  }
  const Matrix2d& first = out->first_form;
  Matrix2d inverse;  // From the cross product: EG - F^2 cancels where the parameters are skewed.
  inverse << first(1, 1), -first(0, 1), -first(0, 1), first(0, 0);
  inverse /= out->area_element * out->area_element;
  // The tangent vector with these inner products with sigma_u, sigma_v.
  const auto tangent = [&](const Vector2d& products) -> Vector3d {
    const Vector2d contravariant = inverse * products;
    return contravariant[0] * s.d[0] + contravariant[1] * s.d[1];
  };

  for (int a = 0; a < 2; ++a) out->n_d[a] = tangent(-out->second_form.col(a));  // Weingarten
  for (int c = 0; c < 2; ++c) {
    for (int a = 0; a < 2; ++a) {
      for (int b = 0; b < 2; ++b) {
        out->first_form_d[c](a, b) = s.dd[a][c].dot(s.d[b]) + s.d[a].dot(s.dd[b][c]);
        out->second_form_d[c](a, b) = s.ddd[a][b][c].dot(out->n) + s.dd[a][b].dot(out->n_d[c]);
      }
    }
  }
  for (int a = 0; a < 2; ++a) {
    for (int b = 0; b < 2; ++b) {
      const Vector2d gamma = inverse * Vector2d(s.dd[a][b].dot(s.d[0]), s.dd[a][b].dot(s.d[1]));
      out->christoffel[0](a, b) = gamma[0];
      out->christoffel[1](a, b) = gamma[1];
    }
  }
  // From n_a . sigma_c = -II_ac and n_a . n = 0.
  const auto second_normal = [&](int a, int b) -> Vector3d {
    Vector2d products;
    for (int c = 0; c < 2; ++c) {
      products[c] = -out->second_form_d[b](a, c) - out->n_d[a].dot(s.dd[b][c]);
    }
    return tangent(products) - out->n_d[a].dot(out->n_d[b]) * out->n;
  };
  out->n_uu = second_normal(0, 0);
  out->n_uv = second_normal(0, 1);
  out->n_vv = second_normal(1, 1);
}

// |nabla II| in the orthonormal frame whose rows are `frame`.
double SecondFormGradientNorm(const SurfaceInvariants& s, const Matrix2d& frame) {
  std::array<Matrix2d, 2> nabla;
  for (int c = 0; c < 2; ++c) {
    Matrix2d connection;  // (d, a) = Gamma^d_ca
    for (int d = 0; d < 2; ++d) connection.row(d) = s.christoffel[d].row(c);
    const Matrix2d half = connection.transpose() * s.second_form;
    nabla[c] = s.second_form_d[c] - half - half.transpose();
    nabla[c] = (frame * nabla[c] * frame.transpose()).eval();
  }
  const Matrix2d along_t1 = s.Along(0, nabla[0], nabla[1]);
  const Matrix2d along_t2 = s.Along(1, nabla[0], nabla[1]);
  return std::sqrt(along_t1.squaredNorm() + along_t2.squaredNorm());
}

// Size of kappa_1 - kappa_2 that rounding alone explains.
double CurvatureRounding(const Derivatives& s) {
  const double u = s.d[0].norm(), v = s.d[1].norm();
  const double sum = (s.dd[0][0].norm() + u) / (u * u) + s.dd[0][1].norm() / (u * v) +
                     (s.dd[1][1].norm() + v) / (v * v);
  return 64.0 * std::numeric_limits<double>::epsilon() * sum;
}

// Appendix B writes (xi, eta) as a quotient taken from one of the two rows of
// (II - kappa I)(xi, eta)^T = 0, with a case for every coefficient that may vanish: L - kappa E,
// M - kappa F, N - kappa G, or all but one in principal parameters. In an orthonormal frame the
// rows are (dev - r, b_12) and (b_12, -dev - r); the one whose diagonal entry does not cancel is
// never zero unless r is, so two cases are enough.
Vector2d PrincipalDirection(double deviation, double b12, double radius) {
  const Vector2d direction =
      deviation >= 0.0 ? Vector2d(radius + deviation, b12) : Vector2d(b12, radius - deviation);
  return direction / std::hypot(direction[0], direction[1]);
}

// Parametric derivatives of the frame, of b and of kappa; needs frame, b, kappa and umbilic.
//
// Appendix B differentiates its quotients; here the generalised eigenproblem
// (II - kappa I) t = 0, t^T I t = 1 is, which is the same in every case and divides by
// kappa_1 - kappa_2 once:
//   kappa_i,a = t_i^T (II_a - kappa_i I_a) t_i
//   t_1,a     = -(t_1^T I_a t_1) / 2 t_1 + c t_2, c = t_2^T (II_a - kappa_1 I_a) t_1 / (k_1 - k_2)
void DifferentiateFrame(SurfaceInvariants* out) {
  for (int a = 0; a < 2; ++a) {
    const Matrix2d& frame = out->frame;
    const Matrix2d metric = frame * out->first_form_d[a] * frame.transpose();
    const Matrix2d second = frame * out->second_form_d[a] * frame.transpose();
    double turn = 0.0;  // t1 = sigma_u / |sigma_u| keeps eta_1 = 0.
    if (!out->umbilic) {
      turn = (second(0, 1) - out->kappa[0] * metric(0, 1)) / (out->kappa[0] - out->kappa[1]);
    }
    Matrix2d rates;  // t_i,a = sum of rates(i, j) t_j; t_1 . t_2 stays 0.
    rates << -0.5 * metric(0, 0), turn, -turn - metric(0, 1), -0.5 * metric(1, 1);
    out->frame_d[a] = rates * frame;
    if (out->umbilic) {
      const Matrix2d turned = rates * out->b;
      out->b_d[a] = second + turned + turned.transpose();
      out->kappa_d[a].setConstant(0.5 * out->b_d[a].trace());
    } else {
      out->kappa_d[a] = second.diagonal() - out->kappa.cwiseProduct(metric.diagonal());
      out->b_d[a] = out->kappa_d[a].asDiagonal();
    }
  }
}

}  // namespace

std::optional<SurfaceInvariants> EvaluateSurfaceInvariants(
    const SurfaceJet& jet, const SurfaceInvariantsOptions& options) {
  const double u_length = jet.x_u.norm(), v_length = jet.x_v.norm();
  const double area = jet.x_u.cross(jet.x_v).norm();
  // Written so that a NaN ends here, too.
  if (!(area > kSingularSine * u_length * v_length) || !std::isfinite(u_length * v_length)) {
    return std::nullopt;
  }
  const Derivatives s = ByIndex(jet);
  SurfaceInvariants out;
  EvaluateForms(s, &out);

  // The frame along sigma_u, and the shape operator in it.
  const double f = out.first_form(0, 1);
  out.frame << 1.0 / u_length, 0.0, -f / (u_length * area), u_length / area;
  out.b = out.frame * out.second_form * out.frame.transpose();
  const double mean = 0.5 * (out.b(0, 0) + out.b(1, 1));
  const double deviation = 0.5 * (out.b(0, 0) - out.b(1, 1));
  const double radius = std::hypot(deviation, out.b(0, 1));
  out.mean_curvature = mean;
  out.gaussian_curvature = out.b(0, 0) * out.b(1, 1) - out.b(0, 1) * out.b(0, 1);
  out.kappa << mean + radius, mean - radius;

  const double gap = 2.0 * radius;
  const double scale = std::sqrt(out.kappa.squaredNorm() + SecondFormGradientNorm(out, out.frame));
  out.umbilic = gap <= std::max(options.umbilic_tolerance * scale, CurvatureRounding(s));
  if (!out.umbilic) {
    const Vector2d direction = PrincipalDirection(deviation, out.b(0, 1), radius);
    Matrix2d rotation;
    rotation << direction[0], direction[1], -direction[1], direction[0];
    out.frame = (rotation * out.frame).eval();
    const double xi = out.frame(0, 0) * u_length, eta = out.frame(0, 1) * v_length;
    if ((std::abs(xi) >= std::abs(eta) ? xi : eta) < 0.0) out.frame = -out.frame;
    out.b = out.kappa.asDiagonal();
  }
  out.t1 = out.Along(0, jet.x_u, jet.x_v);
  out.t2 = out.Along(1, jet.x_u, jet.x_v);

  DifferentiateFrame(&out);
  for (int a = 0; a < 2; ++a) {
    const Matrix2d& rate = out.frame_d[a];
    out.t1_d[a] = rate(0, 0) * s.d[0] + rate(0, 1) * s.d[1] + out.Along(0, s.dd[0][a], s.dd[1][a]);
    out.t2_d[a] = rate(1, 0) * s.d[0] + rate(1, 1) * s.d[1] + out.Along(1, s.dd[0][a], s.dd[1][a]);
  }
  for (int i = 0; i < 2; ++i) {
    out.kappa_along_frame.row(i) = out.Along(i, out.kappa_d[0], out.kappa_d[1]);
    for (int j = 0; j < 2; ++j) {
      // nabla_{t_i} t_j: t_i[(xi_j, eta_j)] + Gamma(t_i, t_j), then its inner products.
      const Matrix2d rate = out.Along(i, out.frame_d[0], out.frame_d[1]);
      Vector2d nabla = rate.row(j);
      for (int c = 0; c < 2; ++c) {
        nabla[c] += out.frame.row(i).dot(out.christoffel[c] * out.frame.row(j).transpose());
      }
      out.covariant[i][j] = out.frame * (out.first_form * nabla);
    }
  }
  return out;
}

}  // namespace darboux
