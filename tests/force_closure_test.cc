// Force closure of contacts: who closes, by how much, what is lacking.
#include "geometry/force_closure.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "tests/test_util.h"

namespace darboux {
namespace {

using Eigen::Vector3d;
using ::testing::HasSubstr;

constexpr double kPi = 3.14159265358979323846;
using Contacts = std::vector<GraspContact>;

// On the poles of the unit sphere, normals tilted by angles about the x axis and a skew one.
Contacts Poles(double friction, double arm, double top_tilt = 0.0, double bottom_tilt = 0.0) {
  const Eigen::AngleAxisd top(top_tilt, Vector3d::UnitX());
  const Eigen::AngleAxisd bottom(bottom_tilt, Vector3d(1, 2, 0).normalized());
  return {{Vector3d::UnitZ(), top * -Vector3d::UnitZ(), friction, arm},
          {-Vector3d::UnitZ(), bottom * Vector3d::UnitZ(), friction, arm}};
}

Contacts Equator(int count, double friction, double arm) {
  Contacts contacts;
  for (int i = 0; i < count; ++i) {
    const double angle = 2.0 * kPi * i / count;
    const Vector3d p(std::cos(angle), std::sin(angle), 0.0);
    contacts.push_back({p, -p, friction, arm});
  }
  return contacts;
}

// Three under a cube, two beside, one behind, and a clamp against all of them on its far corner.
Contacts Fixture() {
  const Vector3d x = Vector3d::UnitX(), y = Vector3d::UnitY(), z = Vector3d::UnitZ();
  return {{{1, 0, -1}, z},
          {{-1, 1, -1}, z},
          {{-1, -1, -1}, z},
          {{1, -1, 0}, y},
          {{-1, -1, 0}, y},
          {{-1, 0, 0}, x},
          {{1, 1, 1}, -Vector3d(1, 1, 1).normalized()}};
}

Contacts Skew(double friction = 0.6) {
  Contacts contacts;
  std::mt19937 generator(5120);
  std::normal_distribution<double> normal;
  for (int i = 0; i < 5; ++i) {
    Vector3d p(normal(generator), normal(generator), normal(generator));
    p.normalize();
    Vector3d n(normal(generator), normal(generator), normal(generator));
    n = (-p + 0.2 * n).normalized();
    contacts.push_back({p.cwiseProduct(Vector3d(1.0, 0.8, 1.3)), n, friction, 0.1 * i});
  }
  return contacts;
}

ForceClosure Of(const Contacts& contacts, int edges = kConeEdges) {
  return EvaluateForceClosure(contacts, Vector3d::Zero(), 1.0, edges);
}

// ---- Two fingers ----------------------------------------------------------------------------

TEST(ForceClosureTest, TwoSoftFingersCloseWhereTheirLineIsInBothCones) {
  for (const double top : {0.0, 0.2, 0.7, 1.2}) {
    for (const double bottom : {0.05, 0.5}) {
      const double least = std::tan(std::max(top, bottom));
      EXPECT_TRUE(Of(Poles(1.0001 * least, 0.3, top, bottom)).closed) << top << " " << bottom;
      EXPECT_FALSE(Of(Poles(0.9999 * least, 0.3, top, bottom)).closed) << top << " " << bottom;
      const auto found = LeastFriction(Poles(0.0, 0.3, top, bottom), Vector3d::Zero(), 1.0);
      ASSERT_TRUE(found.has_value());
      EXPECT_NEAR(*found, least, 1e-6 * least);
    }
  }
}

TEST(ForceClosureTest, TwoHardFingersLackTheMomentAboutTheirLine) {
  const ForceClosure closure = Of(Poles(0.5, 0.0, 0.1, 0.1));
  EXPECT_FALSE(closure.closed);
  EXPECT_EQ(closure.rank, 5);
  EXPECT_EQ(closure.margin, 0.0);
  EXPECT_EQ(closure.lacks, "no moment about the line of the contacts");
  EXPECT_FALSE(LeastFriction(Poles(0.5, 0.0), Vector3d::Zero(), 1.0).has_value());
}

TEST(ForceClosureTest, NormalsThatFaceTheSameWayDoNotClose) {
  Contacts contacts = Poles(0.5, 0.3);
  contacts[1].normal = -contacts[1].normal;
  const ForceClosure closure = Of(contacts);
  EXPECT_EQ(closure.rank, 6);
  EXPECT_FALSE(closure.closed);
  EXPECT_EQ(closure.lacks, "no force towards (0, 0, 1)");
}

struct SoftPair {
  double friction, arm;
};
class OpposedSoftFingersTest : public ::testing::TestWithParam<SoftPair> {};

// By hand. The two cones, (mu t, z x mu t) at the top and (mu t, -z x mu t) at the bottom, lie in
// planes across one another; c = cos(pi / edges) is where the support function of a polygon is
// least. Along one cone: m / sqrt(1 + m^2), m = c mu / sqrt(2); against spin, where the cones may
// take part as long as they do not show, mu a / sqrt(1 + a^2 / c^2).
TEST_P(OpposedSoftFingersTest, HaveTheMarginFoundByHand) {
  const double mu = GetParam().friction, a = GetParam().arm;
  for (const int edges : {4, 8, kConeEdges, 32}) {
    const double c = std::cos(kPi / edges), m = c * mu / std::sqrt(2.0);
    const double expected =
        std::min(m / std::sqrt(1.0 + m * m), mu * a / std::sqrt(1.0 + a * a / (c * c)));
    EXPECT_NEAR(Of(Poles(mu, a), edges).margin, expected, 1e-12) << edges;
  }
}

INSTANTIATE_TEST_SUITE_P(FrictionAndArm,
                         OpposedSoftFingersTest,
                         ::testing::Values(SoftPair{0.5, 0.2},
                                           SoftPair{0.5, 1e-3},
                                           SoftPair{2.0, 0.1}));

// ---- More fingers ---------------------------------------------------------------------------

TEST(ForceClosureTest, ThreeHardFingersRoundASphereCloseWithAnyFriction) {
  const ForceClosure frictionless = Of(Equator(3, 0.0, 0.0));
  EXPECT_EQ(frictionless.rank, 2);
  EXPECT_THAT(frictionless.lacks, HasSubstr("no force along (0, 0, 1)"));
  EXPECT_THAT(frictionless.lacks, HasSubstr("no moment about the axis through (0, 0, 0)"));
  EXPECT_TRUE(Of(Equator(3, 1e-3, 0.0)).closed);
  const auto least = LeastFriction(Equator(3, 0.0, 0.0), Vector3d::Zero(), 1.0);
  ASSERT_TRUE(least.has_value());
  EXPECT_LT(*least, 1e-6);
  // In proportion to friction as long as that is small.
  EXPECT_NEAR(Of(Equator(3, 2e-3, 0.0)).margin, 2.0 * Of(Equator(3, 1e-3, 0.0)).margin, 1e-6);
}

TEST(ForceClosureTest, ThreeFingersOnOneSideAreOpen) {
  Contacts contacts = Equator(3, 0.3, 0.1);
  for (GraspContact& contact : contacts) contact.normal = -Vector3d::UnitZ();
  const ForceClosure closure = Of(contacts);
  EXPECT_FALSE(closure.closed);
  EXPECT_EQ(closure.lacks, "no force towards (0, 0, 1)");
}

TEST(ForceClosureTest, SevenFrictionlessFingersMayCloseFewerNever) {
  const Contacts fixture = Fixture();
  const ForceClosure closure = EvaluateForceClosure(fixture, Vector3d::Zero(), std::sqrt(3.0));
  EXPECT_TRUE(closure.closed) << closure.lacks;
  EXPECT_GT(closure.margin, 1e-3);
  EXPECT_EQ(LeastFriction(fixture, Vector3d::Zero(), 1.0), 0.0);
  for (size_t without = 0; without < fixture.size(); ++without) {
    Contacts six = fixture;
    six.erase(six.begin() + without);
    const ForceClosure open = Of(six);
    EXPECT_FALSE(open.closed);
    EXPECT_FALSE(open.lacks.empty());
  }
  const Contacts four(fixture.begin(), fixture.begin() + 4);
  EXPECT_EQ(Of(four).rank, 4);
  EXPECT_FALSE(Of(four).closed);
}

// The force of a clamp at the origin alone closes nothing that three frictionless planes leave.
TEST(ForceClosureTest, FixtureWithoutItsClampPushesAwayFromItsWalls) {
  Contacts six = Fixture();
  six.pop_back();
  EXPECT_THAT(Of(six).lacks, HasSubstr("no "));
  EXPECT_EQ(Of(six).rank, 6);
}

TEST(ForceClosureTest, NoContactIsNoGrasp) {
  EXPECT_FALSE(Of({}).closed);
  EXPECT_EQ(Of({}).lacks, "no contact");
}

// ---- The margin -----------------------------------------------------------------------------

// The margin is the least of the support function h(u) = max w.u over unit u: no direction may be
// below it, and a search without hulls must come down to it.
TEST(ForceClosureTest, MarginIsTheLeastSupportOfAnyDirection) {
  const Contacts contacts = Skew();
  const ForceClosure closure = Of(contacts, 8);
  ASSERT_TRUE(closure.closed) << closure.lacks;
  const auto wrenches = PrimitiveWrenches(contacts, Vector3d::Zero(), 1.0, 8);
  using Direction = Eigen::Matrix<double, 6, 1>;
  std::mt19937 generator(1992);
  std::normal_distribution<double> normal;
  const auto random = [&] {
    Direction u;
    for (int i = 0; i < 6; ++i) u[i] = normal(generator);
    return u;
  };
  double least = 1e9;
  for (int start = 0; start < 60; ++start) {
    Direction u = random().normalized();
    double h = (wrenches.transpose() * u).maxCoeff(), reach = 0.5;
    for (int i = 0; i < 3000; ++i) {
      const Direction v = (u + reach * random()).normalized();
      const double there = (wrenches.transpose() * v).maxCoeff();
      if (there < h) {
        u = v;
        h = there;
      } else {
        reach = std::max(1e-5, 0.997 * reach);
      }
    }
    EXPECT_GE(h, closure.margin - 1e-12);
    least = std::min(least, h);
  }
  EXPECT_NEAR(least, closure.margin, 1e-3 * closure.margin);
}

// By a combination of the wrenches on the one hand, by their hull on the other.
TEST(ForceClosureTest, LeastFrictionIsWhereTheMarginBegins) {
  const auto least = LeastFriction(Skew(), Vector3d::Zero(), 1.0);
  ASSERT_TRUE(least.has_value());
  EXPECT_GT(*least, 1e-3);
  EXPECT_TRUE(Of(Skew(*least * (1.0 + 1e-5))).closed);
  EXPECT_FALSE(Of(Skew(*least * (1.0 - 1e-5))).closed);
}

TEST(ForceClosureTest, MarginGrowsWithTheEdgesOfTheCone) {
  const double friction = 1.0;
  double before = 0.0;
  for (const int edges : {4, 8, 16}) {
    const double margin = Of(Skew(friction), edges).margin;
    EXPECT_GT(margin, before);
    before = margin;
  }
  EXPECT_NEAR(Of(Skew(friction)).margin, before, (1.0 - std::cos(kPi / kConeEdges)) * friction);
}

TEST(ForceClosureTest, AxesPlaceAndUnitDoNotMatter) {
  const Contacts contacts = Skew();
  const double margin = Of(contacts).margin;
  const Eigen::Matrix3d rotation = SkewRotation(0.7);
  const Vector3d shift(3.0, -7.0, 2.0);
  const double unit = 1e-3;
  Contacts moved = contacts;
  for (GraspContact& contact : moved) {
    contact.position = unit * (rotation * contact.position + shift);
    contact.normal = rotation * contact.normal;
    contact.arm *= unit;
  }
  EXPECT_NEAR(EvaluateForceClosure(moved, unit * shift, unit).margin, margin, 1e-9 * margin);
  const auto least = LeastFriction(contacts, Vector3d::Zero(), 1.0);
  const auto least_moved = LeastFriction(moved, unit * shift, unit);
  ASSERT_TRUE(least.has_value() && least_moved.has_value());
  EXPECT_NEAR(*least_moved, *least, 1e-6 * *least);
  // Pairs on one line have no first edge of their own.
  Contacts pair = Poles(0.5, 0.2);
  for (GraspContact& contact : pair) {
    contact.position = rotation * contact.position;
    contact.normal = rotation * contact.normal;
  }
  EXPECT_NEAR(Of(pair).margin, Of(Poles(0.5, 0.2)).margin, 1e-12);
}

TEST(ForceClosureTest, HandsOfManyFingersAreEvaluated) {
  const ForceClosure closure = Of(Equator(6, 0.5, 0.1));
  EXPECT_TRUE(closure.closed);
  EXPECT_GT(closure.margin, 0.1);
}

}  // namespace
}  // namespace darboux
