#include "geometry/sphere_fit.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <vector>

#include "geometry/hierarchical_mesh.h"
#include "geometry/icosphere.h"
#include "geometry/shell_surface.h"

namespace darboux {
namespace {

constexpr double kRadius = 3.0;

LoopMesh ThroughPoints(int frequency) {
  LoopMesh mesh = MakeLoopMesh(MakeSmoothIcosphere(kRadius, frequency));
  EXPECT_TRUE(InterpolatePoints(&mesh));
  return mesh;
}

LoopMesh Fitted(LoopMesh mesh) {
  EXPECT_TRUE(FitToSphere(kRadius, &mesh));
  return mesh;
}

// Root mean squares over the surface, relative to the radius, and to its inverse.
struct Deviation {
  double radius = 0.0, curvature = 0.0;
};

// Of what lies beyond `above`.
Deviation Deviate(const LoopMesh& mesh, double above = -2.0 * kRadius) {
  const ShellSurface surface(mesh);
  Deviation sum;
  double area = 0.0;
  for (int e = 0; e < surface.num_elements(); ++e) {
    for (const StrainPoint& p : surface.QuadraturePoints(e, 6)) {
      if (p.position.z() < above) continue;
      const double mean = 0.5 * (p.b11 + p.b22);
      sum.radius += p.area * std::pow(p.position.norm() / kRadius - 1.0, 2);
      sum.curvature += p.area * std::pow(std::abs(mean) * kRadius - 1.0, 2);
      area += p.area;
    }
  }
  return {std::sqrt(sum.radius / area), std::sqrt(sum.curvature / area)};
}

TEST(SphereFitTest, IsNearerThanTheSurfaceThroughPointsOnTheSphereAndAboutAsCurved) {
  double before = 0.0;
  for (const int frequency : {3, 6, 12}) {
    const Deviation through = Deviate(ThroughPoints(frequency));
    const Deviation fitted = Deviate(Fitted(ThroughPoints(frequency)));
    EXPECT_LT(fitted.radius, 0.8 * through.radius) << frequency;
    EXPECT_LT(fitted.curvature, 1.1 * through.curvature) << frequency;
    if (before > 0.0) {
      EXPECT_LT(fitted.radius, before / 8.0);
    }
    before = fitted.radius;
  }
}

TEST(SphereFitTest, LocalRefinementMakesItRounderThere) {
  const LoopMesh base = ThroughPoints(3);
  const HierarchicalMesh coarse(base, MeshRefinement());
  MeshRefinement refinement = coarse.RefineNear({{{0.0, 0.0, kRadius}, 2.0}}, 0, nullptr);
  const HierarchicalMesh middle(base, refinement);
  refinement = middle.RefineNear({{{0.0, 0.0, kRadius}, 2.0}}, 1, nullptr);
  const HierarchicalMesh fine(base, refinement);
  const Deviation exact = Deviate(fine.mesh(), 0.9 * kRadius);
  const Deviation fitted = Deviate(Fitted(fine.mesh()), 0.9 * kRadius);
  EXPECT_LT(fitted.radius, 0.02 * exact.radius);
  EXPECT_LT(fitted.curvature, 0.2 * exact.curvature);
}

TEST(SphereFitTest, TheFittedSurfaceHasNoCracks) {
  const LoopMesh base = ThroughPoints(3);
  const HierarchicalMesh coarse(base, MeshRefinement());
  const HierarchicalMesh mesh(base, coarse.RefineNear({{{0.0, 0.0, kRadius}, 0.5}}, 0, nullptr));
  const ShellSurface surface(Fitted(mesh.mesh()));
  // Points on edges between elements, from both sides: the same places of level 0.
  constexpr double kCorner[4][2] = {{0.0, 0.0}, {1.0, 0.0}, {0.0, 1.0}, {0.0, 0.0}};
  int edges = 0;
  for (int e = 0; e < surface.num_elements(); ++e) {
    for (int k = 0; k < 3; ++k) {
      if (surface.HangingCorner(e, k) < 0) continue;
      ++edges;
      const ElementPoint here{e,
                              0.7 * kCorner[k][0] + 0.3 * kCorner[k + 1][0],
                              0.7 * kCorner[k][1] + 0.3 * kCorner[k + 1][1]};
      const Eigen::Vector3d x = surface.Position(here);
      double nearest = kRadius;
      for (int other = 0; other < surface.num_elements(); ++other) {
        for (int l = 0; l < 3; ++l) {
          if (other == e) continue;
          for (const double part : {0.4, 0.6}) {
            const ElementPoint there{other,
                                     (1.0 - part) * kCorner[l][0] + part * kCorner[l + 1][0],
                                     (1.0 - part) * kCorner[l][1] + part * kCorner[l + 1][1]};
            nearest = std::min(nearest, (surface.Position(there) - x).norm());
          }
        }
      }
      EXPECT_LT(nearest, 1e-12 * kRadius);
    }
  }
  EXPECT_GT(edges, 0);
}

TEST(SphereFitTest, RefinedEverywhereItIsTheFitOfAllUnknowns) {
  const LoopMesh base = ThroughPoints(3);
  const HierarchicalMesh coarse(base, MeshRefinement());
  std::vector<int> all(base.mesh.num_elements);
  for (size_t i = 0; i < all.size(); ++i) all[i] = static_cast<int>(i);
  const HierarchicalMesh fine(base, coarse.RefineElements(all));
  EXPECT_LT(Deviate(Fitted(fine.mesh())).radius, 0.2 * Deviate(Fitted(base)).radius);
}

}  // namespace
}  // namespace darboux
