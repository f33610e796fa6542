#include "geometry/mesh_doctor.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <random>
#include <string>
#include <vector>

#include "geometry/mesh_io.h"
#include "geometry/mesh_repair.h"
#include "geometry/mesh_topology.h"
#include "tests/mesh_util.h"
#include "tests/sanitizer_util.h"

namespace darboux {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using Kind = MeshDefect::Kind;
using Ids = std::vector<int>;

TriangleMesh Read(const std::string& name) {
  TriangleMesh mesh;
  std::string error;
  EXPECT_TRUE(ReadMesh(DARBOUX_DATA_DIR "/broken_meshes/" + name, &mesh, &error)) << error;
  return mesh;
}

MeshDoctorOptions Closed() {
  MeshDoctorOptions options;
  options.closed = true;
  return options;
}

std::vector<MeshDefect> Defects(const TriangleMesh& mesh, const MeshDoctorOptions& options = {}) {
  return FindMeshDefects(mesh, options);
}

std::vector<Kind> Kinds(const std::vector<MeshDefect>& defects) {
  std::vector<Kind> kinds;
  for (const MeshDefect& defect : defects) kinds.push_back(defect.kind);
  return kinds;
}

Ids Range(int n) {
  Ids ids(static_cast<std::size_t>(n));
  std::iota(ids.begin(), ids.end(), 0);
  return ids;
}

struct Finding {
  std::string file;
  Kind kind;  // And no other.
  Ids vertices, triangles;
  std::string text;
  // What is left once it is mended, with holes of up to 8 edges filled where it has to be closed.
  std::vector<Kind> left;
  bool closed = false;
};

void PrintTo(const Finding& finding, std::ostream* out) { *out << finding.file; }

class BrokenMeshTest : public ::testing::TestWithParam<Finding> {};

TEST_P(BrokenMeshTest, TheDefectIsNamedAndNoOther) {
  const Finding& finding = GetParam();
  const std::vector<MeshDefect> defects =
      Defects(Read(finding.file), finding.closed ? Closed() : MeshDoctorOptions());
  ASSERT_THAT(Kinds(defects), ElementsAre(finding.kind));
  EXPECT_EQ(defects[0].vertices, finding.vertices);
  EXPECT_EQ(defects[0].triangles, finding.triangles);
  EXPECT_EQ(defects[0].text, finding.text);
}

TEST_P(BrokenMeshTest, MendingLeavesWhatHasNoCure) {
  const Finding& finding = GetParam();
  TriangleMesh mesh = Read(finding.file);
  const MeshReport report =
      RepairMesh(&mesh, finding.closed ? Closed() : MeshDoctorOptions(), {finding.closed ? 8 : 0});
  EXPECT_EQ(Kinds(report.defects), finding.left);
  EXPECT_EQ(report.mended.empty(), finding.left == std::vector<Kind>{finding.kind});
}

INSTANTIATE_TEST_SUITE_P(
    Files,
    BrokenMeshTest,
    ::testing::Values(
        Finding{
            "nan.obj", Kind::kNonFiniteVertex, {3}, {}, "1 vertex not finite (nan or inf): 3", {}},
        Finding{"nan_binary.ply",
                Kind::kNonFiniteVertex,
                {3, 4},
                {},
                "2 vertices not finite (nan or inf): 3, 4",
                {}},
        Finding{"repeated_vertex.obj",
                Kind::kDegenerateTriangle,
                {},
                {8},
                "1 triangle without area: 8",
                {}},
        Finding{
            "collinear.obj", Kind::kDegenerateTriangle, {}, {2}, "1 triangle without area: 2", {}},
        Finding{"duplicate_triangle.off",
                Kind::kDuplicateTriangle,
                {},
                {8},
                "1 triangle that repeats another: 8 (same vertices as 2)",
                {}},
        Finding{"back_to_back.off",
                Kind::kDuplicateTriangle,
                {},
                {8},
                "1 triangle that repeats another: 8 (same vertices as 2)",
                {}},
        Finding{"seam.obj",
                Kind::kOpenSeam,
                {6, 0, 13, 7},
                {},
                "2 vertices that coincide with others and leave a seam open: 6 (at 0), 13 (at 7)",
                {}},
        Finding{
            "soup.obj",
            Kind::kOpenSeam,
            {3,  1, 5,  2, 6,  4,  8,  2, 9,  7, 10, 0,  11, 2, 12, 1, 13, 0,
             15, 4, 16, 1, 17, 14, 18, 7, 19, 4, 20, 14, 21, 0, 22, 7, 23, 14},
            {},
            "18 vertices that coincide with others and leave a seam open: 3 (at 1), 5 (at 2), 6 "
            "(at 4), 8 (at 2), 9 (at 7), 10 (at 0), 11 (at 2), 12 (at 1), ... and 10 more",
            {},
            true},
        Finding{"non_manifold_edge.ply",
                Kind::kNonManifoldEdge,
                {0, 1},
                {0, 1, 2},
                "1 edge with more than two triangles: 0-1 (triangles 0, 1, 2)",
                {Kind::kNonManifoldEdge}},
        Finding{"moebius.off",
                Kind::kNonOrientable,
                {},
                {2, 3},
                "a surface with one side only, like a Moebius strip; whatever way triangles are "
                "wound, some disagree, here across 1 edge: 2-5",
                {Kind::kNonOrientable}},
        Finding{"flipped_triangle.obj",
                Kind::kFlippedTriangle,
                {},
                {3},
                "1 triangle wound against the others: 3",
                {}},
        Finding{"flipped_closed.obj",
                Kind::kFlippedTriangle,
                {},
                {0, 1, 2, 3, 4},
                "5 triangles wound against the others: 0, 1, 2, 3, 4",
                {},
                true},
        Finding{"inside_out.stl",
                Kind::kInsideOut,
                {},
                Range(8),
                "1 closed piece inside out, with normals that point inwards: 8 triangles from "
                "triangle 0",
                {},
                true},
        Finding{"bow_tie.obj",
                Kind::kNonManifoldVertex,
                {0},
                {},
                "1 vertex where several fans of triangles meet in a point: 0",
                {Kind::kNonManifoldVertex}},
        Finding{"isolated_vertex.obj",
                Kind::kIsolatedVertex,
                {4},
                {},
                "1 vertex that no triangle uses: 4",
                {}},
        Finding{"two_components.obj",
                Kind::kSeveralComponents,
                {},
                {0, 8},
                "2 separate pieces instead of 1: 8 triangles from triangle 0, 8 triangles from "
                "triangle 8",
                {Kind::kSeveralComponents},
                true},
        Finding{"hole.off",
                Kind::kHole,
                {1, 4, 3},
                {},
                "1 hole in a mesh that has to be closed: 3 edges along vertices 1, 4, 3",
                {},
                true},
        Finding{"self_intersection.obj",
                Kind::kSelfIntersection,
                {},
                {0, 5, 0, 6, 3, 6},
                "3 pairs of triangles that pass through each other or lie on each other: 0 and 5, "
                "0 and 6, 3 and 6",
                {Kind::kSelfIntersection},
                true},
        Finding{"pierced_at_vertex.obj",
                Kind::kSelfIntersection,
                {},
                {0, 1},
                "1 pair of triangles that pass through each other or lie on each other: 0 and 1",
                {Kind::kSelfIntersection}},
        Finding{
            "folded_plane.obj",
            Kind::kSelfIntersection,
            {},
            {0, 2, 0, 3, 1, 2, 1, 3, 1, 6, 2, 3, 4, 6, 6, 7},
            "8 pairs of triangles that pass through each other or lie on each other: 0 and 2, 0 "
            "and 3, 1 and 2, 1 and 3, 1 and 6, 2 and 3, 4 and 6, 6 and 7",
            {Kind::kSelfIntersection}}));

TEST(MeshDoctorTest, SoundMeshesHaveNoDefects) {
  EXPECT_THAT(Defects(Octahedron(), Closed()), IsEmpty());
  EXPECT_THAT(Defects(Torus(30, 20), Closed()), IsEmpty());
  EXPECT_THAT(Defects(Lattice(5, 4)), IsEmpty());
  EXPECT_THAT(Defects(Read("quad_not_planar.obj")), IsEmpty());
  MeshDoctorOptions two_pieces;
  two_pieces.max_components = 2;
  EXPECT_THAT(Defects(Read("touching.obj"), two_pieces), IsEmpty());
  EXPECT_THAT(Kinds(Defects(Read("crossing_along_edges.obj"), two_pieces)),
              ElementsAre(Kind::kSelfIntersection));
}

// With every kind of defect that does not hide another.
TriangleMesh Ruin() {
  TriangleMesh mesh = Octahedron();
  mesh.triangles.erase(mesh.triangles.begin() + 7);                    // A hole.
  std::swap(mesh.triangles[2][0], mesh.triangles[2][1]);               // A flipped triangle.
  mesh.vertices.emplace_back(9, 9, 9);                                 // 6: isolated.
  mesh.vertices.emplace_back(std::nan(""), 0, 0);                      // 7
  mesh.triangles.push_back({0, 1, 1});                                 // 7: degenerate.
  mesh.triangles.push_back({1, 4, 2});                                 // 8: repeats 1.
  mesh.triangles.push_back({0, 1, 10});                                // 9: no such vertex.
  mesh.triangles.push_back({0, -1, std::numeric_limits<int>::min()});  // 10
  mesh.vertices.emplace_back(0.5, 0.5, 3);                             // 8
  mesh.vertices.emplace_back(-0.5, -0.5, -3);                          // 9
  mesh.triangles.push_back({7, 8, 9});                                 // 11: another piece.
  return mesh;
}

TEST(MeshDoctorTest, ManyDefectsAreFoundAtOnceMostBasicFirst) {
  const std::vector<MeshDefect> defects = Defects(Ruin(), Closed());
  ASSERT_THAT(Kinds(defects),
              ElementsAre(Kind::kNonFiniteVertex,
                          Kind::kIndexOutOfRange,
                          Kind::kDegenerateTriangle,
                          Kind::kDuplicateTriangle,
                          Kind::kFlippedTriangle,
                          Kind::kIsolatedVertex,
                          Kind::kSeveralComponents,
                          Kind::kHole));
  EXPECT_EQ(defects[1].text,
            "2 triangles with vertices that do not exist (there are 10, from 0): 9, 10");
  EXPECT_THAT(defects[4].triangles, ElementsAre(2));
  EXPECT_EQ(
      defects[7].text,
      "2 holes in a mesh that has to be closed: 3 edges from vertex 0, 3 edges from vertex 7");
}

TEST(MeshDoctorTest, ManyDefectsAreMendedAtOnce) {
  TriangleMesh mesh = Ruin();
  const MeshReport report = RepairMesh(&mesh, Closed(), {3});
  EXPECT_THAT(report.defects, IsEmpty());
  EXPECT_NEAR(Volume(mesh), Volume(Octahedron()), 1e-15);
  EXPECT_THAT(
      report.mended,
      ElementsAre(
          "dropped 1 triangle with vertices that are not finite: 11",
          "dropped 2 triangles with vertices that do not exist (there are 10, from 0): 9, 10",
          "dropped 1 triangle that repeats another: 8 (same vertices as 1)",
          "turned over 1 triangle wound against the others: 2",
          "dropped 1 triangle without area: 7",
          "filled a hole of 3 edges along vertices 0, 5, 3",
          "dropped 4 vertices without triangles and numbered the other 6 anew: 6, 7, 8, 9"));
}

class MeshOfSizeTest : public ::testing::TestWithParam<double> {};

TEST_P(MeshOfSizeTest, DefectsDoNotDependOnSizeAndPosition) {
  const double size = GetParam();
  const Eigen::Matrix3d turn =
      Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix();
  for (const char* file : {"collinear.obj",
                           "seam.obj",
                           "soup.obj",
                           "inside_out.stl",
                           "self_intersection.obj",
                           "pierced_at_vertex.obj",
                           "folded_plane.obj",
                           "crossing_along_edges.obj",
                           "touching.obj"}) {
    const TriangleMesh original = Read(file);
    TriangleMesh mesh = original;
    for (Eigen::Vector3d& v : mesh.vertices) {
      v = size * (turn * v + Eigen::Vector3d(10, -20, 30));
    }
    const std::vector<MeshDefect> expected = Defects(original), found = Defects(mesh);
    ASSERT_EQ(Kinds(found), Kinds(expected)) << file;
    for (std::size_t k = 0; k < found.size(); ++k)
      EXPECT_EQ(found[k].text, expected[k].text) << file;
  }
}

INSTANTIATE_TEST_SUITE_P(Sizes, MeshOfSizeTest, ::testing::Values(1e-200, 1e-9, 1.0, 1e3, 1e200));

TEST(MeshDoctorTest, SeamsOpenByRoundingAreSeams) {
  TriangleMesh mesh = Read("soup.obj");
  std::mt19937 gen(38401);
  std::uniform_real_distribution<double> rounding(-5e-8, 5e-8);
  for (Eigen::Vector3d& v : mesh.vertices) {
    for (int k = 0; k < 3; ++k) v[k] += rounding(gen);
  }
  EXPECT_THAT(Kinds(Defects(mesh, Closed())), ElementsAre(Kind::kOpenSeam));
  EXPECT_THAT(RepairMesh(&mesh, Closed()).defects, IsEmpty());
  EXPECT_EQ(mesh.vertices.size(), 6u);
}

TEST(MeshDoctorTest, VerticesThatOnlyTouchAreNoSeam) {
  // Two pieces that touch in a vertex, and a vertex of one on an edge of the other.
  const TriangleMesh mesh = {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 0}, {-1, 0, 0}, {0, -1, 0}},
                             {{{0, 1, 2}}, {{3, 4, 5}}}};
  EXPECT_THAT(Kinds(Defects(mesh)), ElementsAre(Kind::kSeveralComponents));
}

