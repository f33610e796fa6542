#include "solver/report_arrays.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <random>
#include <string>

#include "solver/base64.h"

namespace darboux {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

// As the page reads it.
Eigen::MatrixXd Read(const ReportArrays& arrays, const nlohmann::ordered_json& info) {
  const int rows = info["components"], cols = info["count"];
  Eigen::MatrixXd values(rows, cols);
  for (int i = 0; i < cols; ++i) {
    for (int k = 0; k < rows; ++k) {
      const double offset = info["offset"][k], scale = info["scale"][k];
      if (info["blob"].is_null()) {
        values(k, i) = offset;
        continue;
      }
      const std::string& bytes = arrays.blobs()[info["blob"].get<int>()];
      const size_t at = 2 * static_cast<size_t>(i * rows + k);
      const int code =
          static_cast<unsigned char>(bytes[at]) + 256 * static_cast<unsigned char>(bytes[at + 1]);
      values(k, i) = code == ReportArrays::kNoValue ? kNaN : offset + scale * code;
    }
  }
  return values;
}

class ReportArraysSizeTest : public ::testing::TestWithParam<double> {};

TEST_P(ReportArraysSizeTest, QuantisedValuesAreOffByHalfAStepAtMost) {
  std::mt19937 generator(38401);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  Eigen::MatrixXd values(3, 2000);
  for (int i = 0; i < values.cols(); ++i) {
    values.col(i) =
        GetParam() *
        Eigen::Vector3d(uniform(generator), 1e-6 * uniform(generator), 5.0 + uniform(generator));
  }
  ReportArrays arrays;
  const nlohmann::ordered_json info = arrays.AddQuantised(values);
  const Eigen::MatrixXd read = Read(arrays, info);
  for (int k = 0; k < 3; ++k) {
    const double range = values.row(k).maxCoeff() - values.row(k).minCoeff();
    const double rounding = 4e-16 * values.row(k).cwiseAbs().maxCoeff();
    EXPECT_NEAR(info["scale"][k].get<double>(), range / 65534.0, 1e-12 * range) << k;
    EXPECT_LE((read.row(k) - values.row(k)).cwiseAbs().maxCoeff(), range / 131068.0 + rounding);
    // The bound is no larger than it has to be.
    EXPECT_GE((read.row(k) - values.row(k)).cwiseAbs().maxCoeff(), 0.9 * range / 131068.0);
  }
}

INSTANTIATE_TEST_SUITE_P(Sizes,
                         ReportArraysSizeTest,
                         ::testing::Values(1e-300, 1e-9, 1.0, 1e12, 1e37));

TEST(ReportArraysTest, TheEndsOfARangeAreExact) {
  Eigen::MatrixXd values(1, 3);
  values << -0.125, 0.3, 7.5;
  ReportArrays arrays;
  const Eigen::MatrixXd read = Read(arrays, arrays.AddQuantised(values));
  EXPECT_EQ(read(0, 0), -0.125);
  EXPECT_DOUBLE_EQ(read(0, 2), 7.5);
}

TEST(ReportArraysTest, WhatIsNotFiniteHasNoValueAndSpoilsNoOther) {
  Eigen::MatrixXd values(2, 4);
  values << 1.0, kNaN, 3.0, std::numeric_limits<double>::infinity(), kNaN, 1e300, -1e39, kNaN;
  ReportArrays arrays;
  const nlohmann::ordered_json info = arrays.AddQuantised(values);
  const Eigen::MatrixXd read = Read(arrays, info);
  EXPECT_EQ(read(0, 0), 1.0);
  EXPECT_DOUBLE_EQ(read(0, 2), 3.0);
  EXPECT_TRUE(std::isnan(read(0, 1)));
  EXPECT_TRUE(std::isnan(read(0, 3)));
  for (int i = 0; i < 4; ++i) EXPECT_TRUE(std::isnan(read(1, i)));
  EXPECT_EQ(info["offset"][1], 0.0);
}

TEST(ReportArraysTest, EqualValuesAreExactAndTakeNoBytes) {
  ReportArrays arrays;
  const nlohmann::ordered_json info = arrays.AddQuantised(Eigen::MatrixXd::Constant(3, 50, 0.1));
  EXPECT_TRUE(info["blob"].is_null());
  EXPECT_EQ(arrays.num_bytes(), 0u);
  EXPECT_EQ(Read(arrays, info), Eigen::MatrixXd::Constant(3, 50, 0.1));
}

TEST(ReportArraysTest, FloatsAndIndicesAreLittleEndian) {
  ReportArrays arrays;
  const nlohmann::ordered_json floats = arrays.AddFloats(Eigen::Vector3d(1.0, -2.0, 0.5));
  const nlohmann::ordered_json indices = arrays.AddIndices({{1, 258, 70000}});
  EXPECT_EQ(arrays.blobs()[floats["blob"].get<int>()],
            std::string("\0\0\x80\x3f\0\0\0\xc0\0\0\0\x3f", 12));
  EXPECT_EQ(arrays.blobs()[indices["blob"].get<int>()],
            std::string("\x01\0\0\0\x02\x01\0\0\x70\x11\x01\0", 12));
  EXPECT_EQ(floats["components"], 3);
  EXPECT_EQ(floats["count"], 1);
  EXPECT_EQ(indices["type"], "u32");
}

TEST(Base64Test, MatchesTheTestVectorsOfRfc4648) {
  EXPECT_EQ(Base64(""), "");
  EXPECT_EQ(Base64("f"), "Zg==");
  EXPECT_EQ(Base64("fo"), "Zm8=");
  EXPECT_EQ(Base64("foo"), "Zm9v");
  EXPECT_EQ(Base64("foob"), "Zm9vYg==");
  EXPECT_EQ(Base64("fooba"), "Zm9vYmE=");
  EXPECT_EQ(Base64("foobar"), "Zm9vYmFy");
  EXPECT_EQ(Base64(std::string("\xff\xfe\xfd", 3)), "//79");
}

}  // namespace
}  // namespace darboux
