#include "geometry/implicit_mesh.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <optional>
#include <string>

#include "geometry/expression.h"
#include "geometry/implicit_function.h"
#include "geometry/triangle_mesh.h"
#include "tests/mesh_quality.h"

namespace darboux {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

Expression Parse(const std::string& text) {
  std::string error;
  const std::optional<Expression> e = Expression::Parse(text, {"x", "y", "z"}, &error);
  EXPECT_TRUE(e.has_value()) << error;
  return e.value_or(Expression::Constant(0.0));
}

Eigen::AlignedBox3d Cube(double half) {
  return {Eigen::Vector3d::Constant(-half), Eigen::Vector3d::Constant(half)};
}

TriangleMesh Mesh(const std::string& text,
                  double half,
                  double edge,
                  const ImplicitMeshOptions& options = {}) {
  TriangleMesh mesh;
  std::string error;
  EXPECT_TRUE(MeshImplicitSurface(Parse(text), Cube(half), edge, options, &mesh, &error)) << error;
  return mesh;
}

std::string ErrorOf(const std::string& text,
                    double half,
                    double edge,
                    const ImplicitMeshOptions& options = {}) {
  TriangleMesh mesh;
  std::string error;
  EXPECT_FALSE(MeshImplicitSurface(Parse(text), Cube(half), edge, options, &mesh, &error));
  EXPECT_THAT(error, Not(HasSubstr("\n")));
  return error;
}

ImplicitMeshOptions AllowBoundary() {
  ImplicitMeshOptions options;
  options.allow_boundary = true;
  return options;
}

struct Shape {
  const char* name;
  const char* function;
  double half;  // Of the box.
  double edge;
  int euler_characteristic;
};

std::ostream& operator<<(std::ostream& out, const Shape& shape) { return out << shape.name; }

class ClosedImplicitMeshTest : public ::testing::TestWithParam<Shape> {};

TEST_P(ClosedImplicitMeshTest, IsEvenClosedAndOutward) {
  const Shape& shape = GetParam();
  const TriangleMesh mesh = Mesh(shape.function, shape.half, shape.edge);
  const MeshQuality q = MeasureMesh(mesh);
  EXPECT_TRUE(q.is_manifold);
  EXPECT_EQ(q.num_boundary_edges, 0);
  EXPECT_EQ(q.num_components, 1);
  EXPECT_EQ(q.euler_characteristic, shape.euler_characteristic);
  EXPECT_GT(q.volume, 0.0);
  EXPECT_GT(q.min_edge, 0.6 * shape.edge);
  EXPECT_LT(q.max_edge, 1.5 * shape.edge);
  EXPECT_GT(q.min_angle_deg, 30.0);
  EXPECT_GE(q.valences.begin()->first, 5);
  EXPECT_LE(q.valences.rbegin()->first, 7);
  EXPECT_GT(q.valences.at(6), 0.7 * static_cast<double>(mesh.vertices.size()));

  const Expression expression = Parse(shape.function);
  const ImplicitFunction function(expression);
  const double size = Cube(shape.half).diagonal().norm();
  for (const Eigen::Vector3d& p : mesh.vertices) {
    Eigen::Vector3d gradient;
    const double f = function.Value(p, &gradient);
    EXPECT_LE(std::abs(f), 1e-12 * size * gradient.stableNorm());
  }
  for (const std::array<int, 3>& t : mesh.triangles) {
    const Eigen::Vector3d &a = mesh.vertices[t[0]], &b = mesh.vertices[t[1]],
                          &c = mesh.vertices[t[2]];
    Eigen::Vector3d gradient;
    function.Value(a, &gradient);
    EXPECT_GT((b - a).cross(c - a).dot(gradient.stableNormalized()), 0.0);
  }
}

INSTANTIATE_TEST_SUITE_P(
    Shapes,
    ClosedImplicitMeshTest,
    ::testing::Values(Shape{"sphere", "x^2+y^2+z^2-1", 1.5, 0.1, 2},
                      Shape{"coarse sphere", "x^2+y^2+z^2-1", 1.5, 0.4, 2},
                      Shape{"sphere whose f is huge", "1e200*(x^2+y^2+z^2-1)", 1.5, 0.2, 2},
                      Shape{"sphere whose f is tiny", "1e-200*(x^2+y^2+z^2-1)", 1.5, 0.2, 2},
                      Shape{"sphere whose f is uneven", "exp(-3*x)*(x^2+y^2+z^2-1)", 1.5, 0.1, 2},
                      Shape{"sphere that touches the box", "x^2+y^2+z^2-1", 1.0, 0.1, 2},
                      Shape{"torus", "(sqrt(x^2+y^2)-1)^2+z^2-0.16", 1.6, 0.1, 0},
                      Shape{"ellipsoid", "x^2+(y/2)^2+(z/3)^2-1", 3.3, 0.2, 2},
                      Shape{"rounded cube", "x^4+y^4+z^4-1", 1.2, 0.1, 2},
                      Shape{"two spheres blended",
                            "-log(exp(-((x-0.6)^2+y^2+z^2-0.5)*4)+exp(-((x+0.6)^2+y^2+z^2-0.5)*4))",
                            2.0,
                            0.12,
                            2},
                      Shape{"double torus", "((x^2+y^2)^2-x^2+y^2)^2+z^2-0.01", 1.4, 0.04, -2}));

TEST(ImplicitMeshTest, SphereConvergesWithOrderTwo) {
  double area_error[2], volume_error[2];
  for (int i = 0; i < 2; ++i) {
    const TriangleMesh mesh = Mesh("x^2+y^2+z^2-1", 1.5, i == 0 ? 0.16 : 0.08);
    for (const Eigen::Vector3d& p : mesh.vertices) EXPECT_NEAR(p.norm(), 1.0, 1e-12);
    const MeshQuality q = MeasureMesh(mesh);
    area_error[i] = 4.0 * M_PI - q.area;
    volume_error[i] = 4.0 / 3.0 * M_PI - q.volume;
  }
  EXPECT_NEAR(std::log2(area_error[0] / area_error[1]), 2.0, 0.1);
  EXPECT_NEAR(std::log2(volume_error[0] / volume_error[1]), 2.0, 0.1);
}

TEST(ImplicitMeshTest, UnitOfLengthIsImmaterial) {
  const TriangleMesh metres = Mesh("x^2+(y/2)^2+(z/3)^2-1", 3.3, 0.3);
  const TriangleMesh millimetres = Mesh("(x/1e3)^2+(y/2e3)^2+(z/3e3)^2-1", 3300.0, 300.0);
  ASSERT_EQ(metres.triangles, millimetres.triangles);
  for (size_t i = 0; i < metres.vertices.size(); ++i) {
    EXPECT_LE((millimetres.vertices[i] - 1000.0 * metres.vertices[i]).norm(), 1e-9 * 3300.0);
  }
}

TEST(ImplicitMeshTest, IsDeterministic) {
  const TriangleMesh a = Mesh("x^4+y^4+z^4-1", 1.2, 0.2);
  const TriangleMesh b = Mesh("x^4+y^4+z^4-1", 1.2, 0.2);
  EXPECT_EQ(a.triangles, b.triangles);
  EXPECT_EQ(a.vertices, b.vertices);
}

TEST(ImplicitMeshTest, CutSurfaceEndsInTheBox) {
  const double half = 1.0;
  const TriangleMesh mesh = Mesh("z-0.3*sin(3*x)*y", half, 0.1, AllowBoundary());
  const MeshQuality q = MeasureMesh(mesh);
  EXPECT_TRUE(q.is_manifold);
  EXPECT_EQ(q.euler_characteristic, 1);  // A disk.
  EXPECT_GT(q.num_boundary_edges, 70);
  EXPECT_GT(q.min_angle_deg, 25.0);
  EXPECT_GT(q.min_edge, 0.55 * 0.1);
  EXPECT_LT(q.max_edge, 1.5 * 0.1);
  EXPECT_GE(q.valences.begin()->first, 5);
  EXPECT_LE(q.valences.rbegin()->first, 7);
  int num_on_box = 0, num_corners = 0;
  for (const Eigen::Vector3d& p : mesh.vertices) {
    const int on_faces = (std::abs(p.x()) == half) + (std::abs(p.y()) == half);
    if (on_faces > 0) ++num_on_box;
    if (on_faces > 1) ++num_corners;
    EXPECT_NEAR(p.z(), 0.3 * std::sin(3.0 * p.x()) * p.y(), 1e-12);
  }
  EXPECT_EQ(num_on_box, q.num_boundary_edges);
  EXPECT_EQ(num_corners, 4);
}

TEST(ImplicitMeshTest, SphereCutBySixFacesHasSixHoles) {
  const MeshQuality q = MeasureMesh(Mesh("x^2+y^2+z^2-1", 0.9, 0.1, AllowBoundary()));
  EXPECT_TRUE(q.is_manifold);
  EXPECT_EQ(q.euler_characteristic, 2 - 6);
  EXPECT_GT(q.min_angle_deg, 25.0);
}

TEST(ImplicitMeshTest, SeveralPiecesOnRequest) {
  ImplicitMeshOptions options;
  options.allow_several_components = true;
  const MeshQuality q =
      MeasureMesh(Mesh("min((x-1)^2+y^2+z^2-0.5,(x+1)^2+y^2+z^2-0.4)", 2.0, 0.15, options));
  EXPECT_EQ(q.num_components, 2);
  EXPECT_EQ(q.euler_characteristic, 4);
}

// ---- Mistakes ----

TEST(ImplicitMeshErrorTest, NoZero) {
  EXPECT_THAT(ErrorOf("x^2+y^2+z^2+1", 1.0, 0.1),
              AllOf(HasSubstr("no zero within the bounds"), HasSubstr("positive at all")));
}

TEST(ImplicitMeshErrorTest, LeavesTheBounds) {
  EXPECT_THAT(ErrorOf("x^2+y^2+z^2-1", 0.9, 0.1),
              AllOf(HasSubstr("leaves the bounds at ("),
                    HasSubstr("z = -0.9"),
                    HasSubstr("allowed is a closed surface")));
}

TEST(ImplicitMeshErrorTest, NegativeOutside) {
  EXPECT_THAT(ErrorOf("1-x^2-y^2-z^2", 1.5, 0.1), HasSubstr("change its sign"));
}

TEST(ImplicitMeshErrorTest, NotFinite) {
  EXPECT_THAT(ErrorOf("sqrt(x)-0.3", 1.0, 0.1),
              HasSubstr("the function is not finite at (-1, -1, -1)"));
}

TEST(ImplicitMeshErrorTest, Pole) {
  EXPECT_THAT(ErrorOf("1/(x-0.01)", 1.0, 0.2, AllowBoundary()), HasSubstr("no point of a smooth"));
}

TEST(ImplicitMeshErrorTest, SingularPoints) {
  EXPECT_THAT(ErrorOf("x^2+y^2-(z-0.25)^2", 1.0, 0.1, AllowBoundary()),
              HasSubstr("gradient vanishes on the surface at (0, 0, 0.25)"));
  EXPECT_THAT(ErrorOf("x*y", 1.0, 0.1, AllowBoundary()),
              HasSubstr("gradient vanishes on the surface at (0, 0, "));
  EXPECT_THAT(ErrorOf("(x^2+y^2+z^2-1)^3", 1.5, 0.2),
              HasSubstr("gradient vanishes on the surface"));
  EXPECT_THAT(ErrorOf("1e-9*(x^2+y^2-z^2)", 1.0, 0.1, AllowBoundary()),
              HasSubstr("gradient vanishes on the surface at (0, 0, 0)"));
}

TEST(ImplicitMeshErrorTest, SeveralPieces) {
  EXPECT_THAT(ErrorOf("(x^2+y^2+z^2-1)*((x-3)^2+y^2+z^2-1)", 5.0, 0.2),
              AllOf(HasSubstr("has 2 pieces"), HasSubstr("allowed is 1")));
}

TEST(ImplicitMeshErrorTest, EdgeTooLargeForTheShape) {
  EXPECT_THAT(ErrorOf("x^2+y^2+(10*z)^2-1", 1.5, 0.1),
              AllOf(HasSubstr("edge length 0.1 is too large for the shape at ("),
                    HasSubstr("allowed are 60")));
  // A crease is too sharp for any edge length.
  EXPECT_THAT(ErrorOf("max(abs(x),max(abs(y),abs(z)))-1", 1.5, 0.1), HasSubstr("too large"));
}

TEST(ImplicitMeshErrorTest, LostPiece) {
  EXPECT_THAT(ErrorOf("(x^2+y^2+z^2-1)*((x-1.5)^2+y^2+z^2-0.01)", 3.0, 0.5),
              AllOf(HasSubstr("a piece of the surface smaller than that is lost at (1.5")));
}

TEST(ImplicitMeshErrorTest, EdgeTooSmall) {
  EXPECT_THAT(ErrorOf("x^2+y^2+z^2-1", 1.5, 0.001),
              AllOf(HasSubstr("too small for the bounds"), HasSubstr("allowed are 400000000")));
  ImplicitMeshOptions options;
  options.max_triangles = 10000;
  EXPECT_THAT(
      ErrorOf("x^2+y^2+z^2-1", 1.5, 0.03, options),
      AllOf(HasSubstr("edge length 0.03 is too small for the surface"), HasSubstr("10000")));
}

TEST(ImplicitMeshErrorTest, EdgeLengthAndBounds) {
  for (const double edge : {0.0, -1.0, 3.5, std::nan("")}) {
    EXPECT_THAT(ErrorOf("x^2+y^2+z^2-1", 1.5, edge),
                AllOf(HasSubstr("edge length"), HasSubstr("allowed is > 0")));
  }
  EXPECT_THAT(ErrorOf("x^2+y^2+z^2-1", -1.0, 0.1), HasSubstr("the bounds of x"));
  EXPECT_THAT(ErrorOf("x^2+y^2+z^2-1", INFINITY, 0.1), HasSubstr("the bounds of x"));
}

TEST(ImplicitMeshErrorTest, Options) {
  ImplicitMeshOptions options;
  options.max_normal_angle = 2.0;
  EXPECT_THAT(ErrorOf("x^2+y^2+z^2-1", 1.5, 0.1, options), HasSubstr("max_normal_angle is 2"));
}

}  // namespace
}  // namespace darboux
