#include "solver/inp_loads.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "solver/scene_reader.h"
#include "solver/shell_problem.h"
#include "tests/calculix_dat.h"

namespace darboux {
namespace {

using Eigen::Vector3d;

constexpr char kHead[] =
    "shell: {thickness: 0.1, young_modulus: 1000, poisson_ratio: 0.3, density: 2}\n"
    "model: {theory: linear}\nsupports: [{on: u_min, clamped: true}]\n";
constexpr char kPlate[] =
    "name: plate\nsurface: {kind: plane, u: [0, 4], v: [0, 3], divisions: [5, 3]}\n";
// A quarter of a tube of radius 3 and length 2, cells graded around.
constexpr char kTube[] =
    "name: tube\nsurface: {kind: cylinder, radius: 3, u: [0, 2], v: [0, pi/2], "
    "divisions: [2, 4], grading: [0, -0.6]}\n";

class InpLoadsTest : public ::testing::TestWithParam<InpElement> {
 protected:
  void Make(const std::string& surface, const std::string& loads) {
    std::string error;
    ASSERT_TRUE(ParseScene(surface + kHead + loads, "scene.yaml", &scene_, &error)) << error;
    problem_ = ShellProblem::Create(scene_, ShellProblem::Options(), &error);
    ASSERT_NE(problem_, nullptr) << error;
    mesh_ = std::make_unique<InpMesh>(problem_->surface(), GetParam(), scene_.shell.thickness);
    loads_ = MakeInpLoads(scene_, *mesh_, false);
  }
  Vector3d Force() const {
    Vector3d sum = Vector3d::Zero();
    for (const auto& force : loads_.forces) sum += force.second;
    return sum;
  }
  // About the origin.
  Vector3d Moment() const {
    Vector3d sum = Vector3d::Zero();
    for (const auto& [node, force] : loads_.forces) {
      sum += mesh_->nodes()[node - 1].position.cross(force);
    }
    for (const auto& moment : loads_.moments) sum += moment.second;
    return sum;
  }

