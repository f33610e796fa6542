#include "solver/results.h"

#include <sys/resource.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <csignal>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "solver/accuracy.h"
#include "solver/fields.h"
#include "solver/scene_reader.h"
#include "solver/shell_problem.h"
#include "solver/shell_solver.h"
#include "tests/temporary_folder.h"
#include "tests/vtu_util.h"

namespace darboux {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr char kPlate[] = R"(
name: clamped-plate
surface: {kind: plane, u: [0, 100], v: [0, 100], divisions: [16, 16]}
shell: {thickness: 1, young_modulus: 1.0e7, poisson_ratio: 0.3}
model: {theory: linear}
supports: [{on: rim, clamped: true}]
loads: [{kind: normal_traction, value: 1}]
probes: [{name: centre, at: {uv: [50, 50]}}, {name: quarter, at: {uv: [25, 50]}}]
)";

constexpr char kTube[] = R"(
name: tube
surface:
  {kind: cylinder, radius: 50, u: [0, 100], v: [0, 6.283185307179586], divisions: [3, 8],
   periodic: [false, true]}
shell: {thickness: 1, young_modulus: 1.0e5, poisson_ratio: 0.3}
model: {theory: linear}
supports: [{on: u_min, clamped: true}]
loads: [{kind: traction, force: [0, 0, -0.001]}]
steps: 3
probes: [{name: tip, at: {uv: [100, 0]}}]
)";

constexpr char kTorus[] = R"(
name: torus
surface:
  {kind: torus, radii: [3, 1], u: [0, 6.283185307179586], v: [0, 6.283185307179586],
   divisions: [8, 6], periodic: [true, true]}
shell: {thickness: 0.1, young_modulus: 1.0, poisson_ratio: 0.3}
model: {theory: linear}
)";

Scene SceneOf(const std::string& text) {
  Scene scene;
  std::string error;
  EXPECT_TRUE(ParseScene(text, "test.yaml", &scene, &error)) << error;
  return scene;
}

std::unique_ptr<ShellProblem> ProblemOf(const Scene& scene, bool nonlinear = false) {
  ShellProblem::Options options;
  options.nonlinear = nonlinear;
  std::string error;
  std::unique_ptr<ShellProblem> problem = ShellProblem::Create(scene, options, &error);
  EXPECT_NE(problem, nullptr) << error;
  return problem;
}

struct Solved {
  std::unique_ptr<ShellProblem> problem;
  SolverSummary summary;
};

Solved SolveScene(const Scene& scene) {
  Solved solved;
  std::string error;
  EXPECT_TRUE(Solve(scene, SolverOptions(), &solved.problem, &solved.summary, &error)) << error;
  return solved;
}

class ResultsTest : public FolderTest {
 protected:
  Results Write(const Solved& solved) {
    Results results;
    std::string error;
    EXPECT_TRUE(WriteResults(Out(), *solved.problem, solved.summary, nullptr, &results, &error))
        << error;
    return results;
  }
  std::string Out() const { return (folder_ / "a" / "b").string(); }
};

// ---- Readers of the written files -----------------------------------------------------------

struct Ply {
  std::vector<std::array<double, 6>> vertices;
  std::vector<std::array<std::int32_t, 3>> faces;
};

Ply ReadPly(const fs::path& path) {
  const std::string bytes = ReadFile(path);
  std::istringstream header(bytes);
  std::string line, word;
  size_t num_vertices = 0, num_faces = 0;
  while (std::getline(header, line) && line != "end_header") {
    std::istringstream words(line);
    words >> word;
    if (word != "element") continue;
    words >> word;
    words >> (word == "vertex" ? num_vertices : num_faces);
  }
  Ply ply;
  size_t at = static_cast<size_t>(header.tellg());
  EXPECT_EQ(bytes.size() - at, num_vertices * 6 * 8 + num_faces * 13);
  for (size_t i = 0; i < num_vertices; ++i) {
    std::array<double, 6> vertex;
    for (double& value : vertex) {
      value = ValueAt<double>(bytes, at);
      at += 8;
    }
    ply.vertices.push_back(vertex);
  }
  for (size_t i = 0; i < num_faces; ++i) {
    EXPECT_EQ(ValueAt<std::uint8_t>(bytes, at), 3);
    ply.faces.push_back({ValueAt<std::int32_t>(bytes, at + 1),
                         ValueAt<std::int32_t>(bytes, at + 5),
                         ValueAt<std::int32_t>(bytes, at + 9)});
    at += 13;
  }
  return ply;
}