TEST(MeshDoctorTest, ASlitMayStayOpen) {
  MeshDoctorOptions options;
  options.allow_seams = true;
  EXPECT_THAT(Defects(Read("seam.obj"), options), IsEmpty());
  TriangleMesh mesh = Read("seam.obj");
  EXPECT_THAT(RepairMesh(&mesh, options).mended, IsEmpty());
  EXPECT_EQ(mesh.vertices.size(), 14u);
}

TEST(MeshDoctorTest, CornersOfOneTriangleAreFoundOnDemand) {
  MeshDoctorOptions options;
  options.min_boundary_valence = 3;
  const std::vector<MeshDefect> defects = Defects(Lattice(3, 2), options);
  ASSERT_THAT(Kinds(defects), ElementsAre(Kind::kLowValence));
  EXPECT_EQ(defects[0].text, "2 vertices of the boundary with less than 3 edges: 3, 8");
}

TEST(MeshDoctorTest, NoMeshIsTooBroken) {
  EXPECT_THAT(Kinds(Defects({})), ElementsAre(Kind::kNoTriangles));
  const double nan = std::nan(""), inf = std::numeric_limits<double>::infinity();
  const double max = std::numeric_limits<double>::max();
  std::mt19937 gen(38401);
  for (int trial = 0; trial < 300; ++trial) {
    TriangleMesh mesh;
    const double values[] = {0.0, 1.0, -1.0, nan, inf, max, -max, 1e-320};
    for (int v = 0; v < 12; ++v) {
      const unsigned kinds = trial % 3 == 0 ? 8 : 3;
      mesh.vertices.emplace_back(
          values[gen() % kinds], values[gen() % kinds], values[gen() % kinds]);
    }
    for (int t = 0; t < 30; ++t) {
      const auto vertex = [&] {
        return static_cast<int>(gen() % (trial % 2 == 0 ? 14 : 12)) - trial % 2;
      };
      mesh.triangles.push_back({vertex(), vertex(), vertex()});
    }
    for (const MeshDefect& defect : Defects(mesh, Closed())) {
      EXPECT_EQ(defect.text.find('\n'), std::string::npos);
      EXPECT_LT(defect.text.size(), 1000u);
    }
    const MeshReport report = RepairMesh(&mesh, Closed(), {500});
    for (const Kind kind : Kinds(report.defects)) {  // What has a cure is gone.
      EXPECT_NE(kind, Kind::kNonFiniteVertex);
      EXPECT_NE(kind, Kind::kIndexOutOfRange);
      EXPECT_NE(kind, Kind::kDuplicateTriangle);
      EXPECT_NE(kind, Kind::kIsolatedVertex);
      EXPECT_NE(kind, Kind::kOpenSeam);
      EXPECT_NE(kind, Kind::kFlippedTriangle);
      EXPECT_NE(kind, Kind::kInsideOut);
    }
  }
}

