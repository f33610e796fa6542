#include "geometry/random_stream.h"

#include <gtest/gtest.h>

#include <cmath>

namespace darboux {
namespace {

// A seed means the same scan for ever: these bits are part of it.
TEST(RandomStreamTest, BitsAreTheSameEverywhere) {
  RandomStream random(1, 2, 3);
  const std::uint64_t first = random.Bits(), second = random.Bits();
  EXPECT_EQ(first, 0xd87468a928b2a925u);
  EXPECT_EQ(second, 0x8838ed33055bb936u);
  EXPECT_EQ(RandomStream(1, 2, 3).Normal(), 0x1.341931d5fb86p+0);
}

TEST(RandomStreamTest, StreamsDifferBySeedPurposeAndNumber) {
  const std::uint64_t bits = RandomStream(5, 6, 7).Bits();
  EXPECT_EQ(RandomStream(5, 6, 7).Bits(), bits);
  EXPECT_NE(RandomStream(6, 5, 7).Bits(), bits);
  EXPECT_NE(RandomStream(5, 7, 6).Bits(), bits);
  EXPECT_NE(RandomStream(5, 6, 8).Bits(), bits);
}

// First numbers of neighbouring streams, as the points of a scan use them.
TEST(RandomStreamTest, NeighbouringStreamsAreIndependent) {
  constexpr int kCount = 40000;
  double sum = 0.0, squares = 0.0, products = 0.0, cubes = 0.0, fourths = 0.0, last = 0.0;
  double uniform = 0.0;
  Eigen::Vector3d direction = Eigen::Vector3d::Zero(), ball = Eigen::Vector3d::Zero();
  double radius = 0.0;
  for (int i = 0; i < kCount; ++i) {
    const double x = RandomStream(11, 2, static_cast<std::uint64_t>(i)).Normal();
    sum += x;
    squares += x * x;
    cubes += x * x * x;
    fourths += x * x * x * x;
    products += x * last;
    last = x;
    RandomStream other(11, 3, static_cast<std::uint64_t>(i));
    const double u = other.Uniform();
    ASSERT_GE(u, 0.0);
    ASSERT_LT(u, 1.0);
    uniform += u;
    const Eigen::Vector3d d = other.Direction();
    ASSERT_NEAR(d.norm(), 1.0, 4e-16);
    direction += d;
    const Eigen::Vector3d b = other.InBall();
    ASSERT_LE(b.norm(), 1.0);
    ball += b;
    radius += std::pow(b.norm(), 3);
  }
  // Four standard deviations each.
  const double unit = 4.0 / std::sqrt(kCount);
  EXPECT_NEAR(sum / kCount, 0.0, unit);
  EXPECT_NEAR(squares / kCount, 1.0, unit * std::sqrt(2.0));
  EXPECT_NEAR(cubes / kCount, 0.0, unit * std::sqrt(15.0));
  EXPECT_NEAR(fourths / kCount, 3.0, unit * std::sqrt(96.0));
  EXPECT_NEAR(products / kCount, 0.0, unit);
  EXPECT_NEAR(uniform / kCount, 0.5, unit * std::sqrt(1.0 / 12.0));
  EXPECT_NEAR(radius / kCount, 0.5, unit * std::sqrt(1.0 / 12.0));
  for (int k = 0; k < 3; ++k) {
    EXPECT_NEAR(direction[k] / kCount, 0.0, unit * std::sqrt(1.0 / 3.0));
    EXPECT_NEAR(ball[k] / kCount, 0.0, unit * std::sqrt(1.0 / 5.0));
  }
}

TEST(RandomStreamTest, LogAndSinCosAreAccurate) {
  for (int i = 1; i < 5000; ++i) {
    const double x = i * 0.0007;
    EXPECT_NEAR(PortableLog(x), std::log(x), 4e-16 * std::max(1.0, std::abs(std::log(x)))) << x;
    const double y = std::pow(10.0, -300.0 + 0.12 * i);
    EXPECT_NEAR(PortableLog(y), std::log(y), 4e-16 * std::abs(std::log(y)) + 4e-16) << y;
    const double turns = 0.00131 * i - 3.0;
    double sine, cosine;
    PortableSinCos(turns, &sine, &cosine);
    EXPECT_NEAR(sine, std::sin(2.0 * M_PI * turns), 4e-15) << turns;  // Here pi is rounded too.
    EXPECT_NEAR(cosine, std::cos(2.0 * M_PI * turns), 4e-15) << turns;
    EXPECT_NEAR(sine * sine + cosine * cosine, 1.0, 5e-16);
  }
  double sine, cosine;
  for (const double turns : {-1.0, 0.0, 7.0}) {
    PortableSinCos(turns + 0.25, &sine, &cosine);
    EXPECT_EQ(sine, 1.0);
    EXPECT_EQ(cosine, 0.0);
    PortableSinCos(turns + 0.5, &sine, &cosine);
    EXPECT_EQ(sine, 0.0);
    EXPECT_EQ(cosine, -1.0);
    PortableSinCos(turns + 0.75, &sine, &cosine);
    EXPECT_EQ(sine, -1.0);
  }
}

}  // namespace
}  // namespace darboux