std::vector<std::vector<std::string>> ReadCsv(const fs::path& path) {
  std::istringstream text(ReadFile(path));
  std::vector<std::vector<std::string>> rows;
  for (std::string line; std::getline(text, line);) {
    rows.emplace_back();
    std::istringstream cells(line + ",");
    for (std::string cell; std::getline(cells, cell, ',');) rows.back().push_back(cell);
  }
  return rows;
}

// ---- Fields ---------------------------------------------------------------------------------

// Sets the control displacements of a plate to samples of f: the limit of the samples of a linear
// function is the function, that of a quadratic one has its second derivatives.
void SetDisplacement(const std::function<Eigen::Vector3d(double, double)>& f,
                     ShellProblem* problem) {
  const ParameterDomain& domain = problem->surface().domain();
  const auto& divisions = domain.options().divisions;
  for (int j = -1; j <= divisions[1] + 1; ++j) {
    for (int i = -1; i <= divisions[0] + 1; ++i) {
      const int vertex = domain.VertexIndex(i, j);
      if (vertex < 0) continue;
      problem->displacements().col(vertex) =
          f(domain.Parameter(0, i)[0], domain.Parameter(1, j)[0]);
    }
  }
}

TEST(FieldsTest, UniformStretchGivesPlaneStress) {
  const std::unique_ptr<ShellProblem> problem = ProblemOf(SceneOf(kPlate));
  SetDisplacement(
      [](double x, double y) {
        return Eigen::Vector3d(1e-3 * x + 4e-4 * y, 2e-4 * x - 5e-4 * y, 0.0);
      },
      problem.get());
  const ShellFields fields = EvaluateFields(*problem, ElementPoint{37, 0.2, 0.3});
  const double e11 = 1e-3, e22 = -5e-4, e12 = 3e-4, nu = 0.3, E = 1e7;
  EXPECT_TRUE(fields.membrane_strain.isApprox(Eigen::Vector3d(e11, e22, e12), 1e-10));
  const double s11 = E / (1.0 - nu * nu) * (e11 + nu * e22);
  const double s22 = E / (1.0 - nu * nu) * (e22 + nu * e11);
  const double s12 = E / (1.0 + nu) * e12;
  EXPECT_TRUE(fields.membrane_force.isApprox(Eigen::Vector3d(s11, s22, s12), 1e-10));  // h = 1
  const double von_mises = std::sqrt(s11 * s11 - s11 * s22 + s22 * s22 + 3.0 * s12 * s12);
  EXPECT_NEAR(fields.von_mises_top, von_mises, 1e-9 * von_mises);
  EXPECT_NEAR(fields.von_mises_bottom, von_mises, 1e-9 * von_mises);
  const double density = 0.5 * (s11 * e11 + s22 * e22 + 2.0 * s12 * e12);
  EXPECT_NEAR(fields.membrane_energy_density, density, 1e-9 * density);
  const double largest = 0.5 * (e11 + e22) + std::hypot(0.5 * (e11 - e22), e12);
  EXPECT_NEAR(fields.principal_membrane_strain[0], largest, 1e-12);
  EXPECT_LT(fields.moment.norm(), 1e-6);
}

TEST(FieldsTest, CurlingTowardsTheNormalCompressesTheTopFace) {
  const std::unique_ptr<ShellProblem> problem = ProblemOf(SceneOf(kPlate));
  // w_xx = kappa, and the stretch that takes the strain h/2 kappa of the top face away.
  const double kappa = 1e-5, h = 1.0, nu = 0.3, E = 1e7;
  SetDisplacement(
      [=](double x, double) {
        return Eigen::Vector3d(0.5 * h * kappa * x, 0.0, 0.5 * kappa * x * x);
      },
      problem.get());
  const ShellFields fields = EvaluateFields(*problem, ElementPoint{101, 0.4, 0.1});
  EXPECT_NEAR(fields.bending_strain[0], kappa, 1e-9 * kappa);
  const double D = E * h * h * h / (12.0 * (1.0 - nu * nu));
  EXPECT_NEAR(fields.moment[0], D * kappa, 1e-8 * D * kappa);
  EXPECT_NEAR(fields.moment[1], nu * D * kappa, 1e-8 * D * kappa);
  EXPECT_NEAR(fields.bending_energy_density, 0.5 * D * kappa * kappa, 1e-8 * D * kappa * kappa);
  const double s11 = E / (1.0 - nu * nu) * h * kappa, s22 = nu * s11;
  const double bottom = std::sqrt(s11 * s11 - s11 * s22 + s22 * s22);
  EXPECT_NEAR(fields.von_mises_bottom, bottom, 1e-8 * bottom);
  EXPECT_NEAR(fields.von_mises_top, 0.0, 1e-8 * bottom);
}