TEST(MeshDoctorTest, IdsAreCutShortInTheTextOnly) {
  TriangleMesh mesh = Octahedron();
  mesh.vertices.resize(26, Eigen::Vector3d::Zero());
  const std::vector<MeshDefect> defects = Defects(mesh);
  ASSERT_EQ(defects.size(), 1u);
  EXPECT_EQ(defects[0].vertices.size(), 20u);
  EXPECT_EQ(defects[0].text,
            "20 vertices that no triangle uses: 6, 7, 8, 9, 10, 11, 12, 13, ... and 12 more");
}

TEST(MeshDoctorTest, TwentyThousandTrianglesTakeMuchLessThanASecond) {
  const TriangleMesh mesh = Torus(125, 80);
  ASSERT_EQ(mesh.triangles.size(), 20000u);
  TriangleMesh soup;
  for (const std::array<int, 3>& t : mesh.triangles) {
    const int n = static_cast<int>(soup.vertices.size());
    for (const int v : t) soup.vertices.push_back(mesh.vertices[static_cast<std::size_t>(v)]);
    soup.triangles.push_back({n, n + 1, n + 2});
  }
  const double start = CpuSeconds();
  EXPECT_THAT(Defects(mesh, Closed()), IsEmpty());
  EXPECT_THAT(Kinds(Defects(soup, Closed())), ElementsAre(Kind::kOpenSeam));
  EXPECT_LT(CpuSeconds() - start, 2.0 * kSlowdown);  // 0.03 and 0.06 s
}

