#include "tests/calculix_deck.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <map>
#include <string>
#include <vector>

namespace darboux {
namespace {

using Eigen::Vector3d;
using ::testing::HasSubstr;
using ::testing::Not;

// A quarter of a tube of radius 3 and length 2, cells graded around.
PatchPoint Tube(double s, double t) {
  const double v = 0.5 * std::acos(-1.0) * (0.4 * t + 0.6 * t * t);
  const Vector3d normal(0, std::sin(v), std::cos(v));
  return {3 * normal + 2 * s * Vector3d::UnitX(), normal};
}

PatchPoint Plane(double s, double t) { return {{4 * s, 3 * t, 0}, Vector3d::UnitZ()}; }

class CalculixMeshTest : public ::testing::TestWithParam<CalculixElement> {
 protected:
  static Vector3d Sum(const CalculixMesh::Forces& forces) {
    Vector3d sum = Vector3d::Zero();
    for (const auto& force : forces) sum += force.second;
    return sum;
  }
  // About the origin.
  static Vector3d Moment(const CalculixMesh& mesh, const CalculixMesh::Forces& forces) {
    Vector3d sum = Vector3d::Zero();
    for (const auto& [node, force] : forces) sum += mesh.nodes()[node - 1].cross(force);
    return sum;
  }
};

TEST_P(CalculixMeshTest, HasTheNodesAndElementsOfItsCells) {
  const CalculixMesh mesh(GetParam(), {4, 3}, 0.1, Plane);
  const bool triangles = GetParam() == CalculixElement::kS6;
  EXPECT_EQ(mesh.elements().size(), triangles ? 24u : 12u);
  const std::map<CalculixElement, size_t> nodes = {{CalculixElement::kS4, 20},
                                                   {CalculixElement::kS6, 63},
                                                   {CalculixElement::kS8R, 51},
                                                   {CalculixElement::kC3D20R, 2 * 51 + 20}};
  EXPECT_EQ(mesh.nodes().size(), nodes.at(GetParam()));
  std::vector<int> used(mesh.nodes().size() + 1, 0);
  for (const std::vector<int>& element : mesh.elements()) {
    for (const int node : element) {
      ASSERT_GE(node, 1);
      ASSERT_LE(node, static_cast<int>(mesh.nodes().size()));
      used[node] = 1;
    }
  }
  for (size_t i = 1; i < used.size(); ++i) EXPECT_EQ(used[i], 1) << i;
  EXPECT_EQ(mesh.nodes()[mesh.CornerNode(1, 1) - 1], Vector3d(4, 3, 0));
  for (const int node : mesh.SideNodes(CalculixMesh::kSMax)) {
    EXPECT_EQ(mesh.nodes()[node - 1].x(), 4.0);
  }
}

// Dead loads have their resultant and moment whatever the elements.
TEST_P(CalculixMeshTest, NodalForcesHaveResultantAndMomentOfTheLoad) {
  const CalculixMesh mesh(GetParam(), {5, 3}, 0.1, Plane);
  // Linear over the plate 4 x 3: pressure 1 + x - y / 2.
  const CalculixMesh::Forces area =
      mesh.AreaForces([](const Vector3d& x) { return Vector3d(0, 0, 1 + x.x() - 0.5 * x.y()); });
  EXPECT_NEAR(Sum(area).z(), 12 * (1 + 2 - 0.75), 1e-12);
  // Moments int y p, -int x p.
  EXPECT_NEAR(Moment(mesh, area).x(), 1.5 * 12 + 1.5 * 2 * 12 - 0.5 * 4 * 9, 1e-12);
  EXPECT_NEAR(Moment(mesh, area).y(), -(2 * 12 + 3 * 64.0 / 3 - 0.5 * 8 * 4.5), 1e-12);
  const CalculixMesh::Forces side = mesh.SideForces(CalculixMesh::kTMax, {0, 2, 5});
  EXPECT_LT((Sum(side) - Vector3d(0, 8, 20)).norm(), 1e-12);
  EXPECT_LT((Moment(mesh, side) - Vector3d(60, -40, 16)).norm(), 1e-11);
  const CalculixMesh::Forces corner = mesh.CornerForces(1, 0, {1, 2, 3});
  EXPECT_LT((Sum(corner) - Vector3d(1, 2, 3)).norm(), 1e-14);
  EXPECT_LT((Moment(mesh, corner) - Vector3d(4, 0, 0).cross(Vector3d(1, 2, 3))).norm(), 1e-13);
}

TEST_P(CalculixMeshTest, ForcesOfATubeConvergeToItsArea) {
  double before = 1.0;
  for (const int n : {4, 8, 16}) {
    const CalculixMesh mesh(GetParam(), {2, n}, 0.1, Tube);
    const double area = Sum(mesh.AreaForces([](const Vector3d&) { return Vector3d::UnitX(); })).x();
    const double error = std::abs(area / (3 * std::acos(-1.0)) - 1.0);
    EXPECT_LT(error, 0.3 * before);
    before = error;
  }
}

TEST_P(CalculixMeshTest, DecksHaveTheirCardsInOrder) {
  const CalculixMesh mesh(GetParam(), {2, 2}, 0.1, Tube);
  CalculixDeck deck;
  deck.young_modulus = 1e6;
  deck.poisson_ratio = 0.3;
  deck.fixed = {{mesh.SideNodes(CalculixMesh::kSMin), 1, 3}};
  deck.forces = mesh.CornerForces(1, 1, {0, -2, 0});
  deck.printed = {mesh.CornerNode(1, 1)};
  std::string text = MakeDeck(mesh, deck);
  size_t at = 0;
  for (const char* card : {"*NODE,",
                           "*ELEMENT,",
                           "*ELASTIC",
                           "SECTION",
                           "*BOUNDARY",
                           "*STEP",
                           "*STATIC",
                           "*CLOAD",
                           "*NODE PRINT",
                           "*END STEP"}) {
    at = text.find(card, at);
    ASSERT_NE(at, std::string::npos) << card;
  }
  EXPECT_THAT(text, Not(HasSubstr("NLGEOM")));
  EXPECT_THAT(text, HasSubstr(std::string("TYPE=") + ToString(GetParam())));
  // At most 16 numbers in a line, as its reader demands.
  size_t commas = 0;
  for (const char c : text) {
    commas = c == '\n' ? 0 : commas + (c == ',');
    ASSERT_LE(commas, 16u);
  }
  // In cylindrical axes a force along y at the side t = 1 (v = pi / 2) is radial.
  deck.cylindrical = true;
  deck.nonlinear = true;
  text = MakeDeck(mesh, deck);
  EXPECT_THAT(text, HasSubstr("NLGEOM"));
  const int node = mesh.CornerNode(1, 1);
  EXPECT_THAT(text, HasSubstr("\n" + std::to_string(node) + ", 1, -"));
}

INSTANTIATE_TEST_SUITE_P(Elements,
                         CalculixMeshTest,
                         ::testing::Values(CalculixElement::kS4,
                                           CalculixElement::kS6,
                                           CalculixElement::kS8R,
                                           CalculixElement::kC3D20R),
                         [](const auto& info) { return std::string(ToString(info.param)); });

TEST(ReadDatTest, TakesTheLastIncrement) {
  std::map<int, Vector3d> u;
  const std::string block = " displacements (vx,vy,vz) for set PRINTED and time  0.1000000E+01\n\n";
  EXPECT_TRUE(ReadDat("\n" + block + "         2 -4.1E-17  8.0E-02 6.440529E-03\n" + "\n" + block +
                          "         2  1.0E+00 -2.0E+00  3.000000E+00\n",
                      &u));
  ASSERT_EQ(u.size(), 1u);
  EXPECT_EQ(u[2], Vector3d(1, -2, 3));
  EXPECT_FALSE(ReadDat("", &u));
  EXPECT_FALSE(ReadDat(block, &u));
}

}  // namespace
}  // namespace darboux