TEST(FieldsTest, EnergyDensitiesIntegrateToTheEnergy) {
  const Solved solved = SolveScene(SceneOf(kTube));
  const ShellSurface& surface = solved.problem->surface();
  double membrane = 0.0, bending = 0.0;
  for (int e = 0; e < surface.num_elements(); ++e) {
    // The three-point rule of the scene.
    for (const auto& st : {std::pair(1.0 / 6.0, 1.0 / 6.0),
                           std::pair(2.0 / 3.0, 1.0 / 6.0),
                           std::pair(1.0 / 6.0, 2.0 / 3.0)}) {
      const ElementPoint at{e, st.first, st.second};
      const ShellFields fields = EvaluateFields(*solved.problem, at);
      const double area = surface.MakePoint(at, 1.0 / 6.0).area;
      membrane += area * fields.membrane_energy_density;
      bending += area * fields.bending_energy_density;
    }
  }
  EXPECT_NEAR(membrane, solved.problem->Energy(Effect::kMembrane), 1e-9 * membrane);
  EXPECT_NEAR(bending, solved.problem->Energy(Effect::kBending), 1e-9 * bending);
}

TEST(FieldsTest, RigidRotationTurnsTheNormalAndStressesNothing) {
  const std::unique_ptr<ShellProblem> problem = ProblemOf(SceneOf(kPlate), true);
  const Eigen::Matrix3d r =
      Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix();
  SetDisplacement(
      [&](double x, double y) {
        const Eigen::Vector3d at(x, y, 0.0);
        return Eigen::Vector3d(r * at - at);
      },
      problem.get());
  const ShellFields fields = EvaluateFields(*problem, ElementPoint{11, 0.0, 0.0});
  EXPECT_LT((fields.normal - r.col(2)).norm(), 1e-12);
  EXPECT_LT(fields.von_mises_top, 1e-6);  // E = 1e7
}

TEST(FieldsTest, SiteKnowsTheCurvaturesOfTheRestSurface) {
  const std::unique_ptr<ShellProblem> tube = ProblemOf(SceneOf(kTube));
  const FieldSite site = MakeFieldSite(tube->surface(), {5, 0.3, 0.3});
  EXPECT_NEAR(site.principal_curvatures[0], 0.0, 1e-15);
  EXPECT_NEAR(site.principal_curvatures[1], -1.0 / 50.0, 1e-15);  // n is outward.
  EXPECT_NEAR(std::abs(site.principal_direction_1.x()), 1.0, 1e-12);
}

TEST(FieldsTest, StateThatIsNotFiniteHasTheRestNormal) {
  const std::unique_ptr<ShellProblem> problem = ProblemOf(SceneOf(kPlate), true);
  problem->displacements().setConstant(std::numeric_limits<double>::quiet_NaN());
  const ShellFields fields = EvaluateFields(*problem, ElementPoint{11, 0.5, 0.25});
  EXPECT_EQ(fields.normal, Eigen::Vector3d::UnitZ());
  EXPECT_TRUE(std::isnan(fields.bending_strain[0]));
}

// Edges by how many triangles share them.
std::map<int, int> EdgeUse(const OutputMesh& mesh) {
  std::map<std::pair<int, int>, int> edges;
  for (const auto& t : mesh.triangles) {
    for (int k = 0; k < 3; ++k) ++edges[std::minmax({t[k], t[(k + 1) % 3]})];
  }
  std::map<int, int> use;
  for (const auto& edge : edges) ++use[edge.second];
  return use;
}

TEST(OutputMeshTest, PeriodicDirectionsCloseWithoutSeam) {
  const std::unique_ptr<ShellProblem> torus = ProblemOf(SceneOf(kTorus));
  const OutputMesh mesh = MakeOutputMesh(torus->surface());
  EXPECT_EQ(mesh.points.size(), 16u * 12u);
  EXPECT_EQ(mesh.triangles.size(), 4u * 96u);
  EXPECT_EQ(EdgeUse(mesh), (std::map<int, int>{{2, 576}}));
  std::vector<Eigen::Vector3d> positions;
  for (const ElementPoint& at : mesh.points) positions.push_back(torus->surface().Position(at));
  for (size_t i = 0; i < positions.size(); ++i) {
    for (size_t k = 0; k < i; ++k) EXPECT_GT((positions[i] - positions[k]).norm(), 0.1);
  }
}