// --- Mending -----------------------------------------------------------------------------------

TEST(MeshRepairTest, ASoundMeshStaysAsItIs) {
  TriangleMesh mesh = Torus(8, 6);
  const MeshReport report = RepairMesh(&mesh, Closed(), {500});
  EXPECT_THAT(report.mended, IsEmpty());
  EXPECT_THAT(report.defects, IsEmpty());
  EXPECT_EQ(mesh.vertices, Torus(8, 6).vertices);
  EXPECT_EQ(mesh.triangles, Torus(8, 6).triangles);
}

TEST(MeshRepairTest, RandomWindingsBecomeOutward) {
  std::mt19937 gen(38401);
  TriangleMesh mesh = Torus(30, 20);
  const double volume = Volume(mesh);
  for (std::array<int, 3>& t : mesh.triangles) {
    if (gen() % 3 != 0) std::swap(t[0], t[2]);
  }
  EXPECT_THAT(RepairMesh(&mesh, Closed()).defects, IsEmpty());
  EXPECT_NEAR(Volume(mesh), volume, 1e-12 * volume);
}

TEST(MeshRepairTest, ATriangleSoupBecomesASurface) {
  TriangleMesh soup;
  const TriangleMesh torus = Torus(30, 20);
  std::mt19937 gen(38401);
  for (const std::array<int, 3>& t : torus.triangles) {
    const int n = static_cast<int>(soup.vertices.size());
    for (const int v : t) soup.vertices.push_back(torus.vertices[static_cast<std::size_t>(v)]);
    soup.triangles.push_back({n, n + 1, n + 2});
    if (gen() % 2 == 0) std::swap(soup.triangles.back()[0], soup.triangles.back()[1]);
  }
  EXPECT_THAT(RepairMesh(&soup, Closed()).defects, IsEmpty());
  EXPECT_EQ(soup.vertices.size(), torus.vertices.size());
  EXPECT_NEAR(Volume(soup), Volume(torus), 1e-12);
}

