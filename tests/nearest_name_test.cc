#include "geometry/nearest_name.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace darboux {
namespace {

TEST(NearestNameTest, FindsMisspeltWordsOnly) {
  const std::vector<std::string> known = {"thickness", "young_modulus", "density", "u"};
  EXPECT_EQ(NearestName("thicknes", known), "thickness");
  EXPECT_EQ(NearestName("Thickness", known), "thickness");
  EXPECT_EQ(NearestName("youngs_modulus", known), "young_modulus");
  EXPECT_EQ(NearestName("desnity", known), "density");
  EXPECT_EQ(NearestName("E", known), "");
  EXPECT_EQ(NearestName("", known), "");
  EXPECT_EQ(NearestName("damping", known), "");
  EXPECT_EQ(NearestName(std::string(100000, 'x'), known), "");
  EXPECT_EQ(NearestName("thickness", {}), "");
}

TEST(NearestNameTest, CaseAndSwapsCountLessInAFormula) {
  const std::vector<std::string> known = {"u", "sin", "sinh"};
  EXPECT_EQ(NearestName("SIN", known, Spelling::kFormula), "sin");
  EXPECT_EQ(NearestName("SIN", known), "");
  EXPECT_EQ(NearestName("sni", known, Spelling::kFormula), "sin");
  EXPECT_EQ(NearestName("sni", known), "");
  EXPECT_EQ(NearestName("U", known, Spelling::kFormula), "u");
  EXPECT_EQ(NearestName("uv", known, Spelling::kFormula), "");
  EXPECT_EQ(NearestName("uv", known), "u");
}

TEST(NearestNameTest, TheFirstOfSeveralWins) {
  EXPECT_EQ(NearestName("aac", {"aab", "aaa"}), "aab");
  EXPECT_EQ(NearestName("aac", {"aab", "aac"}), "aac");
}

}  // namespace
}  // namespace darboux
