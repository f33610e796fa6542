#include "geometry/invariant_strains.h"

#include <utility>

namespace darboux {
namespace {

using Eigen::Vector3d;

// t_i[value], i = 1, 2, of a scalar beside the value itself.
struct Scalar {
  double value;
  double along[2];
};

Scalar operator+(const Scalar& x, const Scalar& y) {
  return {x.value + y.value, {x.along[0] + y.along[0], x.along[1] + y.along[1]}};
}

Scalar operator-(const Scalar& x, const Scalar& y) {
  return {x.value - y.value, {x.along[0] - y.along[0], x.along[1] - y.along[1]}};
}

Scalar operator*(const Scalar& x, const Scalar& y) {
  return {
      x.value * y.value,
      {x.along[0] * y.value + x.value * y.along[0], x.along[1] * y.value + x.value * y.along[1]}};
}

// A vector field and its derivatives along t1, t2.
struct Field {
  Vector3d value;
  Vector3d along[2];
};

Scalar Dot(const Field& x, const Field& y) {
  return {x.value.dot(y.value),
          {x.along[0].dot(y.value) + x.value.dot(y.along[0]),
           x.along[1].dot(y.value) + x.value.dot(y.along[1])}};
}

}  // namespace

DisplacementComponents EvaluateComponents(const SurfaceInvariants& surface,
                                          const DisplacementJet& displacement) {
  const SurfaceInvariants& s = surface;
  const DisplacementJet& x = displacement;
  DisplacementComponents c;
  c.alpha = x.d.dot(s.t1);
  c.alpha_u = x.d_u.dot(s.t1) + x.d.dot(s.t1_d[0]);
  c.alpha_v = x.d_v.dot(s.t1) + x.d.dot(s.t1_d[1]);
  c.beta = x.d.dot(s.t2);
  c.beta_u = x.d_u.dot(s.t2) + x.d.dot(s.t2_d[0]);
  c.beta_v = x.d_v.dot(s.t2) + x.d.dot(s.t2_d[1]);
  c.gamma = x.d.dot(s.n);
  c.gamma_u = x.d_u.dot(s.n) + x.d.dot(s.n_d[0]);
  c.gamma_v = x.d_v.dot(s.n) + x.d.dot(s.n_d[1]);
  c.gamma_uu = x.d_uu.dot(s.n) + 2.0 * x.d_u.dot(s.n_d[0]) + x.d.dot(s.n_uu);
  c.gamma_uv = x.d_uv.dot(s.n) + x.d_u.dot(s.n_d[1]) + x.d_v.dot(s.n_d[0]) + x.d.dot(s.n_uv);
  c.gamma_vv = x.d_vv.dot(s.n) + 2.0 * x.d_v.dot(s.n_d[1]) + x.d.dot(s.n_vv);
  return c;
}

LinearInvariantStrains EvaluateLinearInvariantStrains(const SurfaceInvariants& surface,
                                                      const DisplacementComponents& displacement) {
  const SurfaceInvariants& s = surface;
  const DisplacementComponents& c = displacement;
  const auto& nabla = s.covariant;  // nabla[i][j](k) = (nabla_{t_i} t_j) . t_k
  const double b11 = s.b(0, 0), b12 = s.b(0, 1), b22 = s.b(1, 1);
  LinearInvariantStrains e;
  e.eps_1 = s.Along(0, c.alpha_u, c.alpha_v) + nabla[0][1](0) * c.beta - b11 * c.gamma;
  e.eps_2 = s.Along(1, c.beta_u, c.beta_v) + nabla[1][0](1) * c.alpha - b22 * c.gamma;
  e.omega_1 = s.Along(1, c.alpha_u, c.alpha_v) + nabla[1][1](0) * c.beta - b12 * c.gamma;
  e.omega_2 = s.Along(0, c.beta_u, c.beta_v) + nabla[0][0](1) * c.alpha - b12 * c.gamma;

  // phi_i and its parametric derivatives.
  const double gamma_d[2] = {c.gamma_u, c.gamma_v};
  const double gamma_dd[2][2] = {{c.gamma_uu, c.gamma_uv}, {c.gamma_uv, c.gamma_vv}};
  const double alpha_d[2] = {c.alpha_u, c.alpha_v}, beta_d[2] = {c.beta_u, c.beta_v};
  double phi[2], phi_d[2][2];
  for (int i = 0; i < 2; ++i) {
    phi[i] = -s.Along(i, gamma_d[0], gamma_d[1]) - s.b(i, 0) * c.alpha - s.b(i, 1) * c.beta;
    for (int a = 0; a < 2; ++a) {
      phi_d[i][a] = -s.Along(i, gamma_dd[a][0], gamma_dd[a][1]) - s.frame_d[a](i, 0) * gamma_d[0] -
                    s.frame_d[a](i, 1) * gamma_d[1] - s.b_d[a](i, 0) * c.alpha -
                    s.b(i, 0) * alpha_d[a] - s.b_d[a](i, 1) * c.beta - s.b(i, 1) * beta_d[a];
    }
  }
  e.phi_1 = phi[0];
  e.phi_2 = phi[1];
  e.zeta_1 = s.Along(0, phi_d[0][0], phi_d[0][1]) + nabla[0][1](0) * phi[1];
  e.zeta_2 = s.Along(1, phi_d[1][0], phi_d[1][1]) + nabla[1][0](1) * phi[0];
  e.tau = s.Along(0, phi_d[1][0], phi_d[1][1]) + s.Along(1, phi_d[0][0], phi_d[0][1]) +
          nabla[0][0](1) * phi[0] + nabla[1][1](0) * phi[1];
  return e;
}

NonlinearInvariantStrains EvaluateNonlinearInvariantStrains(const SurfaceInvariants& surface,
                                                            const DisplacementJet& displacement,
                                                            OmegaConvention convention) {
  const SurfaceInvariants& s = surface;
  const DisplacementJet& x = displacement;

  // The frame and t1[delta], t2[delta] as vector fields.
  Field t1{s.t1, {}}, t2{s.t2, {}}, n{s.n, {}};
  Field d[2];
  for (int j = 0; j < 2; ++j) {
    t1.along[j] = s.Along(j, s.t1_d[0], s.t1_d[1]);
    t2.along[j] = s.Along(j, s.t2_d[0], s.t2_d[1]);
    n.along[j] = s.Along(j, s.n_d[0], s.n_d[1]);
  }
  for (int i = 0; i < 2; ++i) {
    d[i].value = s.Along(i, x.d_u, x.d_v);
    Vector3d d_a[2];  // Parametric derivatives of t_i[delta].
    for (int a = 0; a < 2; ++a) {
      const Vector3d& d_au = a == 0 ? x.d_uu : x.d_uv;
      const Vector3d& d_av = a == 0 ? x.d_uv : x.d_vv;
      d_a[a] = s.frame_d[a](i, 0) * x.d_u + s.frame_d[a](i, 1) * x.d_v + s.Along(i, d_au, d_av);
    }
    for (int j = 0; j < 2; ++j) d[i].along[j] = s.Along(j, d_a[0], d_a[1]);
  }
  const Scalar zero{0.0, {0.0, 0.0}}, one{1.0, {0.0, 0.0}};
  const Scalar eps_1 = Dot(d[0], t1), eps_2 = Dot(d[1], t2);
  Scalar omega_1 = Dot(d[0], t2), omega_2 = Dot(d[1], t1);
  if (convention == OmegaConvention::kAsPrinted) std::swap(omega_1, omega_2);
  const Scalar phi_1 = zero - Dot(d[0], n), phi_2 = zero - Dot(d[1], n);

  NonlinearInvariantStrains e;
  const auto squares = [](const Scalar& p, const Scalar& q, const Scalar& r) {
    return p.value * p.value + q.value * q.value + r.value * r.value;
  };
  e.eps_11 = eps_1.value + 0.5 * squares(eps_1, omega_1, phi_1);
  e.eps_22 = eps_2.value + 0.5 * squares(eps_2, omega_2, phi_2);
  e.eps_12 = omega_1.value + omega_2.value + eps_1.value * omega_2.value +
             eps_2.value * omega_1.value + phi_1.value * phi_2.value;

  const Scalar theta_1 = phi_1 * (one + eps_2) - phi_2 * omega_1;
  const Scalar theta_2 = phi_2 * (one + eps_1) - phi_1 * omega_2;
  const Scalar chi = eps_1 + eps_2 + eps_1 * eps_2 - omega_1 * omega_2;

  // Components of t_i[theta_1 t1 + theta_2 t2 + chi n], by nabla and kappa as in (28)-(33), and
  // of the deformed tangents t_i + t_i[delta].
  Vector3d turn[2];
  for (int i = 0; i < 2; ++i) {
    turn[i] << theta_1.along[i] + s.covariant[i][1](0) * theta_2.value - s.b(i, 0) * chi.value,
        theta_2.along[i] + s.covariant[i][0](1) * theta_1.value - s.b(i, 1) * chi.value,
        chi.along[i] + s.b(i, 0) * theta_1.value + s.b(i, 1) * theta_2.value;
  }
  const Vector3d x_1(1.0 + eps_1.value, omega_1.value, -phi_1.value);
  const Vector3d x_2(omega_2.value, 1.0 + eps_2.value, -phi_2.value);
  e.zeta_11 = x_1.dot(turn[0]);
  e.zeta_22 = x_2.dot(turn[1]);
  e.zeta_12 = x_1.dot(turn[1]) + x_2.dot(turn[0]);
  return e;
}

}  // namespace darboux