TEST(MeshRepairTest, FlatTrianglesGoWithoutACrack) {
  // Vertices on the sides of others' triangles, in a plane with the outline of a square: flat
  // triangles close the cracks. Area and outline stay.
  TriangleMesh mesh = {
      {{0, 0, 0}, {2, 0, 0}, {2, 2, 0}, {0, 2, 0}, {0.5, 0.5, 0}, {1.1, 1.1, 0}},
      {{{0, 1, 2}}, {{0, 2, 5}}, {{0, 5, 4}}, {{0, 4, 3}}, {{4, 5, 3}}, {{5, 2, 3}}}};
  const MeshReport report = RepairMesh(&mesh, {});
  EXPECT_THAT(report.defects, IsEmpty());
  EXPECT_NEAR(Area(mesh), 4.0, 1e-15);
  EXPECT_EQ(mesh.triangles.size(), 6u);
  EXPECT_THAT(BoundaryLoops(mesh), ElementsAre(ElementsAre(0, 1, 2, 3)));
}

TEST(MeshRepairTest, CoincidentNeighboursBecomeOneVertex) {
  // An octahedron with its top split into two vertices at the same place, so that two of the ten
  // triangles have no area.
  TriangleMesh mesh = {
      {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}, {0, 0, 1}},
      {{{0, 2, 4}},
       {{2, 1, 6}},
       {{2, 6, 4}},
       {{1, 3, 6}},
       {{3, 0, 4}},
       {{3, 4, 6}},
       {{2, 0, 5}},
       {{1, 2, 5}},
       {{3, 1, 5}},
       {{0, 3, 5}}}};
  EXPECT_THAT(Kinds(Defects(mesh, Closed())), ElementsAre(Kind::kDegenerateTriangle));
  EXPECT_THAT(RepairMesh(&mesh, Closed()).defects, IsEmpty());
  EXPECT_EQ(mesh.vertices, Octahedron().vertices);
  EXPECT_EQ(mesh.triangles.size(), 8u);
}