  Scene scene_;
  std::unique_ptr<ShellProblem> problem_;
  std::unique_ptr<InpMesh> mesh_;
  InpLoads loads_;
};

// Whatever the elements.
TEST_P(InpLoadsTest, NodalForcesHaveResultantAndMomentOfTheLoad) {
  Make(kPlate, "loads: [{kind: pressure, value: \"1 + x - y/2\"}]\n");
  EXPECT_NEAR(Force().z(), 12 * (1 + 2 - 0.75), 1e-12);
  // Moments int y p, -int x p.
  EXPECT_NEAR(Moment().x(), 1.5 * 12 + 1.5 * 2 * 12 - 0.5 * 4 * 9, 1e-11);
  EXPECT_NEAR(Moment().y(), -(2 * 12 + 3 * 64.0 / 3 - 0.5 * 8 * 4.5), 1e-11);
  Make(kPlate, "loads: [{kind: edge, on: v_max, force: [0, 2, 5], moment: [3, 0, 0]}]\n");
  EXPECT_LT((Force() - Vector3d(0, 8, 20)).norm(), 1e-12);
  EXPECT_LT((Moment() - Vector3d(60 + 12, -40, 16)).norm(), 1e-11);
  // Also where no node is.
  Make(kPlate, "loads: [{kind: point, at: {uv: [1.3, 2.2]}, force: [1, 2, 3]}]\n");
  EXPECT_LT((Force() - Vector3d(1, 2, 3)).norm(), 1e-13);
  EXPECT_LT((Moment() - Vector3d(1.3, 2.2, 0).cross(Vector3d(1, 2, 3))).norm(), 1e-12);
  ASSERT_FALSE(loads_.remarks.empty());
  EXPECT_THAT(loads_.remarks[0], ::testing::HasSubstr("no node at the point"));
  Make(kPlate, "loads: [{kind: line, along: {u: 1.7}, force: [0, 0, -2]}]\n");
  EXPECT_LT((Force() - Vector3d(0, 0, -6)).norm(), 1e-12);
  EXPECT_LT((Moment() - Vector3d(-9, 1.7 * 6, 0)).norm(), 1e-11);
}

// Loads are integrated over the exact surface, not over the elements.
TEST_P(InpLoadsTest, ForcesOfATubeAreThoseOfItsArea) {
  Make(kTube, "loads: [{kind: traction, force: [1, 0, 0]}]\n");
  EXPECT_NEAR(Force().x() / (3 * std::acos(-1.0)), 1.0, 1e-12);
  Make(kTube, "loads: [{kind: pressure, value: 2}]\n");
  EXPECT_LT((Force() - Vector3d(0, 12, 12)).norm(), 1e-5);  // on chords of the quarter: 2 * 6
}

TEST_P(InpLoadsTest, FacesHaveTheAreaOfOffsetSurfaces) {
  Make(kTube, "loads: [{kind: gravity, acceleration: [0, 0, -9.81]}]\n");
  EXPECT_TRUE(loads_.forces.empty());
  ASSERT_EQ(loads_.gravity.size(), 1u);
  for (const double ratio : FaceRatios(*mesh_, -1)) EXPECT_NEAR(ratio, 3 / 2.95, 1e-12);
  for (const double ratio : FaceRatios(*mesh_, 1)) EXPECT_NEAR(ratio, 3 / 3.05, 1e-12);
}

// Corners below the shell come first, counterclockwise from the normal's side.
TEST_P(InpLoadsTest, ElementsAreWoundAboutTheNormal) {
  Make(kTube, "");
  const bool quadrilateral = IsQuadrilateral(GetParam());
  EXPECT_EQ(mesh_->elements().size(), quadrilateral ? 8u : 16u);
  const std::map<InpElement, size_t> sizes = {{InpElement::kS3, 3},
                                              {InpElement::kS4, 4},
                                              {InpElement::kS6, 6},
                                              {InpElement::kS8R, 8},
                                              {InpElement::kC3D15, 15},
                                              {InpElement::kC3D20R, 20}};
  std::vector<int> used(mesh_->nodes().size() + 1, 0);
  for (size_t e = 0; e < mesh_->elements().size(); ++e) {
    const std::vector<int> nodes = mesh_->ElementNodes(static_cast<int>(e));
    ASSERT_EQ(nodes.size(), sizes.at(GetParam()));
    for (const int node : nodes) used[node] = 1;
    const auto x = [&](int i) { return mesh_->nodes()[nodes[i] - 1].position; };
    const Vector3d up = (x(1) - x(0)).cross(x(2) - x(0));
    EXPECT_GT(up.dot(mesh_->columns()[mesh_->elements()[e][0]].normal), 0.0);
    if (mesh_->is_solid()) {
      EXPECT_GT(up.dot(x(quadrilateral ? 4 : 3) - x(0)), 0.0);
    }
  }
  for (size_t i = 1; i < used.size(); ++i) EXPECT_EQ(used[i], 1) << i;
}

INSTANTIATE_TEST_SUITE_P(Elements,
                         InpLoadsTest,
                         ::testing::Values(InpElement::kS3,
                                           InpElement::kS4,
                                           InpElement::kS6,
                                           InpElement::kS8R,
                                           InpElement::kC3D15,
                                           InpElement::kC3D20R),
                         [](const auto& info) { return std::string(ToString(info.param)); });

TEST(CalculixDatTest, TakesTheLastStep) {
  const std::string head =
      " displacements (vx,vy,vz) for set PROBE_TIP and time  0.1000000E+01\n\n";
  const CalculixResult result =
      ReadCalculixDat("\n" + head + "         2 -4.1E-17  8.0E-02 6.440529E-03\n\n" + head +
                      "         2  1.0E+00 -2.0E+00  3.000000E+00\n\n"
                      " total force (fx,fy,fz) for set FINGER_A and time  0.1000000E+01\n\n"
                      "        1.0E+00  2.0E+00 -3.0E+00\n");
  ASSERT_EQ(result.probes.size(), 1u);
  EXPECT_EQ(result.probes.at("TIP"), Vector3d(1, -2, 3));
  EXPECT_EQ(result.forces.at("A"), Vector3d(1, 2, -3));
  EXPECT_TRUE(ReadCalculixDat("").probes.empty());
  EXPECT_TRUE(ReadCalculixDat(head).probes.empty());
}

}  // namespace
}  // namespace darboux