TEST(OutputMeshTest, OpenSidesAreTheOnlyBoundaryAndTrianglesFaceTheNormal) {
  const std::unique_ptr<ShellProblem> tube = ProblemOf(SceneOf(kTube));
  const ShellSurface& surface = tube->surface();
  const OutputMesh mesh = MakeOutputMesh(surface);
  EXPECT_EQ(mesh.points.size(), 7u * 16u);
  EXPECT_EQ(EdgeUse(mesh)[1], 2 * 16);
  for (const auto& t : mesh.triangles) {
    Eigen::Vector3d x[3];
    for (int k = 0; k < 3; ++k) x[k] = surface.Position(mesh.points[t[k]]);
    const Eigen::Vector3d normal = (x[1] - x[0]).cross(x[2] - x[0]);
    const Eigen::Vector3d middle = (x[0] + x[1] + x[2]) / 3.0;
    EXPECT_GT(normal.dot(Eigen::Vector3d(0.0, middle.y(), middle.z())), 0.0);
  }
}

// ---- summary.json ---------------------------------------------------------------------------

TEST_F(ResultsTest, SummaryHasTheKeysOfTheContractInItsOrder) {
  const Solved solved = SolveScene(SceneOf(kPlate));
  Write(solved);
  const Json json = Json::parse(ReadFile(fs::path(Out()) / "summary.json"));
  std::vector<std::string> keys;
  for (const auto& item : json.items()) keys.push_back(item.key());
  EXPECT_THAT(keys,
              ElementsAre("name",
                          "converged",
                          "message",
                          "theory",
                          "theory_reason",
                          "nonlinearity_estimate",
                          "strains",
                          "backend",
                          "dof",
                          "unknowns",
                          "elements",
                          "quadrature_points",
                          "effects",
                          "energy",
                          "probes",
                          "fingers",
                          "grasp",
                          "supports",
                          "gas",
                          "max_displacement",
                          "max_membrane_strain",
                          "max_rotation",
                          "equilibrium",
                          "iterations",
                          "load_steps",
                          "limit_points",
                          "stability",
                          "resolution",
                          "free_motions",
                          "decisions",
                          "kept_factors",
                          "time_s",
                          "expect"));
  for (const char* effect :
       {"membrane", "bending", "geometric_nonlinearity", "contact", "friction", "gas", "gravity"}) {
    EXPECT_TRUE(json["effects"][effect]["on"].is_boolean()) << effect;
    EXPECT_TRUE(json["effects"][effect]["why"].is_string()) << effect;
    EXPECT_TRUE(json["effects"][effect]["residual_blocks"].is_number_integer()) << effect;
    EXPECT_TRUE(json["effects"][effect]["residuals"].is_number_integer()) << effect;
  }
  for (const char* energy :
       {"membrane", "bending", "gas", "contact", "supports", "load_work", "total"}) {
    EXPECT_TRUE(json["energy"][energy].is_number()) << energy;
  }
  EXPECT_EQ(json["name"], "clamped-plate");
  EXPECT_EQ(json["converged"], true);
  EXPECT_EQ(json["theory"], "linear");
  EXPECT_EQ(json["strains"], "koiter");
  EXPECT_EQ(json["dof"], 1077);
  EXPECT_EQ(json["elements"], 512);
  EXPECT_EQ(json["quadrature_points"], 1536);
  EXPECT_EQ(json["probes"]["centre"]["position"], Json({50.0, 50.0, 0.0}));
  // Timoshenko & Woinowsky-Krieger (1959), Table 35: 0.00126 q a^4 / D; series 0.001265319.
  EXPECT_NEAR(json["probes"]["centre"]["displacement"]["z"].get<double>(), 0.13817, 2e-5);
  EXPECT_NEAR(json["supports"]["reaction"]["z"].get<double>(), -1e4, 1e-2);
  EXPECT_EQ(json["fingers"], Json::object());
  EXPECT_EQ(json["gas"]["gauge_pressure"], 0.0);
  EXPECT_EQ(json["gas"]["volume"], 0.0);
  EXPECT_EQ(json["gas"]["volume_ratio"], 1.0);
  EXPECT_TRUE(json["equilibrium"]["gradient_norm"].is_number());
  EXPECT_TRUE(json["equilibrium"]["force_balance"].is_number());
  EXPECT_EQ(json["load_steps"].size(), 1u);
  EXPECT_EQ(json["load_steps"][0]["factor"], 1.0);
  EXPECT_TRUE(json["load_steps"][0]["iterations"].is_number_integer());
  const Json& time = json["time_s"];
  EXPECT_NEAR(
      time["total"].get<double>(),
      time["setup"].get<double>() + time["solve"].get<double>() + time["output"].get<double>(),
      1e-12);
}

