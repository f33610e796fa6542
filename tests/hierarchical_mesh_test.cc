#include "geometry/hierarchical_mesh.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <random>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "geometry/icosphere.h"
#include "geometry/shell_surface.h"
#include "tests/mesh_util.h"

namespace darboux {
namespace {

// Bumps without symmetry, valences 5 and 6.
LoopMesh Pebble() {
  TriangleMesh mesh = MakeIcosphere(1.0, 4);
  for (Eigen::Vector3d& x : mesh.vertices) {
    x *= 1.0 + 0.2 * std::sin(3.0 * x.x() + 1.0) * std::cos(2.0 * x.y() - x.z());
    x.z() *= 0.7;
  }
  return MakeLoopMesh(mesh);
}

// A wavy rectangle with a boundary of valences 2, 3 and 4.
LoopMesh Patch() {
  TriangleMesh mesh = Lattice(7, 6);
  for (Eigen::Vector3d& x : mesh.vertices) {
    x.z() = 0.8 * std::sin(0.7 * x.x() + 0.4 * x.y()) - 0.05 * x.y() * x.y();
  }
  return MakeLoopMesh(mesh);
}

// Valence 7 and 5 inside, near the boundary.
LoopMesh Irregular() {
  TriangleMesh mesh = Lattice(7, 6);
  // The edge between two triangles of cell (3, 3), turned.
  const int cell = 2 * (3 * 7 + 3);
  const auto [a, b, c] = mesh.triangles[cell];
  const int d = mesh.triangles[cell + 1][2];
  mesh.triangles[cell] = {{a, b, d}};
  mesh.triangles[cell + 1] = {{b, c, d}};
  for (Eigen::Vector3d& x : mesh.vertices) x.z() = 0.3 * std::sin(x.x() - 0.6 * x.y());
  return MakeLoopMesh(mesh);
}

struct Case {
  const char* name;
  LoopMesh (*make)();
  Eigen::Vector3d center;  // of what is refined
  double radius;
  int levels;
};

std::string CaseName(const ::testing::TestParamInfo<Case>& info) { return info.param.name; }

std::unique_ptr<HierarchicalMesh> Refined(const LoopMesh& base,
                                          const Eigen::Vector3d& center,
                                          double radius,
                                          int levels) {
  auto mesh = std::make_unique<HierarchicalMesh>(base, MeshRefinement());
  for (int l = 0; l < levels; ++l) {
    // Narrower from level to level: leaves of all levels.
    const double narrower = radius * std::pow(0.5, l);
    mesh = std::make_unique<HierarchicalMesh>(base,
                                              mesh->RefineNear({{center, narrower}}, l, nullptr));
  }
  return mesh;
}

ElementPoint RandomPoint(int num_elements, std::mt19937* gen) {
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  const int e = std::uniform_int_distribution<int>(0, num_elements - 1)(*gen);
  double s = uniform(*gen), t = uniform(*gen);
  if (s + t > 1.0) s = 1.0 - s, t = 1.0 - t;
  return {e, s, t};
}

Eigen::Matrix3Xd RandomField(const ShellSurface& surface, std::mt19937* gen) {
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  Eigen::Matrix3Xd u = Eigen::Matrix3Xd::Zero(3, surface.mesh().num_vertices);
  for (int i = 0; i < u.cols(); ++i) {
    if (!surface.IsActive(i)) continue;
    for (int c = 0; c < 3; ++c) u(c, i) = uniform(*gen);
  }
  return u;
}

// Columns WeightRow.
Eigen::Matrix<double, 3, 6> Field(const ShellSurface& surface,
                                  const Eigen::Matrix3Xd& u,
                                  const ElementPoint& at) {
  const StrainPoint point = surface.MakePoint(at);
  Eigen::Matrix<double, 3, 6> k = Eigen::Matrix<double, 3, 6>::Zero();
  const std::vector<int>& vertices = surface.control_vertices(at.element);
  for (size_t i = 0; i < vertices.size(); ++i) {
    k += u.col(vertices[i]) * point.weights.col(i).transpose();
  }
  return k;
}

class HierarchicalMeshTest : public ::testing::TestWithParam<Case> {
 protected:
  HierarchicalMeshTest()
      : base_(GetParam().make()),
        mesh_(Refined(base_, GetParam().center, GetParam().radius, GetParam().levels)),
        coarse_(base_),
        fine_(mesh_->mesh()) {}

