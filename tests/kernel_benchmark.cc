// Time per call of the pieces a run is made of: surface evaluation, basis, strain points, costs.
// Each line: the fastest of `repeats` passes over many points. Asserts nothing.
//
// Sample run: tests/kernel_benchmark
#include <ceres/jet.h>
#include <gflags/gflags.h>

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <functional>
#include <limits>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "costs/bending_energy.h"
#include "costs/membrane_energy.h"
#include "costs/strain_derivatives.h"
#include "geometry/parametric_surface.h"
#include "geometry/shell_surface.h"
#include "geometry/surface_invariants.h"

DEFINE_int32(repeats, 7, "Passes; the fastest counts.");

namespace darboux {
namespace {

volatile double sink = 0.0;  // keeps results alive

void Measure(const char* name, int calls, const std::function<double(int)>& call) {
  double best = std::numeric_limits<double>::infinity();
  for (int pass = 0; pass < FLAGS_repeats; ++pass) {
    const auto start = std::chrono::steady_clock::now();
    double sum = 0.0;
    for (int i = 0; i < calls; ++i) sum += call(i);
    sink = sum;
    best = std::min(
        best, std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
  }
  std::printf("%-58s %10.3f us\n", name, 1e6 * best / calls);
}

void Run() {
  std::mt19937 generator(7);
  std::uniform_real_distribution<double> uniform(0.1, 0.9);
  std::vector<std::pair<double, double>> uv(10000);
  for (auto& p : uv) p = {uniform(generator), uniform(generator)};
  const int n = static_cast<int>(uv.size());

  const auto torus = MakeTorus(3.0, 1.0);
  std::string error;
  const auto typed =
      MakeExpressionSurface({"(3 + cos(v))*cos(u)", "(3 + cos(v))*sin(u)", "sin(v)"}, &error);
  Measure("torus, position and derivatives to third order", n, [&](int i) {
    return torus->Evaluate(uv[i].first, uv[i].second).x_vvv.x();
  });
  Measure("the same typed as an expression", n, [&](int i) {
    return typed->Evaluate(uv[i].first, uv[i].second).x_vvv.x();
  });
  Measure("surface invariants", n, [&](int i) {
    return EvaluateSurfaceInvariants(torus->Evaluate(uv[i].first, uv[i].second))->kappa[0];
  });

  ParameterDomain::Options options;
  options.divisions = {16, 16};
  const ParameterDomain domain(options);
  const LoopBasis fast(domain.mesh());
  LoopBasis::Options by_opensubdiv;
  by_opensubdiv.regular_fast_path = false;
  const LoopBasis bfr(domain.mesh(), by_opensubdiv);
  Measure("regular Loop basis, closed form", n, [&](int i) {
    return fast.Evaluate(i % 512, 0.5 * uv[i].first, 0.5 * uv[i].second)(5, 3);
  });
  Measure("regular Loop basis, OpenSubdiv Bfr stencils", n, [&](int i) {
    return bfr.Evaluate(i % 512, 0.5 * uv[i].first, 0.5 * uv[i].second)(5, 3);
  });

  const ShellSurface surface(std::shared_ptr<const ParametricSurface>(MakeTorus(3.0, 1.0)),
                             options);
  Measure("strain points of an element, 3-point rule, per point", 512, [&](int i) {
    return surface.QuadraturePoints(i, 3)[0].area / 3.0;
  });

  Material material;
  material.thickness = 0.01;
  material.young_modulus = 1e7;
  material.poisson_ratio = 0.3;
  const auto points =
      std::make_shared<const std::vector<StrainPoint>>(surface.QuadraturePoints(7, 3));
  std::vector<double> state(36), residuals(64), rows(36 * 64);
  for (double& x : state) x = 0.01 * uniform(generator);
  std::vector<const double*> blocks;
  std::vector<double*> jacobians;
  for (int i = 0; i < 12; ++i) {
    blocks.push_back(&state[3 * i]);
    jacobians.push_back(&rows[3 * 64 * i]);
  }
  const auto cost = [&](const char* name, const ceres::CostFunction& function) {
    Measure(name, 3000, [&](int) {
      function.Evaluate(blocks.data(), residuals.data(), jacobians.data());
      return rows[5];
    });
  };
  cost("membrane, linear, residuals and Jacobian, element of 3 points",
       MembraneEnergy(points, StrainMeasure::kLinearKoiter, material));
  cost("membrane, koiter", MembraneEnergy(points, StrainMeasure::kKoiter, material));
  cost("membrane, koiter, with tension rows",
       MembraneEnergy(points, StrainMeasure::kKoiter, material, true));
  cost("bending, linear", BendingEnergy(points, StrainMeasure::kLinearKoiter, material));
  cost("bending, koiter", BendingEnergy(points, StrainMeasure::kKoiter, material));

  // The same strains of one point: autodiff over the 15 kinematic numbers against formulas.
  const StrainPoint& point = points->front();
  std::array<double, 15> k;
  for (double& x : k) x = 0.01 * uniform(generator);
  Measure("strains and gradient of a point, Jet over 15 inputs", 10000, [&](int) {
    std::array<ceres::Jet<double, 15>, 15> jets;
    for (int i = 0; i < 15; ++i) jets[i] = ceres::Jet<double, 15>(k[i], i);
    std::array<ceres::Jet<double, 15>, 6> e;
    EvaluateMembraneStrain(StrainMeasure::kKoiter, point, jets.data(), e.data());
    EvaluateBendingStrain(StrainMeasure::kKoiter, point, jets.data(), e.data() + 3);
    return e[5].v[3];
  });
  StrainDerivatives derivatives;
  Measure("the same by hand", 10000, [&](int) {
    EvaluateStrainDerivatives(StrainMeasure::kKoiter, point, k.data(), &derivatives);
    return derivatives.gradient(5, 3);
  });
  const Eigen::Matrix<double, 6, 1> stress = Eigen::Matrix<double, 6, 1>::Ones();
  Eigen::Matrix<double, 15, 15> stiffness = Eigen::Matrix<double, 15, 15>::Zero();
  Measure("stress stiffness of a point, by hand", 10000, [&](int) {
    AddStressStiffness(StrainMeasure::kKoiter, point, k.data(), stress, &stiffness);
    return stiffness(3, 4);
  });
}

}  // namespace
}  // namespace darboux

int main(int argc, char** argv) {
  gflags::ParseCommandLineFlags(&argc, &argv, true);
  darboux::Run();
  return 0;
}