TEST_F(ResultsTest, NumbersThatAreNotFiniteBecomeNullAndNotConverged) {
  Solved solved = SolveScene(SceneOf(kTube));
  const double nan = std::numeric_limits<double>::quiet_NaN();
  solved.summary.steps[2].displacements(1, 7) = nan;
  solved.summary.steps[2].energy = nan;
  solved.summary.steps[2].probe_displacements[0].x() = nan;
  solved.summary.max_rotation = std::numeric_limits<double>::infinity();
  const Results results = Write(solved);
  EXPECT_FALSE(results.converged);
  const std::string text = ReadFile(fs::path(Out()) / "summary.json");
  EXPECT_EQ(text.find("nan"), std::string::npos);
  const Json json = Json::parse(text);
  EXPECT_EQ(json["converged"], false);
  EXPECT_TRUE(json["max_rotation"].is_null());
  EXPECT_TRUE(json["load_steps"][2]["energy"].is_null());
  EXPECT_THAT(json["message"].get<std::string>(), HasSubstr("not finite"));
  // ReadVtu and these check that all is finite; the last good state stands for the final one.
  EXPECT_EQ(ReadVtu(fs::path(Out()) / "shell_0003.vtu").num_points, 112u);
  EXPECT_EQ(ReadVtu(fs::path(Out()) / "shell.vtu").arrays["displacement"],
            ReadVtu(fs::path(Out()) / "shell_0002.vtu").arrays["displacement"]);
  for (const auto& vertex : ReadPly(fs::path(Out()) / "deformed.ply").vertices) {
    for (const double value : vertex) EXPECT_TRUE(std::isfinite(value));
  }
  EXPECT_EQ(ReadCsv(fs::path(Out()) / "history.csv")[3][7], "");
}

TEST_F(ResultsTest, RunWithoutAStepWritesTheRestState) {
  Solved solved = SolveScene(SceneOf(kTube));
  solved.summary = SolverSummary();
  const Results results = Write(solved);
  EXPECT_FALSE(results.converged);
  EXPECT_EQ(results.summary["effects"]["membrane"]["why"], "not run");
  const Vtu vtu = ReadVtu(fs::path(Out()) / "shell.vtu");
  EXPECT_EQ(vtu.arrays.at("displacement"), std::vector<double>(3 * vtu.num_points, 0.0));
}

TEST(SummaryJsonTest, InfiniteNonlinearityEstimateIsNoFailure) {
  SolverSummary summary;
  summary.termination = SolverSummary::Termination::kConverged;
  summary.nonlinearity_estimate = std::numeric_limits<double>::infinity();
  const Json json = MakeSummaryJson(SceneOf(kPlate), summary, nullptr);
  EXPECT_EQ(json["converged"], true);
  EXPECT_TRUE(json["nonlinearity_estimate"].is_null());
}

// ---- Files ----------------------------------------------------------------------------------

TEST_F(ResultsTest, VtuFilesAreWellFormedAndHoldTheFields) {
  const Solved solved = SolveScene(SceneOf(kTube));
  Write(solved);
  const ShellSurface& surface = solved.problem->surface();
  const OutputMesh mesh = MakeOutputMesh(surface);
  for (const char* name : {"shell_0001.vtu", "shell_0002.vtu", "shell_0003.vtu", "shell.vtu"}) {
    const Vtu vtu = ReadVtu(fs::path(Out()) / name);
    EXPECT_EQ(vtu.num_points, mesh.points.size());
    EXPECT_EQ(vtu.num_cells, mesh.triangles.size());
    const std::map<std::string, int> expected = {{"displacement", 3},
                                                 {"membrane_strain", 3},
                                                 {"bending_strain", 3},
                                                 {"membrane_force", 3},
                                                 {"moment", 3},
                                                 {"von_mises_top", 1},
                                                 {"von_mises_bottom", 1},
                                                 {"energy_density", 1},
                                                 {"principal_curvatures", 2},
                                                 {"normal", 3},
                                                 {"uv", 2}};
    for (const auto& [array, components] : expected) {
      ASSERT_EQ(vtu.components.count(array), 1u) << array;
      EXPECT_EQ(vtu.components.at(array), components) << array;
    }
  }
  const Vtu vtu = ReadVtu(fs::path(Out()) / "shell.vtu");
  EXPECT_EQ(vtu.arrays.at("TimeValue"), std::vector<double>{1.0});
  for (size_t i = 0; i < mesh.points.size(); ++i) {
    const ShellFields fields = EvaluateFields(*solved.problem, mesh.points[i]);
    for (int k = 0; k < 3; ++k) {
      EXPECT_EQ(vtu.arrays.at("Points")[3 * i + k], fields.position[k]);
      EXPECT_EQ(vtu.arrays.at("displacement")[3 * i + k], fields.displacement[k]);
      EXPECT_EQ(vtu.arrays.at("moment")[3 * i + k], fields.moment[k]);
    }
    EXPECT_EQ(vtu.arrays.at("von_mises_top")[i], fields.von_mises_top);
  }
}

