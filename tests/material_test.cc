#include "costs/material.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>

namespace darboux {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

Material Steel() {
  Material material;
  material.thickness = 1e-3;
  material.young_modulus = 2.1e11;
  material.poisson_ratio = 0.3;
  material.density = 7850.0;
  return material;
}

TEST(MaterialTest, StiffnessesArePlaneStress) {
  const Material steel = Steel();
  EXPECT_DOUBLE_EQ(steel.MembraneStiffness(), 2.1e8 / 0.91);                // N/m
  EXPECT_DOUBLE_EQ(steel.BendingStiffness(), 2.1e11 * 1e-9 / 12.0 / 0.91);  // N m
}

TEST(MaterialTest, RubberHasFiniteStiffness) {
  Material rubber = Steel();
  rubber.poisson_ratio = 0.5;
  std::string error;
  EXPECT_TRUE(rubber.IsValid(&error)) << error;
  EXPECT_DOUBLE_EQ(rubber.MembraneStiffness(), 2.1e8 / 0.75);
}

TEST(MaterialTest, WeightlessIsValid) {
  Material material = Steel();
  material.density = 0.0;
  std::string error;
  EXPECT_TRUE(material.IsValid(&error)) << error;
}

TEST(MaterialTest, DefaultIsNotValid) {
  std::string error;
  EXPECT_FALSE(Material().IsValid(&error));
}

struct Mistake {
  double Material::*member;
  double value;
  const char* named;
};

class MaterialMistakeTest : public ::testing::TestWithParam<Mistake> {};

TEST_P(MaterialMistakeTest, IsNamed) {
  Material material = Steel();
  material.*GetParam().member = GetParam().value;
  std::string error;
  EXPECT_FALSE(material.IsValid(&error));
  EXPECT_THAT(error, ::testing::HasSubstr(GetParam().named));
}

INSTANTIATE_TEST_SUITE_P(
    Members,
    MaterialMistakeTest,
    ::testing::Values(Mistake{&Material::thickness, 0.0, "thickness"},
                      Mistake{&Material::thickness, -1e-3, "thickness"},
                      Mistake{&Material::thickness, kNan, "thickness"},
                      Mistake{&Material::thickness, kInfinity, "thickness"},
                      Mistake{&Material::young_modulus, 0.0, "young_modulus"},
                      Mistake{&Material::young_modulus, kNan, "young_modulus"},
                      Mistake{&Material::young_modulus, kInfinity, "young_modulus"},
                      Mistake{&Material::poisson_ratio, -1.0, "poisson_ratio"},
                      Mistake{&Material::poisson_ratio, 0.5000001, "poisson_ratio"},
                      Mistake{&Material::poisson_ratio, kNan, "poisson_ratio"},
                      Mistake{&Material::density, -1.0, "density"},
                      Mistake{&Material::density, kNan, "density"},
                      Mistake{&Material::density, kInfinity, "density"}));

}  // namespace
}  // namespace darboux
