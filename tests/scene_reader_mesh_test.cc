// Surfaces of scenes that are meshes, and mistakes in them.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "tests/scene_reader_util.h"
#include "tests/temporary_folder.h"

namespace darboux {
namespace {

using ::testing::StartsWith;

TEST(SceneReaderTest, MeshesAreReadAsControlPoints) {
  const Scene scene = Parse(OnMesh(MeshFile("duck_642.obj"), "supports: []\n"));
  EXPECT_EQ(scene.surface.kind, "mesh");
  EXPECT_EQ(scene.surface.surface, nullptr);
  ASSERT_NE(scene.surface.mesh, nullptr);
  EXPECT_EQ(scene.surface.mesh->vertices.size(), 642u);
  EXPECT_FALSE(scene.surface.interpolate);
  EXPECT_FALSE(scene.surface.is_open);
  EXPECT_TRUE(scene.surface.mended.empty());
  EXPECT_TRUE(Parse(OnMesh(MeshFile("duck_642.obj") + ", fit: interpolate")).surface.interpolate);
  EXPECT_TRUE(Parse(OnMesh(MeshFile("broken_meshes/quad_not_planar.obj"))).surface.is_open);
}

TEST(SceneReaderTest, OtherMeshesAreReadAsPointsOfTheSurface) {
  for (const char* surface : {kIcosphere, kBall}) {
    const Scene scene = Parse(OnMesh(surface));
    ASSERT_NE(scene.surface.mesh, nullptr);
    EXPECT_TRUE(scene.surface.interpolate);
    EXPECT_FALSE(scene.surface.is_open);
    const double radius = surface == kBall ? 1.0 : 2.0;
    for (const Eigen::Vector3d& x : scene.surface.mesh->vertices) {
      EXPECT_NEAR(x.norm(), radius, 1e-11);
    }
    EXPECT_FALSE(Parse(OnMesh(surface + std::string(", fit: control"))).surface.interpolate);
  }
}

TEST(SceneReaderTest, ImplicitSurfacesMayBeCutAlongTheBounds) {
  std::string text = Ball("[-2, 2]]", "[-2, 0.5]]");
  text.replace(text.find("edge_length"), 0, "open: true, ");
  const SurfaceSpec surface = Parse(text + "supports: [{on: rim, clamped: true}]\n").surface;
  EXPECT_TRUE(surface.is_open);
  double highest = -1.0;
  for (const Eigen::Vector3d& x : surface.mesh->vertices) highest = std::max(highest, x.z());
  EXPECT_EQ(highest, 0.5);
}

TEST(SceneReaderTest, RefinementQuadruplesTheTrianglesOfTheSameSurface) {
  const TriangleMesh coarse = *Parse(OnMesh(MeshFile("duck_642.obj"))).surface.mesh;
  const SurfaceSpec fine = Parse(OnMesh(MeshFile("duck_642.obj") + ", refine: 2")).surface;
  EXPECT_EQ(fine.mesh->triangles.size(), 16u * coarse.triangles.size());
  EXPECT_FALSE(fine.interpolate);
  // Control points now, of the surface through the coarse points.
  const SurfaceSpec sphere = Parse(OnMesh(kIcosphere + std::string(", refine: 1"))).surface;
  EXPECT_EQ(sphere.mesh->vertices.size(), 10u * 36u + 2u);
  EXPECT_FALSE(sphere.interpolate);
}

TEST(SceneReaderTest, MeshesAreInTheFolderOfTheirScene) {
  const TemporaryFolder temporary("scene_reader_mesh");
  const std::string folder = temporary.path().string();
  std::filesystem::create_directories(folder + "/meshes");
  std::filesystem::copy_file(DARBOUX_DATA_DIR "/duck_642.obj",
                             folder + "/meshes/duck.obj",
                             std::filesystem::copy_options::overwrite_existing);
  const std::string file = folder + "/scene.yaml";
  std::ofstream(file) << OnMesh("kind: mesh, file: meshes/duck.obj");
  Scene scene;
  std::string error;
  EXPECT_TRUE(ReadScene(file, &scene, &error)) << error;
  ASSERT_NE(scene.surface.mesh, nullptr);
  EXPECT_EQ(scene.surface.mesh->vertices.size(), 642u);
  std::ofstream(file) << OnMesh("kind: mesh, file: duck.obj");
  EXPECT_FALSE(ReadScene(file, &scene, &error));
  EXPECT_THAT(error, StartsWith(file + ":2: surface.file: " + folder + "/duck.obj:0: found "));
}

TEST(SceneReaderTest, RepairMendsMeshesAndSaysSo) {
  ReadOptions options;
  options.repair = true;
  Scene scene;
  std::string error;
  ASSERT_TRUE(
      ParseScene(OnMesh(MeshFile("broken_meshes/seam.obj")), kFile, &scene, &error, options))
      << error;
  EXPECT_EQ(scene.surface.mesh->vertices.size(), 12u);
  ASSERT_EQ(scene.surface.mended.size(), 2u);
  EXPECT_EQ(scene.surface.mended[0],
            "mended " DARBOUX_DATA_DIR
            "/broken_meshes/seam.obj: sewed 2 vertices that coincide with others and leave a seam "
            "open: 6 (at 0), 13 (at 7)");
  EXPECT_FALSE(
      ParseScene(OnMesh(MeshFile("broken_meshes/bow_tie.obj")), kFile, &scene, &error, options));
  EXPECT_EQ(error,
            "roof.yaml:2: surface.file: found " DARBOUX_DATA_DIR
            "/broken_meshes/bow_tie.obj: 1 vertex where several fans of triangles meet in a point: "
            "0; allowed is a mesh without defects; --repair mends no more");
}

std::vector<Mistake> Mistakes() {
  const std::string kNoDefects = "; allowed is a mesh without defects; --repair mends some of them";
  const std::string kFolder = DARBOUX_DATA_DIR "/broken_meshes/";
  return {
      {"NoFile",
       OnMesh("kind: mesh"),
       "2: surface.file: found no such key, which is required; allowed the name of an .obj, .ply, "
       ".stl or .off file"},
      {"FileList",
       OnMesh("kind: mesh, file: [a.obj]"),
       "2: surface.file: found a list of 1; allowed the name of an .obj, .ply, .stl or .off file"},
      {"MissingFile",
       OnMesh(MeshFile("broken_meshes/missing.obj")),
       "2: surface.file: " + kFolder +
           "missing.obj:0: found a file that cannot be read (*); allowed a mesh file"},
      {"MissingFileInTheCurrentFolder",
       OnMesh("kind: mesh, file: missing.obj"),
       "2: surface.file: missing.obj:0: found a file that cannot be read (*); allowed a mesh file"},
      {"UnreadableFile",
       OnMesh(MeshFile("broken_meshes/index_too_large.obj")),
       "2: surface.file: " + kFolder +
           "index_too_large.obj:14: found vertex 7 in face 7; allowed 1 to 6"},
      {"NoMeshFile",
       OnMesh(MeshFile("README.md")),
       "2: surface.file: " DARBOUX_DATA_DIR
       "/README.md:0: found a name that ends with '.md'; allowed .obj | .ply | .stl | .off"},
      {"MeshSeam",
       OnMesh(MeshFile("broken_meshes/seam.obj")),
       "2: surface.file: found " + kFolder +
           "seam.obj: 2 vertices that coincide with others and leave a seam open: 6 (at 0), 13 (at "
           "7)" +
           kNoDefects},
      {"MeshEdge",
       OnMesh(MeshFile("broken_meshes/non_manifold_edge.ply")),
       "2: surface.file: found " + kFolder +
           "non_manifold_edge.ply: 1 edge with more than two triangles: 0-1 (triangles 0, 1, 2)" +
           kNoDefects},
      {"MeshPieces",
       OnMesh(MeshFile("broken_meshes/two_components.obj")),
       "2: surface.file: found " + kFolder +
           "two_components.obj: 2 separate pieces instead of 1: 8 triangles from triangle 0, 8 "
           "triangles from triangle 8" +
           kNoDefects},
      {"MeshTwoDefects",
       OnMesh(MeshFile("broken_meshes/crossing_along_edges.obj")),
       "2: surface.file: found " + kFolder +
           "crossing_along_edges.obj: 2 separate pieces instead of 1: 8 triangles from triangle 0, "
           "8 triangles from triangle 8; and 1 more defect" +
           kNoDefects},
      {"MeshDefectBeforeOtherSections",
       OnMesh(MeshFile("broken_meshes/inside_out.stl"), "probes: 3\n"),
       "2: surface.file: found " + kFolder +
           "inside_out.stl: 1 closed piece inside out, with normals that point inwards: 8 "
           "triangles "
           "from triangle 0" +
           kNoDefects},
      {"Fit",
       OnMesh(MeshFile("duck_642.obj") + ", fit: interpolated"),
       "2: surface.fit: found 'interpolated'; allowed control | interpolate; did you mean "
       "'interpolate'?"},
      {"RefineNegative",
       OnMesh(MeshFile("duck_642.obj") + ", refine: -1"),
       "2: surface.refine: found -1; allowed an integer from 0 to 6"},
      {"RefineTooOften",
       OnMesh(MeshFile("duck_642.obj") + ", refine: 7"),
       "2: surface.refine: found 7; allowed an integer from 0 to 6"},
      {"RefineReal",
       OnMesh(MeshFile("duck_642.obj") + ", refine: 0.5"),
       "2: surface.refine: found 0.5; allowed an integer from 0 to 6"},
      {"RefineTooLarge",
       OnMesh("kind: icosphere, radius: 1, frequency: 20, refine: 6"),
       "2: surface.refine: found 6, which makes 16384002 vertices; allowed at most 10000000 "
       "vertices"},
      {"FrequencyZero",
       OnMesh("kind: icosphere, radius: 1, frequency: 0"),
       "2: surface.frequency: found 0; allowed an integer from 1 to 400"},
      {"FrequencyTooLarge",
       OnMesh("kind: icosphere, radius: 1, frequency: 401"),
       "2: surface.frequency: found 401; allowed an integer from 1 to 400"},
      {"NoFrequency",
       OnMesh("kind: icosphere, radius: 1"),
       "2: surface.frequency: found no such key, which is required; allowed an integer from 1 to "
       "400"},
      {"IcosphereRadius",
       OnMesh("kind: icosphere, radius: 0, frequency: 3"),
       "2: surface.radius: found 0; allowed a number > 0"},
      {"FileOnAnIcosphere",
       OnMesh(std::string(kIcosphere) + ", file: a.obj"),
       "2: surface.file: found a key of kind mesh; allowed with kind icosphere: radius | frequency "
       "| kind | fit | refine | refine_near"},
      {"RefineNearNoList",
       OnMesh(std::string(kIcosphere) + ", refine_near: {near: [0, 0, 1], radius: 1, levels: 1}"),
       "2: surface.refine_near: found a map; allowed a list of {near: [x, y, z], radius: r, "
       "levels: "
       "n}"},
      {"RefineNearWithoutLevels",
       OnMesh(std::string(kIcosphere) + ", refine_near: [{near: [0, 0, 1], radius: 1}]"),
       "2: surface.refine_near[0].levels: found no such key, which is required; allowed an integer "
       "from 1 to 10"},
      {"RefineNearTooFine",
       OnMesh(std::string(kIcosphere) +
              ", refine_near: [{near: [0, 0, 1], radius: 1, levels: 11}]"),
       "2: surface.refine_near[0].levels: found 11; allowed an integer from 1 to 10"},
      {"RefineNearInside",
       OnMesh(std::string(kIcosphere) +
              ", refine_near: [{near: [0, 0, 1], radius: -1, levels: 1}]"),
       "2: surface.refine_near[0].radius: found -1; allowed a number >= 0"},
      {"DivisionsOnAMesh",
       OnMesh(MeshFile("duck_642.obj") + ", divisions: [4, 4]"),
       "2: surface.divisions: found an unknown key; allowed file | kind | fit | refine | "
       "refine_near"},
      {"NoFunction",
       Ball("function: x^2+y^2+z^2-1, ", ""),
       "2: surface.function: found no such key, which is required; allowed an expression of x, y "
       "and z"},
      {"FunctionOfU",
       Ball("x^2", "u^2"),
       "2: surface.function: found 'u^2+y^2+z^2-1' (*); allowed an expression of x, y and z"},
      {"FunctionNegativeOutside",
       Ball("x^2+y^2+z^2-1", "1-x^2-y^2-z^2"),
       "2: surface.function: the function is negative at the bounds, outside the closed surface; "
       "it has to be negative inside and positive outside: change its sign"},
      {"FunctionWithoutZero",
       Ball("z^2-1", "z^2+1"),
       "2: surface.function: the function has no zero within the bounds: it is positive at all of "
       "1331 points, nearest to zero with 1.00076 at (*); a surface needs both signs, and to be "
       "larger "
       "than the edge length 0.5"},
      {"NoBounds",
       Ball("bounds: [[-2, 2], [-2, 2], [-2, 2]], ", ""),
       "2: surface.bounds: found no such key, which is required; allowed a list of three ranges, "
       "[[x0, x1], [y0, y1], [z0, z1]]"},
      {"BoundsOfTwo",
       Ball("[-2, 2], [-2, 2]]", "[-2, 2]]"),
       "2: surface.bounds: found a list of 2; allowed a list of three ranges, [[x0, x1], [y0, y1], "
       "[z0, z1]]"},
      {"BoundsReversed",
       Ball("[-2, 2]]", "[2, -2]]"),
       "2: surface.bounds[2]: found [2, -2]; allowed a list of two ascending numbers, [lower, "
       "upper]"},
      {"BoundsTooNarrow",
       Ball("[-2, 2]]", "[-2, 0.5]]"),
       "2: surface.bounds: the surface leaves the bounds at (*) through the plane z = 0.5; allowed "
       "is a closed surface within the bounds, or open: true to cut it there"},
      {"EdgeLengthZero",
       Ball("edge_length: 0.5", "edge_length: 0"),
       "2: surface.edge_length: found 0; allowed a number > 0"},
      {"EdgeLengthTooLarge",
       Ball("edge_length: 0.5", "edge_length: 5"),
       "2: surface.edge_length: edge length 5; allowed is > 0 and at most the shortest side of the "
       "bounds, 4"},
      {"OpenNoBool",
       Ball("edge_length: 0.5", "edge_length: 0.5, open: 1"),
       "2: surface.open: found 1; allowed true | false"},
      {"ParametersOnAMesh",
       OnMesh(MeshFile("duck_642.obj"), "loads: [{kind: pressure, value: cos(u)}]\n"),
       "4: loads[0].value: found 'cos(u)', which names u or v; allowed a number or an expression "
       "of "
       "x, y, z, as surfaces of kind mesh have no parameters"},
      {"ParametersOnAnIcosphere",
       OnMesh(kIcosphere, "loads: [{kind: traction, force: [0, v, 0]}]\n"),
       "4: loads[0].force[1]: found 'v', which names u or v; allowed a number or an expression of "
       "x, "
       "y, z, as surfaces of kind icosphere have no parameters"},
      {"NotFiniteOnAnIcosphere",
       OnMesh(kIcosphere, "loads: [{kind: pressure, value: log(z)}]\n"),
       "4: loads[0].value: found 'log(z)', which is not finite at x = 0, y = -1.051, z = -1.701; "
       "allowed an expression that is finite wherever it acts"},
      {"UvOnAMesh",
       OnMesh(MeshFile("duck_642.obj"), "probes: [{name: a, at: {uv: [0, 0]}}]\n"),
       "4: probes[0].at.uv[0]: found the parameter u; allowed {nearest: [x, y, z]}, as surfaces of "
       "kind mesh have no parameters u and v"},
      {"LineOnAMesh",
       OnMesh(MeshFile("duck_642.obj"), "loads: [{kind: line, along: {v: 1}, force: [0, 0, 1]}]\n"),
       "4: loads[0].along.v: found the parameter v; allowed {nearest: [x, y, z]}, as surfaces of "
       "kind mesh have no parameters u and v"},
      {"SeedGhostsOnAMesh",
       OnMesh(MeshFile("duck_642.obj"), "model: {boundary_rule: seed_ghosts}\n"),
       "4: model.boundary_rule: found 'seed_ghosts' on a mesh; allowed independent, or a "
       "parametric "
       "surface"},
      {"SideOnAClosedMesh",
       OnMesh(MeshFile("duck_642.obj"), "supports: [{on: u_min, clamped: true}]\n"),
       "4: supports[0].on: found 'u_min', which surfaces of kind mesh do not have; allowed {near: "
       "[x, y, z], radius: r}"},
      {"RimOnAClosedMesh",
       OnMesh(MeshFile("duck_642.obj"), "supports: [{on: rim, clamped: true}]\n"),
       "4: supports[0].on: found 'rim', which a closed surface does not have; allowed {near: [x, "
       "y, "
       "z], radius: r}"},
      {"EdgeOnAClosedMesh",
       OnMesh(kIcosphere, "loads: [{kind: edge, on: rim, force: [0, 0, 1]}]\n"),
       "4: loads[0].on: found 'rim', which a closed surface does not have; allowed no edge, as the "
       "surface is closed"},
      {"SideOnAnOpenMesh",
       OnMesh(MeshFile("broken_meshes/quad_not_planar.obj"),
              "supports: [{on: v_max, clamped: true}]\n"),
       "4: supports[0].on: found 'v_max', which surfaces of kind mesh do not have; allowed rim | "
       "{near: [x, y, z], radius: r}"},
  };
}

class SceneReaderMistakeTest : public ::testing::TestWithParam<Mistake> {};

TEST_P(SceneReaderMistakeTest, IsReportedWithPlaceAndRemedy) { ExpectMessage(GetParam()); }

INSTANTIATE_TEST_SUITE_P(Mesh, SceneReaderMistakeTest, ::testing::ValuesIn(Mistakes()), NameOf);

}  // namespace
}  // namespace darboux