TEST_F(ResultsTest, PvdListsOneFilePerStep) {
  Write(SolveScene(SceneOf(kTube)));
  std::vector<std::string> files, times;
  for (const XmlElement& element : ScanXml(ReadFile(fs::path(Out()) / "shell.pvd"))) {
    if (element.path != "VTKFile/Collection/DataSet") continue;
    files.push_back(element.attributes.at("file"));
    times.push_back(element.attributes.at("timestep"));
    EXPECT_TRUE(fs::exists(fs::path(Out()) / files.back()));
  }
  EXPECT_THAT(files, ElementsAre("shell_0001.vtu", "shell_0002.vtu", "shell_0003.vtu"));
  EXPECT_THAT(times, ElementsAre("0.3333333333333333", "0.6666666666666666", "1"));
}

TEST_F(ResultsTest, PlyHoldsTheDeformedSurface) {
  const Solved solved = SolveScene(SceneOf(kTube));
  Write(solved);
  const OutputMesh mesh = MakeOutputMesh(solved.problem->surface());
  const Ply ply = ReadPly(fs::path(Out()) / "deformed.ply");
  ASSERT_EQ(ply.vertices.size(), mesh.points.size());
  for (size_t i = 0; i < mesh.points.size(); ++i) {
    const ShellFields fields = EvaluateFields(*solved.problem, mesh.points[i]);
    for (int k = 0; k < 3; ++k) {
      EXPECT_EQ(ply.vertices[i][k], fields.position[k] + fields.displacement[k]);
      EXPECT_EQ(ply.vertices[i][3 + k], fields.normal[k]);
    }
  }
  ASSERT_EQ(ply.faces.size(), mesh.triangles.size());
  for (size_t i = 0; i < ply.faces.size(); ++i) EXPECT_EQ(ply.faces[i], mesh.triangles[i]);
}

TEST_F(ResultsTest, HistoryHasARowPerStepAndColumnsNamedLikeTheSummary) {
  const Solved solved = SolveScene(SceneOf(kTube));
  const Results results = Write(solved);
  const auto rows = ReadCsv(fs::path(Out()) / "history.csv");
  ASSERT_EQ(rows.size(), 4u);
  EXPECT_THAT(rows[0],
              ElementsAre("step",
                          "factor",
                          "iterations",
                          "converged",
                          "energy",
                          "relative_gradient",
                          "max_displacement",
                          "probes.tip.displacement.x",
                          "probes.tip.displacement.y",
                          "probes.tip.displacement.z",
                          "supports.reaction.x",
                          "supports.reaction.y",
                          "supports.reaction.z",
                          "negative_modes",
                          "limit_point"));
  for (size_t i = 1; i < rows.size(); ++i) {
    ASSERT_EQ(rows[i].size(), rows[0].size());
    EXPECT_EQ(rows[i][0], std::to_string(i));
    EXPECT_EQ(rows[i][3], "1");
  }
  EXPECT_EQ(std::stod(rows[3][9]),
            results.summary["probes"]["tip"]["displacement"]["z"].get<double>());
  EXPECT_EQ(std::stod(rows[3][12]), results.summary["supports"]["reaction"]["z"].get<double>());
}

TEST_F(ResultsTest, RunWithFewerStepsLeavesNoneOfAnEarlierRun) {
  Scene scene = SceneOf(kTube);
  Write(SolveScene(scene));
  for (const char* name : {"shell_notes.vtu", "shell_12.vtu", "shell_0003.txt", "mine.txt"}) {
    std::ofstream(fs::path(Out()) / name) << "kept";
  }
  scene.steps = 1;
  Write(SolveScene(scene));
  EXPECT_THAT(FilesIn(Out()),
              ElementsAre("deformed.ply",
                          "history.csv",
                          "mine.txt",
                          "shell.pvd",
                          "shell.vtu",
                          "shell_0001.vtu",
                          "shell_0003.txt",
                          "shell_12.vtu",
                          "shell_notes.vtu",
                          "summary.json"));
  EXPECT_EQ(ReadCsv(fs::path(Out()) / "history.csv").size(), 2u);
}

TEST_F(ResultsTest, FolderThatCannotBeIsAnErrorAndNothingIsWritten) {
  std::ofstream(folder_ / "file") << "text";
  const Solved solved = SolveScene(SceneOf(kTube));
  Results results;
  std::string error;
  const std::string below = (folder_ / "file" / "out").string();
  EXPECT_FALSE(IsWritableFolder(below, &error));
  EXPECT_THAT(error, HasSubstr("is no folder"));
  error.clear();
  EXPECT_FALSE(WriteResults(below, *solved.problem, solved.summary, nullptr, &results, &error));
  EXPECT_THAT(error, HasSubstr("is no folder"));
  EXPECT_FALSE(IsWritableFolder("", &error));
  EXPECT_TRUE(IsWritableFolder((folder_ / "x" / "y" / "z").string(), &error));
  EXPECT_TRUE(IsWritableFolder("relative_folder_that_is_not_there/", &error)) << error;
  EXPECT_THAT(FilesIn(folder_), ElementsAre("file"));
}