  LoopMesh base_;
  std::unique_ptr<HierarchicalMesh> mesh_;
  ShellSurface coarse_, fine_;
  std::mt19937 gen_{40411};
};

TEST_P(HierarchicalMeshTest, HasLeavesOfAllLevelsThatCoverTheSurface) {
  EXPECT_EQ(mesh_->num_levels(), GetParam().levels + 1);
  std::set<int> levels;
  std::vector<double> covered(base_.mesh.num_elements, 0.0);
  for (int e = 0; e < fine_.num_elements(); ++e) {
    const HierarchicalMesh::Cell& cell = mesh_->cell(e);
    levels.insert(cell.level);
    covered[cell.triangle >> (2 * cell.level)] += std::pow(0.25, cell.level);
  }
  EXPECT_EQ(static_cast<int>(levels.size()), GetParam().levels + 1);
  for (const double part : covered) EXPECT_EQ(part, 1.0);
  EXPECT_NEAR(fine_.size(), coarse_.size(), 0.1 * coarse_.size());
}

TEST_P(HierarchicalMeshTest, TheSurfaceStaysExactlyTheSame) {
  const double size = coarse_.size();
  for (int k = 0; k < 2000; ++k) {
    const ElementPoint at = RandomPoint(fine_.num_elements(), &gen_);
    const ElementPoint base = mesh_->BasePoint(at);
    // OpenSubdiv evaluates to the vertex of another valence only down to some depth.
    if (std::min({std::max(base.s, base.t),
                  std::max(1.0 - base.s, base.t),
                  std::max(base.s, 1.0 - base.t)}) < 0.02) {
      continue;
    }
    const ElementPoint back = mesh_->Locate(base);
    ASSERT_EQ(back.element, at.element);
    EXPECT_NEAR(back.s, at.s, 1e-12);
    EXPECT_NEAR(back.t, at.t, 1e-12);
    EXPECT_LT((fine_.Position(at) - coarse_.Position(base)).norm(), 1e-13 * size);
    const StrainPoint p = fine_.MakePoint(at), q = coarse_.MakePoint(base);
    EXPECT_LT((p.n - q.n).norm(), 1e-12);
    EXPECT_LT((p.t1 - q.t1).norm(), 1e-12);
    // OpenSubdiv's second derivatives have 1e-11 close to a vertex of another valence.
    const double rounding = coarse_.basis().IsRegular(base.element) ? 1e-13 : 1e-10;
    EXPECT_LT(std::max({std::abs(p.b11 - q.b11), std::abs(p.b12 - q.b12), std::abs(p.b22 - q.b22)}),
              rounding * std::pow(4.0, mesh_->cell(at.element).level));
  }
}

TEST_P(HierarchicalMeshTest, IsAPartitionOfUnityThatKeepsCoefficients) {
  // A motion of the control points of the unknowns, affine, is the same motion of the surface.
  Eigen::Matrix3d a;
  a << 0.3, -1.2, 0.4, 0.9, 0.1, -0.7, -0.2, 0.5, 1.1;
  const Eigen::Vector3d shift(0.2, -0.5, 1.0);
  Eigen::Matrix3Xd u = (a * fine_.control_points()).colwise() + shift;
  for (int i = 0; i < u.cols(); ++i) {
    EXPECT_EQ(fine_.IsActive(i), mesh_->IsUnknown(i));
    if (!fine_.IsActive(i)) u.col(i).setConstant(std::nan(""));
  }
  for (int k = 0; k < 500; ++k) {
    const ElementPoint at = RandomPoint(fine_.num_elements(), &gen_);
    const Eigen::VectorXd weights = fine_.ValueWeights(at);
    EXPECT_NEAR(weights.sum(), 1.0, 1e-13);
    EXPECT_GT(weights.minCoeff(), -1e-13);
    const StrainPoint p = fine_.MakePoint(at);
    const Eigen::Matrix<double, 3, 6> field = Field(fine_, u, at);
    EXPECT_LT((field.col(kRowValue) - a * p.position - shift).norm(), 1e-12 * coarse_.size());
    EXPECT_LT((field.col(kRowD1) - a * p.t1).norm(), 1e-11);
    EXPECT_LT((field.col(kRowD2) - a * p.t2).norm(), 1e-11);
  }
}

TEST_P(HierarchicalMeshTest, IsAdmissible) {
  for (int e = 0; e < fine_.num_elements(); ++e) {
    const int level = mesh_->cell(e).level;
    for (const int vertex : fine_.control_vertices(e)) {
      EXPECT_LE(mesh_->level(vertex), level);
      EXPECT_GE(mesh_->level(vertex), level - 1);
    }
  }
}

TEST_P(HierarchicalMeshTest, ThePiecesJoinSmoothlyAlongAllEdges) {
  const Eigen::Matrix3Xd u = RandomField(fine_, &gen_);
  // Every point of an edge that another element has too.
  std::map<std::pair<int, int>, std::vector<std::pair<int, int>>> edges;
  constexpr double kCorner[3][2] = {{0.0, 0.0}, {1.0, 0.0}, {0.0, 1.0}};
  struct Half {
    ElementPoint begin, end;
  };
  std::map<std::pair<int, int>, std::vector<Half>> halves;
  int hanging = 0;
  for (int e = 0; e < fine_.num_elements(); ++e) {
    for (int k = 0; k < 3; ++k) {
      const int l = (k + 1) % 3;
      const ElementPoint begin{e, kCorner[k][0], kCorner[k][1]},
          end{e, kCorner[l][0], kCorner[l][1]};
      const ElementPoint middle{e, 0.5 * (begin.s + end.s), 0.5 * (begin.t + end.t)};
      const auto add = [&](int from, int to, const ElementPoint& p, const ElementPoint& q) {
        if (from < to) {
          halves[{from, to}].push_back({p, q});
        } else {
          halves[{to, from}].push_back({q, p});
        }
      };
      const int m = fine_.HangingCorner(e, k);
      if (m < 0) {
        add(fine_.Corner(e, k), fine_.Corner(e, l), begin, end);
      } else {
        ++hanging;
        add(fine_.Corner(e, k), m, begin, middle);
        add(m, fine_.Corner(e, l), middle, end);
      }
    }
  }
  EXPECT_GT(hanging, 0);
  size_t open = 0, boundary = 0;
  for (const auto& loop : mesh_->mesh().loops) boundary += loop.size();
  for (const auto& [ends, sides] : halves) {
    ASSERT_LE(sides.size(), 2u);
    if (sides.size() == 1) {
      ++open;
      continue;
    }
    for (const double f : {0.1, 0.37, 0.8}) {
      Eigen::Matrix<double, 3, 6> field[2];
      Eigen::Vector3d x[2];
      for (int side = 0; side < 2; ++side) {
        const Half& half = sides[side];
        const ElementPoint at{half.begin.element,
                              half.begin.s + f * (half.end.s - half.begin.s),
                              half.begin.t + f * (half.end.t - half.begin.t)};
        field[side] = Field(fine_, u, at);
        x[side] = fine_.Position(at);
      }
      EXPECT_LT((x[0] - x[1]).norm(), 1e-12 * fine_.size());
      EXPECT_LT((field[0] - field[1]).leftCols<3>().norm(), 1e-9 * field[0].norm());
      EXPECT_LT((field[0] - field[1]).norm(), 1e-6 * field[0].norm());  // twice differentiable
    }
  }
  EXPECT_EQ(open, boundary);
}

TEST_P(HierarchicalMeshTest, BoundaryLoopsCloseThroughAllLevels) {
  EXPECT_EQ(mesh_->mesh().loops.size(), base_.loops.size());
  for (const auto& loop : mesh_->mesh().loops) {
    for (size_t k = 0; k < loop.size(); ++k) {
      const auto& next = loop[(k + 1) % loop.size()];
      EXPECT_LT((fine_.Position(loop[k].end) - fine_.Position(next.begin)).norm(),
                1e-13 * fine_.size());
    }
  }
}

TEST_P(HierarchicalMeshTest, FunctionsAreLinearlyIndependent) {
  // Least eigenvalue of the mass matrix with a diagonal of ones. That of a uniform Loop space with
  // independent ghosts is small already: their functions have corners of triangles only.
  const auto least = [](const ShellSurface& surface) {
    std::vector<int> number(surface.mesh().num_vertices, -1);
    int n = 0;
    for (size_t i = 0; i < number.size(); ++i) {
      if (surface.IsActive(static_cast<int>(i))) number[i] = n++;
    }
    EXPECT_EQ(n, surface.num_active_vertices());
    Eigen::MatrixXd mass = Eigen::MatrixXd::Zero(n, n);
    for (int e = 0; e < surface.num_elements(); ++e) {
      const std::vector<int>& vertices = surface.control_vertices(e);
      for (const TrianglePoint& p : surface.Rule(e, 12)) {
        const ElementPoint at{e, p.s, p.t};
        const Eigen::VectorXd w = surface.ValueWeights(at);
        const double area = surface.MakePoint(at, p.weight).area;
        for (size_t i = 0; i < vertices.size(); ++i) {
          for (size_t j = 0; j < vertices.size(); ++j) {
            mass(number[vertices[i]], number[vertices[j]]) += area * w[i] * w[j];
          }
        }
      }
    }
    const Eigen::VectorXd scale = mass.diagonal().cwiseSqrt().cwiseInverse();
    mass = scale.asDiagonal() * mass * scale.asDiagonal();
    return Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(mass).eigenvalues()[0];
  };
  const double before = least(coarse_), after = least(fine_);
  EXPECT_GT(before, 0.0);
  EXPECT_GT(after, 0.05 * before);
}

TEST_P(HierarchicalMeshTest, ProlongationKeepsTheField) {
  const HierarchicalMesh plain(base_, MeshRefinement());
  // From nothing, from fewer levels, and from less of the same number of levels.
  for (int l = 0; l <= GetParam().levels; ++l) {
    const auto less = Refined(base_, GetParam().center, 0.5 * GetParam().radius, l);
    MeshRefinement both = mesh_->refinement();
    for (size_t k = 0; k < less->refinement().refined.size(); ++k) {
      auto& numbers = both.refined[k];
      const auto& other = less->refinement().refined[k];
      numbers.insert(numbers.end(), other.begin(), other.end());
    }
    const HierarchicalMesh more(base_, both);
    ASSERT_TRUE(more.refinement().Contains(less->refinement()));
    const ShellSurface before(less->mesh()), after(more.mesh());
    const Eigen::Matrix3Xd u = RandomField(before, &gen_);
    const Eigen::Matrix3Xd v = less->Prolong(u, more);
    for (int k = 0; k < 500; ++k) {
      const ElementPoint at = RandomPoint(after.num_elements(), &gen_);
      const ElementPoint coarse = less->Locate(more.BasePoint(at));
      const Eigen::Matrix<double, 3, 6> a = Field(before, u, coarse), b = Field(after, v, at);
      EXPECT_LT((a - b).leftCols<3>().norm(), 1e-10 * a.norm());
      EXPECT_LT((a - b).norm(), 1e-6 * a.norm());
    }
  }
}

TEST_P(HierarchicalMeshTest, RefinedSupportsGiveWay) {
  std::vector<int> marked;
  for (int i = 0; i < mesh_->mesh().mesh.num_vertices; i += 7) {
    if (mesh_->IsUnknown(i)) marked.push_back(i);
  }
  const HierarchicalMesh finer(base_, mesh_->RefineSupports(marked));
  EXPECT_TRUE(finer.refinement().Contains(mesh_->refinement()));
  // Each of them is one of the unknowns of `finer` no more: the leaves that had it are refined.
  std::set<std::pair<int, std::int64_t>> leaves;
  for (int e = 0; e < finer.mesh().mesh.num_elements; ++e) {
    leaves.insert({finer.cell(e).level, finer.cell(e).triangle});
  }
  for (const int i : marked) EXPECT_TRUE(mesh_->GivesWay(i, finer.refinement())) << i;
  for (int i = 0; i < mesh_->mesh().mesh.num_vertices; ++i) {
    if (!mesh_->IsUnknown(i)) continue;
    EXPECT_FALSE(mesh_->GivesWay(i, mesh_->refinement())) << i;
  }
  const std::set<int> set(marked.begin(), marked.end());
  for (int e = 0; e < fine_.num_elements(); ++e) {
    const auto& vertices = fine_.basis().control_vertices(e);
    const bool has = std::any_of(
        vertices.begin(), vertices.end(), [&](int vertex) { return set.count(vertex) > 0; });
    if (has) {
      EXPECT_EQ(leaves.count({mesh_->cell(e).level, mesh_->cell(e).triangle}), 0u);
    }
  }
  EXPECT_GT(ShellSurface(finer.mesh()).num_active_vertices(), fine_.num_active_vertices());
}

TEST_P(HierarchicalMeshTest, RefinedElementsAreNoLeaves) {
  const HierarchicalMesh finer(base_, mesh_->RefineElements({0, 5, 17}));
  for (int e = 0; e < finer.mesh().mesh.num_elements; ++e) {
    for (const int was : {0, 5, 17}) {
      EXPECT_FALSE(finer.cell(e).level == mesh_->cell(was).level &&
                   finer.cell(e).triangle == mesh_->cell(was).triangle);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(
    Meshes,
    HierarchicalMeshTest,
    ::testing::Values(Case{"closed", &Pebble, {0.0, 0.0, 0.7}, 0.5, 1},
                      Case{"closed_two_levels", &Pebble, {0.6, 0.5, 0.2}, 0.5, 2},
                      Case{"closed_three_levels", &Pebble, {0.0, -0.5, 0.5}, 0.4, 3},
                      Case{"open_inside", &Patch, {3.0, 3.0, 0.0}, 0.3, 1},
                      Case{"open_boundary", &Patch, {3.0, 0.0, 0.5}, 1.0, 2},
                      Case{"open_corner", &Patch, {7.0, 6.0, -1.0}, 1.5, 3},
                      Case{"irregular", &Irregular, {3.5, 3.5, 0.3}, 1.0, 2}),
    CaseName);

TEST(HierarchicalMesh, RefinedEverywhereItIsTheSubdivision) {
  const TriangleMesh sphere = MakeIcosphere(1.0, 3);
  const LoopMesh base = MakeLoopMesh(sphere), uniform = MakeLoopMesh(SubdivideLoop(sphere));
  HierarchicalMesh mesh(base, MeshRefinement());
  const HierarchicalMesh refined(base,
                                 mesh.RefineNear({{Eigen::Vector3d::Zero(), 10.0}}, 0, nullptr));
  const LoopMesh& fine = refined.mesh();
  ASSERT_EQ(fine.mesh.num_elements, uniform.mesh.num_elements);
  ASSERT_EQ(fine.mesh.num_vertices, uniform.mesh.num_vertices);
  ASSERT_EQ(fine.mesh.triangles.size(), uniform.mesh.triangles.size());
  for (int e = 0; e < fine.mesh.num_elements; ++e) {
    for (int k = 0; k < 3; ++k) {
      EXPECT_LT((fine.points.col(fine.mesh.triangles[e][k]) -
                 uniform.points.col(uniform.mesh.triangles[e][k]))
                    .norm(),
                1e-14);
    }
  }
  for (int i = 0; i < fine.mesh.num_vertices; ++i) EXPECT_TRUE(refined.IsUnknown(i));
}

TEST(HierarchicalMesh, WithoutRefinementItIsTheMeshItself) {
  const LoopMesh base = Patch();
  const HierarchicalMesh mesh(base, MeshRefinement());
  EXPECT_EQ(mesh.mesh().mesh.triangles, base.mesh.triangles);
  EXPECT_EQ(mesh.mesh().points, base.points);
  EXPECT_EQ(mesh.mesh().hanging, (std::vector<std::array<int, 3>>(84, {-1, -1, -1})));
}

TEST(HierarchicalMesh, CostsAsMuchAsWhatIsRefined) {
  // Ten levels around a point, not 4^10 times as many elements: a level refines at most the three
  // rings around a triangle, 73 triangles where all valences are 6.
  const LoopMesh base = MakeLoopMesh(MakeIcosphere(1.0, 4));
  const auto mesh = Refined(base, {0.3, 0.2, 0.9}, 1e-4, 10);
  EXPECT_EQ(mesh->num_levels(), 11);
  EXPECT_LE(mesh->mesh().mesh.num_elements, 320 + 10 * 3 * 73);
}

}  // namespace
}  // namespace darboux
