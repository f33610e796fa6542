#include "solver/rigid_motion.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <Eigen/Geometry>
#include <cmath>
#include <random>
#include <string>
#include <vector>

namespace darboux {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::StartsWith;

using Vector6 = Eigen::Matrix<double, 6, 1>;

const Eigen::Vector3d kX = Eigen::Vector3d::UnitX();
const Eigen::Vector3d kY = Eigen::Vector3d::UnitY();
const Eigen::Vector3d kZ = Eigen::Vector3d::UnitZ();

RigidFrame Frame(const Eigen::Vector3d& center = {0.5, -1.0, 2.0}, double length = 3.0) {
  RigidFrame frame;
  frame.center = center;
  frame.length = length;
  return frame;
}

// Rows that hold some displacement components at some points.
class Holds {
 public:
  explicit Holds(const RigidFrame& frame) : frame_(frame) {}

  Holds& At(const Eigen::Vector3d& x, const std::vector<Eigen::Vector3d>& directions) {
    for (const Eigen::Vector3d& d : directions) Add(frame_.DisplacementRow(x, d));
    return *this;
  }
  Holds& Rotation(const Eigen::Vector3d& tangent, const Eigen::Vector3d& direction) {
    Add(frame_.DerivativeRow(tangent, direction));
    return *this;
  }
  Eigen::MatrixXd Free() const { return FreeMotions(rows_, Eigen::MatrixXd::Identity(6, 6)); }
  std::vector<std::string> Names() const { return NameMotions(Free(), frame_); }

 private:
  void Add(const Eigen::Matrix<double, 1, 6>& row) {
    rows_.conservativeResize(rows_.rows() + 1, 6);
    rows_.bottomRows<1>() = row;
  }