TEST_F(ResultsTest, FolderInPlaceOfAFileIsAnErrorAndNothingIsReplaced) {
  const Solved solved = SolveScene(SceneOf(kTube));
  fs::create_directories(fs::path(Out()) / "summary.json" / "inside");
  Results results;
  std::string error;
  EXPECT_FALSE(WriteResults(Out(), *solved.problem, solved.summary, nullptr, &results, &error));
  EXPECT_THAT(error, HasSubstr("summary.json"));
  EXPECT_THAT(FilesIn(Out()), ElementsAre("summary.json"));
}

TEST_F(ResultsTest, FullDiskLeavesTheEarlierResultsAsTheyWere) {
  Scene scene = SceneOf(kTube);
  Write(SolveScene(scene));
  std::map<std::string, std::string> before;
  for (const std::string& name : FilesIn(Out())) before[name] = ReadFile(fs::path(Out()) / name);

  scene.loads.clear();
  const Solved solved = SolveScene(scene);
  rlimit old_limit;
  ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &old_limit), 0);
  rlimit limit = old_limit;
  limit.rlim_cur = 10000;  // bytes; a .vtu has more
  const auto old_handler = std::signal(SIGXFSZ, SIG_IGN);
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &limit), 0);
  Results results;
  std::string error;
  const bool written =
      WriteResults(Out(), *solved.problem, solved.summary, nullptr, &results, &error);
  setrlimit(RLIMIT_FSIZE, &old_limit);
  std::signal(SIGXFSZ, old_handler);
  EXPECT_FALSE(written);
  EXPECT_THAT(error, HasSubstr("cannot be written: File too large"));

  std::map<std::string, std::string> after;
  for (const std::string& name : FilesIn(Out())) after[name] = ReadFile(fs::path(Out()) / name);
  EXPECT_TRUE(before == after);
}

// ---- Expectations ---------------------------------------------------------------------------

class ExpectationsTest : public ::testing::Test {
 protected:
  ExpectResult Evaluate(const std::string& quantity,
                        double value = 1.0,
                        std::optional<double> relative = 0.0,
                        std::optional<double> absolute = {}) {
    Scene scene;
    ExpectSpec expect;
    expect.quantity = quantity;
    expect.value = value;
    expect.relative_tolerance = relative;
    expect.absolute_tolerance = absolute;
    scene.expect = {expect};
    std::vector<ExpectResult> results;
    const bool all_hold = EvaluateExpectations(scene, json_, &results);
    EXPECT_EQ(results.size(), 1u);
    EXPECT_EQ(all_hold, results.at(0).holds);
    return results[0];
  }

  Json json_ = Json::parse(R"({"converged": true, "dof": 12, "bad": null, "name": "n",
      "probes": {"a": {"position": [1, 2.5, 3], "displacement": {"x": -2}}},
      "load_steps": [{"factor": 0.5}, {"factor": 1.0}], "table": [[1, 2], [3, 4]]})");
};

TEST_F(ExpectationsTest, PathsLeadThroughKeysAndIndices) {
  EXPECT_TRUE(Evaluate("probes.a.displacement.x", -2.0).holds);
  EXPECT_TRUE(Evaluate("probes.a.position[1]", 2.5).holds);
  EXPECT_TRUE(Evaluate("load_steps[1].factor", 1.0).holds);
  EXPECT_TRUE(Evaluate("table[1][0]", 3.0).holds);
  EXPECT_TRUE(Evaluate("dof", 12).holds);
  EXPECT_TRUE(Evaluate("converged", 1.0).holds);
}

TEST_F(ExpectationsTest, ToleranceIsRelativeToTheExpectedValueOrAbsolute) {
  EXPECT_TRUE(Evaluate("dof", 10.0, 0.2).holds);
  EXPECT_FALSE(Evaluate("dof", 10.0, 0.19).holds);
  EXPECT_DOUBLE_EQ(*Evaluate("dof", 10.0, 0.19).error, 0.2);
  EXPECT_TRUE(Evaluate("dof", 10.0, {}, 2.0).holds);
  EXPECT_FALSE(Evaluate("dof", 10.0, {}, 1.9).holds);
  EXPECT_DOUBLE_EQ(*Evaluate("dof", 10.0, {}, 1.9).error, 2.0);
  EXPECT_TRUE(Evaluate("probes.a.displacement.x", -2.1, 0.05).holds);
  EXPECT_FALSE(Evaluate("dof", 0.0, 0.5).holds);
}

