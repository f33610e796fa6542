#include "geometry/parametric_surface.h"

#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "geometry/expression.h"

namespace darboux {

namespace {

// A surface with a formula sigma(u, v), written once in terms of any scalar type and
// differentiated by Taylor arithmetic.
template <typename Formula>
class FormulaSurface : public ParametricSurface {
 public:
  explicit FormulaSurface(Formula formula) : formula_(std::move(formula)) {}

  SurfaceJet Evaluate(double u, double v) const override {
    const std::array<Taylor3, 3> sigma = formula_(Taylor3::U(u), Taylor3::V(v));
    return MakeSurfaceJet(sigma[0], sigma[1], sigma[2]);
  }

 private:
  Formula formula_;
};

template <typename Formula>
std::unique_ptr<ParametricSurface> MakeFormulaSurface(Formula formula) {
  return std::make_unique<FormulaSurface<Formula>>(std::move(formula));
}

class ExpressionSurface : public ParametricSurface {
 public:
  explicit ExpressionSurface(std::vector<Expression> xyz) : xyz_(std::move(xyz)) {}

  SurfaceJet Evaluate(double u, double v) const override {
    const std::array<Taylor3, 2> uv = {Taylor3::U(u), Taylor3::V(v)};
    return MakeSurfaceJet(
        xyz_[0].Evaluate(uv.data()), xyz_[1].Evaluate(uv.data()), xyz_[2].Evaluate(uv.data()));
  }

 private:
  std::vector<Expression> xyz_;  // Three.
};

}  // namespace

SurfaceJet MakeSurfaceJet(const Taylor3& x, const Taylor3& y, const Taylor3& z) {
  const auto coefficient = [&](int k) { return Eigen::Vector3d(x.c[k], y.c[k], z.c[k]); };
  SurfaceJet jet;
  jet.x = coefficient(0);
  jet.x_u = coefficient(1);
  jet.x_v = coefficient(2);
  jet.x_uu = 2.0 * coefficient(3);
  jet.x_uv = coefficient(4);
  jet.x_vv = 2.0 * coefficient(5);
  jet.x_uuu = 6.0 * coefficient(6);
  jet.x_uuv = 2.0 * coefficient(7);
  jet.x_uvv = 2.0 * coefficient(8);
  jet.x_vvv = 6.0 * coefficient(9);
  return jet;
}

SurfaceJet Reparametrise(const SurfaceJet& jet,
                         const std::array<double, 4>& u,
                         const std::array<double, 4>& v) {
  const double u1 = u[1], u2 = u[2], u3 = u[3];
  const double v1 = v[1], v2 = v[2], v3 = v[3];
  SurfaceJet q;
  q.x = jet.x;
  q.x_u = jet.x_u * u1;
  q.x_v = jet.x_v * v1;
  q.x_uu = jet.x_uu * (u1 * u1) + jet.x_u * u2;
  q.x_uv = jet.x_uv * (u1 * v1);
  q.x_vv = jet.x_vv * (v1 * v1) + jet.x_v * v2;
  q.x_uuu = jet.x_uuu * (u1 * u1 * u1) + jet.x_uu * (3.0 * u1 * u2) + jet.x_u * u3;
  q.x_uuv = (jet.x_uuv * (u1 * u1) + jet.x_uv * u2) * v1;
  q.x_uvv = (jet.x_uvv * (v1 * v1) + jet.x_uv * v2) * u1;
  q.x_vvv = jet.x_vvv * (v1 * v1 * v1) + jet.x_vv * (3.0 * v1 * v2) + jet.x_v * v3;
  return q;
}

std::unique_ptr<ParametricSurface> MakePlane() {
  return MakeFormulaSurface([](const auto& u, const auto& v) {
    using T = std::decay_t<decltype(u)>;
    return std::array<T, 3>{u, v, T(0.0)};
  });
}

std::unique_ptr<ParametricSurface> MakeCylinder(double radius) {
  return MakeFormulaSurface([radius](const auto& u, const auto& v) {
    using T = std::decay_t<decltype(u)>;
    return std::array<T, 3>{u, radius * sin(v), radius * cos(v)};
  });
}

std::unique_ptr<ParametricSurface> MakeSphere(double radius) {
  return MakeEllipsoid(radius, radius, radius);
}

std::unique_ptr<ParametricSurface> MakeEllipsoid(double a, double b, double c) {
  return MakeFormulaSurface([a, b, c](const auto& u, const auto& v) {
    using T = std::decay_t<decltype(u)>;
    const T cos_v = cos(v);
    return std::array<T, 3>{a * (cos_v * cos(u)), b * (cos_v * sin(u)), c * sin(v)};
  });
}

std::unique_ptr<ParametricSurface> MakeTorus(double major_radius, double minor_radius) {
  return MakeFormulaSurface([major_radius, minor_radius](const auto& u, const auto& v) {
    using T = std::decay_t<decltype(u)>;
    const T rho = major_radius + minor_radius * cos(v);  // Distance from the axis.
    return std::array<T, 3>{rho * cos(u), rho * sin(u), minor_radius * sin(v)};
  });
}

std::unique_ptr<ParametricSurface> MakeMonkeySaddle(double scale) {
  return MakeFormulaSurface([scale](const auto& u, const auto& v) {
    using T = std::decay_t<decltype(u)>;
    return std::array<T, 3>{u, v, scale * (u * (u * u - 3.0 * (v * v)))};
  });
}

std::unique_ptr<ParametricSurface> MakeExpressionSurface(const std::array<std::string, 3>& xyz,
                                                         std::string* error) {
  constexpr std::array<const char*, 3> kNames = {"x", "y", "z"};
  std::vector<Expression> expressions;
  for (int i = 0; i < 3; ++i) {
    std::string problem;
    std::optional<Expression> expression = Expression::Parse(xyz[i], {"u", "v"}, &problem);
    if (!expression.has_value()) {
      if (error != nullptr) *error = std::string(kNames[i]) + ": " + problem;
      return nullptr;
    }
    expressions.push_back(*std::move(expression));
  }
  return std::make_unique<ExpressionSurface>(std::move(expressions));
}

}  // namespace darboux