  RigidFrame frame_;
  Eigen::MatrixXd rows_ = Eigen::MatrixXd(0, 6);
};

TEST(RigidFrameTest, RowsAreWhatTheMotionDoes) {
  std::mt19937 gen(55001);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  const auto vector = [&] { return Eigen::Vector3d(uniform(gen), uniform(gen), uniform(gen)); };
  const RigidFrame frame = Frame();
  for (int k = 0; k < 20; ++k) {
    const Eigen::Vector3d translation = vector(), rotation = vector(), x = vector();
    const Eigen::Vector3d direction = vector(), tangent = vector().normalized();
    Vector6 motion;
    motion << translation, rotation * frame.length;
    const auto displacement = [&](const Eigen::Vector3d& at) -> Eigen::Vector3d {
      return translation + rotation.cross(at - frame.center);
    };
    EXPECT_NEAR(
        frame.DisplacementRow(x, direction) * motion, direction.dot(displacement(x)), 1e-14);
    const Eigen::Vector3d derivative = displacement(x + tangent) - displacement(x);
    EXPECT_NEAR(frame.DerivativeRow(tangent, direction) * motion,
                direction.dot(derivative) * frame.length,
                1e-14);
  }
}

TEST(FreeMotionsTest, NoRowsLeaveAllThatIsAllowed) {
  EXPECT_EQ(FreeMotions(Eigen::MatrixXd(0, 6), Eigen::MatrixXd::Identity(6, 6)).cols(), 6);
  // Rows of zeros hold nothing.
  EXPECT_EQ(FreeMotions(Eigen::MatrixXd::Zero(4, 6), Eigen::MatrixXd::Identity(6, 6)).cols(), 6);
  const Eigen::MatrixXd allowed = Eigen::MatrixXd::Identity(6, 6).leftCols(2);
  EXPECT_EQ(FreeMotions(Eigen::MatrixXd(0, 6), allowed).cols(), 2);
}

TEST(FreeMotionsTest, AreAnOrthonormalBasisThatLeavesTheRowsZero) {
  const RigidFrame frame = Frame();
  Eigen::MatrixXd rows(2, 6);
  rows << frame.DisplacementRow({1, 2, 3}, kX), 1e6 * frame.DisplacementRow({1, 2, 3}, kY);
  const Eigen::MatrixXd free = FreeMotions(rows, Eigen::MatrixXd::Identity(6, 6));
  ASSERT_EQ(free.cols(), 4);
  EXPECT_LT((free.transpose() * free - Eigen::MatrixXd::Identity(4, 4)).norm(), 1e-12);
  EXPECT_LT((rows.row(0) * free).norm(), 1e-12);
  EXPECT_LT((rows.row(1) * free).norm(), 1e-6);
}

TEST(FreeMotionsTest, StayWithinWhatIsAllowed) {
  // A plate that only moves out of its plane: one displacement and two rotations.
  const RigidFrame frame = Frame();
  Eigen::MatrixXd allowed = Eigen::MatrixXd::Zero(6, 3);
  allowed(2, 0) = allowed(3, 1) = allowed(4, 2) = 1.0;
  Eigen::MatrixXd rows(2, 6);
  rows << frame.DisplacementRow({0, 0, 2}, kZ), frame.DisplacementRow({1, 0, 2}, kZ);
  const Eigen::MatrixXd free = FreeMotions(rows, allowed);
  ASSERT_EQ(free.cols(), 1);
  EXPECT_THAT(NameMotions(free, frame),
              ElementsAre("rotation about the axis through (0.5, 0, 2) along x"));
}

// A condition that barely resists is no support, at any scale of its row.
TEST(FreeMotionsTest, RowsCountByTheirDirectionNotByTheirSize) {
  const RigidFrame frame = Frame();
  for (const double scale : {1e-9, 1.0, 1e9}) {
    Eigen::MatrixXd rows(6, 6);
    rows << frame.DisplacementRow({0, 0, 0}, kX), frame.DisplacementRow({0, 0, 0}, kY),
        frame.DisplacementRow({0, 0, 0}, kZ), frame.DisplacementRow({1, 0, 0}, kY),
        frame.DisplacementRow({1, 0, 0}, kZ), scale * frame.DisplacementRow({0, 1, 0}, kZ);
    EXPECT_EQ(FreeMotions(rows, Eigen::MatrixXd::Identity(6, 6)).cols(), 0) << scale;
  }
}

// A fine mesh has conditions by the ten thousand; rounding must not hold what they leave free.
TEST(FreeMotionsTest, ManyRowsLeaveTheirCommonMotionFree) {
  std::mt19937 gen(55002);
  std::normal_distribution<double> normal(0.0, 1.0);
  Vector6 motion;
  motion << 0.3, -0.2, 0.5, 0.7, 0.1, -0.4;
  motion.normalize();
  for (const int count : {100, 10000, 200000}) {
    Eigen::MatrixXd rows = Eigen::MatrixXd::NullaryExpr(count, 6, [&] { return normal(gen); });
    rows -= rows * motion * motion.transpose();
    const Eigen::MatrixXd free = FreeMotions(rows, Eigen::MatrixXd::Identity(6, 6));
    ASSERT_EQ(free.cols(), 1) << count;
    EXPECT_NEAR(std::abs(free.col(0).dot(motion)), 1.0, 1e-12);
    // The same condition over and over holds one.
    const Eigen::MatrixXd one = rows.topRows(1).replicate(count, 1);
    EXPECT_EQ(FreeMotions(one, Eigen::MatrixXd::Identity(6, 6)).cols(), 5) << count;
  }
}

TEST(NameMotionsTest, NothingFreeHasNoNames) {
  EXPECT_THAT(NameMotions(Eigen::MatrixXd(6, 0), Frame()), IsEmpty());
}

TEST(NameMotionsTest, AFreeBodyHasSixMotionsAboutItsCentre) {
  EXPECT_THAT(Holds(Frame()).Names(),
              ElementsAre("translation along x",
                          "translation along y",
                          "translation along z",
                          "rotation about the axis through (0.5, -1, 2) along x",
                          "rotation about the axis through (0.5, -1, 2) along y",
                          "rotation about the axis through (0.5, -1, 2) along z"));
}

TEST(NameMotionsTest, OneHeldPointLeavesThreeRotations) {
  const auto names = Holds(Frame()).At({1, 2, 3}, {kX, kY, kZ}).Names();
  ASSERT_EQ(names.size(), 3u);
  // Each axis goes through the point; named by the place nearest to the centre.
  EXPECT_THAT(names,
              ElementsAre("rotation about the axis through (0.5, 2, 3) along x",
                          "rotation about the axis through (1, -1, 3) along y",
                          "rotation about the axis through (1, 2, 2) along z"));
}

TEST(NameMotionsTest, TwoHeldPointsLeaveTheRotationAboutTheirLine) {
  const auto names =
      Holds(Frame({0, 0, 0}, 3.0)).At({1, 1, 0}, {kX, kY, kZ}).At({4, 5, 0}, {kX, kY, kZ}).Names();
  // The line through (1, 1) and (4, 5): nearest to the origin at (4, -3) / 25.
  EXPECT_THAT(names,
              ElementsAre("rotation about the axis through (0.16, -0.12, 0) along (0.6, 0.8, 0)"));
}

TEST(NameMotionsTest, ThreeHeldPointsLeaveNothing) {
  Holds holds(Frame());
  holds.At({0, 0, 0}, {kX, kY, kZ}).At({1, 0, 0}, {kX, kY, kZ}).At({0, 1, 0}, {kX, kY, kZ});
  EXPECT_THAT(holds.Names(), IsEmpty());
}

TEST(NameMotionsTest, AClampedPointLeavesNothing) {
  Holds holds(Frame());
  holds.At({0, 0, 0}, {kX, kY, kZ}).Rotation(kX, kZ).Rotation(kY, kZ).Rotation(kX, kY);
  EXPECT_THAT(holds.Names(), IsEmpty());
}

TEST(NameMotionsTest, ATubeOnDiaphragmsSlidesAlongItsAxis) {
  Holds holds(Frame({150, 0, 0}, 600));
  for (const double x : {0.0, 300.0}) {
    for (const double v : {0.0, 1.0, 2.0}) {
      holds.At({x, 300 * std::sin(v), 300 * std::cos(v)}, {kY, kZ});
    }
  }
  EXPECT_THAT(holds.Names(), ElementsAre("translation along x"));
}

TEST(NameMotionsTest, ASymmetryPlaneLeavesItsOwnMotions) {
  // Mirror plane z = 0: displacement along z is zero, and no rotation out of the plane.
  Holds holds(Frame({0, 0, 0}, 1.0));
  for (const double v : {0.0, 1.0, 2.0}) {
    holds.At({std::cos(v), std::sin(v), 0}, {kZ});
  }
  EXPECT_THAT(holds.Names(),
              ElementsAre("translation along x",
                          "translation along y",
                          "rotation about the axis through (0, 0, 0) along z"));
  // With a second mirror plane y = 0 only the line of both is left.
  for (const double v : {0.0, 1.0, 2.0}) {
    holds.At({std::cos(v), 0, std::sin(v)}, {kY});
  }
  EXPECT_THAT(holds.Names(), ElementsAre("translation along x"));
  holds.At({0, 0, 0}, {kX});
  EXPECT_THAT(holds.Names(), IsEmpty());
}

TEST(NameMotionsTest, ScrewsSayHowFarTheyAdvance) {
  const RigidFrame frame = Frame({1, 0, 0}, 2.0);
  // Turns about the line (0, 3, .) along z and advances 0.25 per radian; either sign is the same.
  for (const double sign : {1.0, -1.0}) {
    const Eigen::Vector3d rotation = sign * kZ;
    const Eigen::Vector3d translation =
        sign * 0.25 * kZ + rotation.cross(frame.center - Eigen::Vector3d(0, 3, 0));
    Vector6 motion;
    motion << translation, rotation * frame.length;
    EXPECT_THAT(NameMotions(motion.normalized(), frame),
                ElementsAre("rotation about the axis through (0, 3, 0) along z, advancing 0.25 per "
                            "radian"));
  }
}

TEST(NameMotionsTest, NamesDoNotDependOnTheBasis) {
  // Spans of a translation and a rotation, mixed at random.
  const RigidFrame frame = Frame({0, 0, 0}, 2.0);
  Eigen::MatrixXd motions = Eigen::MatrixXd::Zero(6, 2);
  motions.col(0).head<3>() = Eigen::Vector3d(1, 1, 0).normalized();
  motions.col(1) << 0, 0, 0, 0, 0, 1;
  std::mt19937 gen(55003);
  std::uniform_real_distribution<double> uniform(0.0, 6.0);
  for (int k = 0; k < 10; ++k) {
    const Eigen::Matrix2d turn = Eigen::Rotation2Dd(uniform(gen)).toRotationMatrix();
    EXPECT_THAT(NameMotions(motions * turn, frame),
                ElementsAre("translation along (0.7071, 0.7071, 0)",
                            "rotation about the axis through (0, 0, 0) along z"));
  }
}

// A slightly tilted axis is not the coordinate axis.
TEST(NameMotionsTest, OnlyCoordinateAxesAreCalledByTheirLetter) {
  Vector6 motion = Vector6::Zero();
  motion.head<3>() = Eigen::Vector3d(1e-3, 0, 1).normalized();
  EXPECT_THAT(NameMotions(motion, Frame()), ElementsAre("translation along (0.001, 0, 1)"));
  motion.head<3>() = Eigen::Vector3d(1e-9, 0, -1).normalized();
  EXPECT_THAT(NameMotions(motion, Frame()), ElementsAre("translation along z"));
}

TEST(NameMotionsTest, EveryNameIsATranslationOrARotation) {
  std::mt19937 gen(55004);
  std::normal_distribution<double> normal(0.0, 1.0);
  const RigidFrame frame = Frame();
  for (int held = 0; held <= 6; ++held) {
    const Eigen::MatrixXd rows = Eigen::MatrixXd::NullaryExpr(held, 6, [&] { return normal(gen); });
    const auto free = FreeMotions(rows, Eigen::MatrixXd::Identity(6, 6));
    ASSERT_EQ(free.cols(), 6 - held);
    const auto names = NameMotions(free, frame);
    ASSERT_EQ(names.size(), static_cast<size_t>(6 - held));
    // A generic k-dimensional space holds k - 3 translations.
    for (int k = 0; k < 6 - held; ++k) {
      EXPECT_THAT(names[k], StartsWith(k < 3 - held ? "translation along" : "rotation about"));
      EXPECT_THAT(names[k], ::testing::Not(HasSubstr("nan")));
    }
  }
}

}  // namespace
}  // namespace darboux