TEST_F(ExpectationsTest, WhatIsNotThereDoesNotHoldAndSaysWhatIs) {
  const ExpectResult result = Evaluate("probes.b.displacement.x", -2.0, 10.0);
  EXPECT_FALSE(result.holds);
  EXPECT_FALSE(result.value.has_value());
  EXPECT_EQ(result.message, "no 'b' in probes, which has the keys a");
  EXPECT_THAT(Evaluate("probs").message, HasSubstr("the keys converged, dof, bad, name, probes"));
  EXPECT_THAT(Evaluate("load_steps[2].factor").message,
              HasSubstr("no '[2]' in load_steps, which has an array of 2"));
  EXPECT_THAT(Evaluate("dof.x").message, HasSubstr("a number"));
  EXPECT_THAT(Evaluate("dof[0]").message, HasSubstr("a number"));
  EXPECT_THAT(Evaluate("bad").message, HasSubstr("null"));
  EXPECT_THAT(Evaluate("name").message, HasSubstr("no number"));
  EXPECT_THAT(Evaluate("probes").message, HasSubstr("no number"));
  for (const char* path : {"",
                           ".",
                           "dof.",
                           "load_steps[",
                           "load_steps[]",
                           "load_steps[1",
                           "load_steps[-1].factor",
                           "load_steps[0]factor",
                           "load_steps]0["}) {
    EXPECT_FALSE(Evaluate(path).holds) << path;
    EXPECT_NE(Evaluate(path).message, "") << path;
  }
}

TEST_F(ResultsTest, ExpectationsAreWrittenWithTheirErrors) {
  const Solved solved = SolveScene(SceneOf(std::string(kPlate) + R"(
expect:
  - {quantity: probes.centre.displacement.z, value: 0.13817, relative_tolerance: 0.001}
  - {quantity: max_displacement, value: 1, absolute_tolerance: 0.5}
  - {quantity: "load_steps[7].factor", value: 1, absolute_tolerance: 0.5}
)"));
  const Results results = Write(solved);
  EXPECT_TRUE(results.converged);
  EXPECT_FALSE(results.expectations_hold);
  const Json json = Json::parse(ReadFile(fs::path(Out()) / "summary.json"));
  ASSERT_EQ(json["expect"].size(), 3u);
  EXPECT_EQ(json["expect"][0]["holds"], true);
  EXPECT_EQ(json["expect"][0]["expected"], 0.13817);
  EXPECT_LT(json["expect"][0]["error"].get<double>(), 1e-3);
  EXPECT_EQ(json["expect"][1]["holds"], false);
  EXPECT_EQ(json["expect"][2]["holds"], false);
  EXPECT_TRUE(json["expect"][2]["value"].is_null());
  EXPECT_THAT(json["expect"][2]["message"].get<std::string>(), HasSubstr("an array of 1"));
}

// ---- Accuracy -------------------------------------------------------------------------------

TEST_F(ResultsTest, SummaryReportsTheAccuracy) {
  Scene scene = SceneOf(kPlate);
  scene.model.accuracy = 0.01;
  std::unique_ptr<ShellProblem> problem;
  SolverSummary summary;
  AccuracyReport report;
  Results results;
  std::string error;
  ASSERT_TRUE(SolveToAccuracy(scene, {}, {}, &problem, &summary, &report, &error)) << error;
  ASSERT_TRUE(WriteResults(Out(), *problem, summary, &report, &results, &error)) << error;
  const Json json = Json::parse(ReadFile(fs::path(Out()) / "summary.json"))["accuracy"];
  EXPECT_EQ(json["target"], 0.01);
  EXPECT_LE(json["estimate"].get<double>(), 0.01);
  EXPECT_LE(json["discretisation"].get<double>(), json["estimate"].get<double>());
  EXPECT_GE(json["solver"].get<double>(), 0.0);
  EXPECT_GT(json["theory"].get<double>(), 0.0);
  EXPECT_EQ(json["reached"], true);
  ASSERT_EQ(json["levels"].size(), 2u);
  EXPECT_EQ(json["levels"][1]["divisions"], Json(report.levels[1].divisions));
  EXPECT_TRUE(json["levels"][0]["estimate"].is_null());
  EXPECT_GT(json["levels"][1]["seconds"].get<double>(), 0.0);
  EXPECT_GT(json["levels"][1]["dof"].get<int>(), json["levels"][0]["dof"].get<int>());
}

}  // namespace
}  // namespace darboux