TEST(MeshRepairTest, HolesUpToTheGivenSizeAreFilled) {
  TriangleMesh pierced = Torus(30, 20);
  pierced.triangles.erase(pierced.triangles.begin() + 700,
                          pierced.triangles.begin() + 710);  // 5 cells
  pierced.triangles.erase(pierced.triangles.begin() + 100);
  for (const int max_edges : {2, 3, 11, 12}) {
    TriangleMesh mesh = pierced;
    const MeshReport report = RepairMesh(&mesh, Closed(), {max_edges});
    const std::size_t num_filled = (max_edges >= 3) + (max_edges >= 12);
    EXPECT_EQ(report.mended.size(), num_filled);
    EXPECT_EQ(BoundaryLoops(mesh).size(), 2 - num_filled);
    EXPECT_EQ(Kinds(report.defects),
              num_filled == 2 ? std::vector<Kind>() : std::vector<Kind>{Kind::kHole});
    if (num_filled < 2) continue;
    EXPECT_EQ(mesh.triangles.size(), 1200u);
    EXPECT_NEAR(Volume(mesh), Volume(Torus(30, 20)), 1e-3 * Volume(mesh));
  }
}

TEST(MeshRepairTest, TheRimOfAnOpenMeshIsNoHole) {
  TriangleMesh mesh = Lattice(4, 4);
  mesh.triangles.erase(mesh.triangles.begin() + 10, mesh.triangles.begin() + 14);  // 2 cells
  EXPECT_THAT(RepairMesh(&mesh, {}, {100}).mended,
              ElementsAre("filled a hole of 6 edges along vertices 6, 11, 12, 13, 8, 7"));
  EXPECT_THAT(Defects(mesh), IsEmpty());
  EXPECT_NEAR(Area(mesh), 16.0, 1e-14);
  EXPECT_EQ(BoundaryLoops(mesh).size(), 1u);
}

TEST(MeshRepairTest, AHoleIsNotFilledWithEdgesThatExist) {
  // Two neighbours of an octahedron are missing, with the edge between them.
  TriangleMesh mesh = Octahedron();
  mesh.triangles.erase(mesh.triangles.begin(), mesh.triangles.begin() + 2);
  EXPECT_THAT(RepairMesh(&mesh, Closed(), {4}).defects, IsEmpty());
  EXPECT_EQ(mesh.triangles.size(), 8u);
  EXPECT_NEAR(Volume(mesh), Volume(Octahedron()), 1e-15);
  // A single triangle is no mesh with a hole.
  TriangleMesh single = {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{{0, 1, 2}}}};
  EXPECT_THAT(Kinds(RepairMesh(&single, Closed(), {4}).defects), ElementsAre(Kind::kHole));
  // A tetrahedron without two faces: one diagonal of the hole is the edge between the other two.
  TriangleMesh tetrahedron = {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}},
                              {{{0, 2, 1}}, {{0, 1, 3}}}};
  EXPECT_THAT(RepairMesh(&tetrahedron, Closed(), {4}).defects, IsEmpty());
  EXPECT_NEAR(Volume(tetrahedron), 1.0 / 6.0, 1e-15);
}

}  // namespace
}  // namespace darboux
