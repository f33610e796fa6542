#include "geometry/point_cloud.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <limits>
#include <locale>
#include <random>
#include <string>
#include <vector>

namespace darboux {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::StartsWith;

PointCloud Parse(const std::string& contents) {
  PointCloud cloud;
  std::string error;
  EXPECT_TRUE(ParsePointCloud(contents, "scan.csv", &cloud, &error)) << error;
  return cloud;
}

std::string ParseError(const std::string& contents) {
  PointCloud cloud;
  cloud.points.emplace_back(7, 7, 7);
  std::string error;
  EXPECT_FALSE(ParsePointCloud(contents, "scan.csv", &cloud, &error)) << contents;
  EXPECT_EQ(cloud.points.size(), 1u);  // Unchanged.
  EXPECT_EQ(error.find('\n'), std::string::npos);
  return error;
}

class TemporaryFile {
 public:
  explicit TemporaryFile(const std::string& ending)
      : name_((std::filesystem::path(::testing::TempDir()) /
               ("point_cloud_" + std::to_string(std::random_device()()) + ending))
                  .string()) {}
  ~TemporaryFile() { std::filesystem::remove(name_); }
  const std::string& name() const { return name_; }
  void Write(const std::string& contents) const {
    std::ofstream(name_, std::ios::binary) << contents;
  }

 private:
  std::string name_;
};

PointCloud Read(const std::string& contents, const std::string& ending) {
  const TemporaryFile file(ending);
  file.Write(contents);
  PointCloud cloud;
  std::string error;
  EXPECT_TRUE(ReadPointCloud(file.name(), &cloud, &error)) << error;
  return cloud;
}

std::string ReadError(const std::string& contents, const std::string& ending) {
  const TemporaryFile file(ending);
  file.Write(contents);
  PointCloud cloud;
  std::string error;
  EXPECT_FALSE(ReadPointCloud(file.name(), &cloud, &error));
  EXPECT_THAT(error, StartsWith(file.name() + ":"));
  return error.substr(file.name().size());
}

bool IsSame(const std::vector<Eigen::Vector3d>& a, const std::vector<Eigen::Vector3d>& b) {
  return a.size() == b.size() &&
         (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(a[0])) == 0);
}

// --- Columns ------------------------------------------------------------------------------------

TEST(PointCloudTest, ColumnsWithoutNamesGoByTheirNumber) {
  const PointCloud three = Parse("1,2,3\n4,5,6\n");
  EXPECT_THAT(three.points, ElementsAre(Eigen::Vector3d(1, 2, 3), Eigen::Vector3d(4, 5, 6)));
  EXPECT_THAT(three.normals, IsEmpty());
  EXPECT_THAT(three.displacements, IsEmpty());
  const PointCloud six = Parse("1 2 3 0 0 1\n4 5 6 0 0.6 0.8\n");
  EXPECT_THAT(six.points, ElementsAre(Eigen::Vector3d(1, 2, 3), Eigen::Vector3d(4, 5, 6)));
  EXPECT_THAT(six.normals, ElementsAre(Eigen::Vector3d(0, 0, 1), Eigen::Vector3d(0, 0.6, 0.8)));
  const PointCloud four = Parse("1 2 0.1 0.2\n");
  EXPECT_THAT(four.points, ElementsAre(Eigen::Vector3d(1, 2, 0)));
  EXPECT_THAT(four.displacements, ElementsAre(Eigen::Vector3d(0.1, 0.2, 0)));
}

TEST(PointCloudTest, NamesComeInAnyOrderAndCaseWithOthersBetween) {
  const PointCloud cloud = Parse(
      "quality,UZ,Z,\"Y\",label,nz,X,ny,nx,uy,ux\n"
      "good,9,3,2,red,1,1,0,0,8,7\n"
      ",-9,30,20,,0,10,0,-1,-8,-7\n");
  EXPECT_THAT(cloud.points, ElementsAre(Eigen::Vector3d(1, 2, 3), Eigen::Vector3d(10, 20, 30)));
  EXPECT_THAT(cloud.normals, ElementsAre(Eigen::Vector3d(0, 0, 1), Eigen::Vector3d(-1, 0, 0)));
  EXPECT_THAT(cloud.displacements,
              ElementsAre(Eigen::Vector3d(7, 8, 9), Eigen::Vector3d(-7, -8, -9)));
}

TEST(PointCloudTest, APlaneFieldHasNoZ) {
  const PointCloud cloud = Parse("x;y;ux;uy\n1;2;3;4\n");
  EXPECT_THAT(cloud.points, ElementsAre(Eigen::Vector3d(1, 2, 0)));
  EXPECT_THAT(cloud.displacements, ElementsAre(Eigen::Vector3d(3, 4, 0)));
  EXPECT_THAT(Parse("x,y,ux,uy,uz\n1,2,3,4,5\n").displacements,
              ElementsAre(Eigen::Vector3d(3, 4, 5)));
}

TEST(PointCloudTest, LongNamesWithUnitsStandForShortOnes) {
  const PointCloud cloud = Parse(
      "x-coordinate [mm],y-coordinate [mm],x-displacement [mm],y-displacement [mm]\n"
      "1,2,3,4\n");
  EXPECT_THAT(cloud.points, ElementsAre(Eigen::Vector3d(1, 2, 0)));
  EXPECT_THAT(cloud.displacements, ElementsAre(Eigen::Vector3d(3, 4, 0)));
  EXPECT_FALSE(cloud.has_uz);
  const PointCloud solid = Parse(
      "Displacement_Z (m);u_y;U X;\"Z position\";coord.y;X [m];normal-x;n_y;nz\n"
      "9;8;7;3;2;1;0;0;1\n");
  EXPECT_THAT(solid.points, ElementsAre(Eigen::Vector3d(1, 2, 3)));
  EXPECT_THAT(solid.normals, ElementsAre(Eigen::Vector3d(0, 0, 1)));
  EXPECT_THAT(solid.displacements, ElementsAre(Eigen::Vector3d(7, 8, 9)));
  EXPECT_TRUE(solid.has_uz);
}

TEST(PointCloudTest, AShortNameComesBeforeALongOne) {
  const PointCloud cloud = Parse("x-coordinate [px],x,y,y strain,x_velocity\n1,2,3,4,5\n");
  EXPECT_THAT(cloud.points, ElementsAre(Eigen::Vector3d(2, 3, 0)));
  EXPECT_THAT(ParseError("x-coordinate,x-position,y\n1,2,3\n"), HasSubstr("a second column 'x'"));
}

TEST(PointCloudTest, UnitsAreNotMixed) {
  EXPECT_THAT(ParseError("x [mm],y [mm],u_x [um],u_y [um]\n1,2,3,4\n"),
              HasSubstr(":1: found columns in 'mm' and in 'um'; allowed one unit of length"));
}

TEST(PointCloudTest, APlaneFieldIsWrittenAsOne) {
  const TemporaryFile file(".csv");
  const PointCloud cloud = Parse("x,y,ux,uy\n1,2,3,4\n");
  std::string error;
  ASSERT_TRUE(WritePointCloud(file.name(), cloud, {}, &error)) << error;
  PointCloud back;
  ASSERT_TRUE(ReadPointCloud(file.name(), &back, &error)) << error;
  EXPECT_FALSE(back.has_uz);
  EXPECT_EQ(back.displacements, cloud.displacements);
}

TEST(PointCloudTest, ALineOfNamesMayBeAComment) {  // As numpy.savetxt writes it.
  const PointCloud cloud = Parse("# made by hand\n# x y z ux uy uz\n1 2 3 0 0 1\n");
  EXPECT_THAT(cloud.normals, IsEmpty());
  EXPECT_THAT(cloud.displacements, ElementsAre(Eigen::Vector3d(0, 0, 1)));
  // Names that are none are the comment of somebody.
  EXPECT_THAT(Parse("# x y z and normals\n1 2 3 0 0 1\n").normals,
              ElementsAre(Eigen::Vector3d(0, 0, 1)));
  // A real line of names is the better one.
  EXPECT_THAT(Parse("# z y x\nx,y,z\n1,2,3\n").points, ElementsAre(Eigen::Vector3d(1, 2, 3)));
}

TEST(PointCloudTest, SixColumnsThatAreNoNormalsNeedNames) {
  EXPECT_EQ(ParseError("1,2,3,0,0,1\n1,2,3,0,0,0.5\n"),
            "scan.csv:2: found 6 columns without names, of which the last three have the length "
            "0.5; allowed unit normals, or a first line of names such as x,y,z,ux,uy,uz");
}

TEST(PointCloudTest, NormalsBecomeUnitVectorsAndUnitOnesStay) {
  const PointCloud cloud = Parse(
      "x,y,z,nx,ny,nz\n0,0,0,3,0,4\n0,0,0,1e-200,0,0\n0,0,0,0,-1e300,0\n"
      "0,0,0,0.48,0.6,0.64\n");
  EXPECT_TRUE(cloud.normals[0].isApprox(Eigen::Vector3d(0.6, 0, 0.8), 1e-15));
  EXPECT_EQ(cloud.normals[1], Eigen::Vector3d(1, 0, 0));
  EXPECT_EQ(cloud.normals[2], Eigen::Vector3d(0, -1, 0));
  EXPECT_EQ(cloud.normals[3], Eigen::Vector3d(0.48, 0.6, 0.64));
  EXPECT_EQ(ParseError("x,y,z,nx,ny,nz\n0,0,0,1,0,0\n0,0,0,0,0,0\n0,0,0,0,0,0\n"),
            "scan.csv:3: found a normal of no length, the first of 2 points that are without one; "
            "allowed a direction at every point, or no normals at all");
}

// --- Text ---------------------------------------------------------------------------------------

TEST(PointCloudTest, SeparatorsLineEndsAndCommentsDoNotMatter) {
  const std::vector<Eigen::Vector3d> expected = {{1, -2.5, 3e-3}, {4, 5, 6}};
  for (const char* text : {"1,-2.5,3e-3\n4,5,6\n",
                           "1;-2.5;3e-3\n4;5;6",
                           "1\t-2.5\t3e-3\n4\t5\t6\n",
                           "1 -2.5 3e-3\n4 5 6\n",
                           "  1 \t -2.5   3e-3  \n\t4 5 6\t\n",
                           " 1 , -2.5,\t3e-3\n4 ,5 , 6 \n",
                           "1,-2.5,3e-3,\n4,5,6,\n",
                           "1,-2.5,3e-3\r\n4,5,6\r\n",
                           "1,-2.5,3e-3\r4,5,6\r",
                           "\xEF\xBB\xBF"
                           "1,-2.5,3e-3\n4,5,6\n",
                           "\xEF\xBB\xBFx,y,z\r\n1,-2.5,3e-3\r\n4,5,6\r\n",
                           "x,y,z,\n1,-2.5,3e-3,\n4,5,6,\n",
                           "# by hand\n\n+1,-2.5,+.3e-2 # the first\n\n   # none\n4,5,6\n\n"}) {
    EXPECT_TRUE(IsSame(Parse(text).points, expected)) << text;
  }
}

TEST(PointCloudTest, NumbersHaveADecimalPointWhateverTheLocale) {
  struct Comma : std::numpunct<char> {
    char do_decimal_point() const override { return ','; }
    char do_thousands_sep() const override { return '.'; }
    std::string do_grouping() const override { return "\3"; }
  };
  const std::locale before = std::locale::global(std::locale(std::locale::classic(), new Comma));
  EXPECT_THAT(Parse("1.5 1234.5 2e3\n").points, ElementsAre(Eigen::Vector3d(1.5, 1234.5, 2e3)));
  const TemporaryFile file(".csv");
  PointCloud cloud, back;
  cloud.points.emplace_back(1234567.5, 0.25, 1e-7);
  std::string error;
  EXPECT_TRUE(WritePointCloud(file.name(), cloud, {}, &error)) << error;
  EXPECT_TRUE(ReadPointCloud(file.name(), &back, &error)) << error;
  EXPECT_TRUE(IsSame(cloud.points, back.points));
  std::locale::global(before);
  // A decimal comma is never taken for a separator unnoticed.
  EXPECT_THAT(ParseError("1,5 2,5 3,5\n"), StartsWith("scan.csv:1: found '5 2' "));
  EXPECT_EQ(
      ParseError("1,5;2,5;3,5\n"),
      "scan.csv:1: found '1,5', neither a number nor the name of a column; allowed numbers with "
      "a decimal point, or names of which x y z are some");
}

TEST(PointCloudTest, BadLinesAreNamed) {
  EXPECT_EQ(ParseError("1,2,3\n1,2.o,3\n"),
            "scan.csv:2: found '2.o' as y; allowed a number in the range of a double, with a "
            "decimal point");
  EXPECT_THAT(ParseError("1,2,3\n1,,3\n"), StartsWith("scan.csv:2: found '' as y;"));
  EXPECT_THAT(ParseError("1,2,1e999\n"), StartsWith("scan.csv:1: found '1e999' as z;"));
  EXPECT_EQ(ParseError("# a\n1,2,3\n1,2\n"),
            "scan.csv:3: found 2 columns; allowed 3, as on the lines before");
  EXPECT_EQ(ParseError("x,y,z\n1,2,3\n1,2,3,4\n"),
            "scan.csv:3: found 4 columns; allowed 3, which line 1 names");
  EXPECT_EQ(ParseError("1,2,3,4,5\n"),
            "scan.csv:1: found 5 columns and no line of names; allowed 3 (x y z), 4 (x y ux uy), 6 "
            "(x y z nx ny nz), or a first line of names");
  EXPECT_THAT(ParseError("1\n"), StartsWith("scan.csv:1: found 1 column and no line of names;"));
}

TEST(PointCloudTest, BadNamesAreNamed) {
  EXPECT_EQ(ParseError("x,z\n1,2\n"),
            "scan.csv:1: found columns 'x', 'z' without 'y'; allowed x y z, or x y in a plane, "
            "with nx ny nz or ux uy uz or others beside them");
  EXPECT_EQ(ParseError("x,y,z,X\n1,2,3,4\n"), "scan.csv:1: found a second column 'x'; allowed one");
  EXPECT_THAT(ParseError("x,y,z,nx,nz\n1,2,3,1,0\n"),
              HasSubstr("without all of nx ny nz; allowed all three or none"));
  EXPECT_THAT(ParseError("x,y,z,ux,uz\n1,2,3,1,0\n"), HasSubstr("without ux and uy; allowed"));
}

TEST(PointCloudTest, PointsThatAreNotFiniteAreNamedAndCounted) {
  EXPECT_EQ(ParseError("1,2,3\n1,nan,inf\n"),
            "scan.csv:2: found 'nan' as y; allowed finite numbers");
  EXPECT_EQ(ParseError("x,y,z,ux,uy\n1,2,3,0,0\n\n1,2,-inf,0,0\n1,2,3,0,NaN\nnan,nan,nan,0,0\n"),
            "scan.csv:4: found '-inf' as z, the first of 3 points that are not finite; allowed "
            "finite numbers");
  EXPECT_THAT(Parse("x,y,z,quality\n1,2,3,nan\n").points, ElementsAre(Eigen::Vector3d(1, 2, 3)));
}

TEST(PointCloudTest, AFileWithoutPointsIsAnError) {
  EXPECT_EQ(ParseError(""),
            "scan.csv:0: found an empty file; allowed a line of numbers for each point");
  for (const char* text : {"\n\n", "# nothing\n", "x,y,z\n", "\xEF\xBB\xBF"}) {
    EXPECT_THAT(ParseError(text), HasSubstr("found no points; allowed a line of numbers")) << text;
  }
  EXPECT_THAT(ReadError("", ".csv"), StartsWith(":0: found an empty file"));
}

TEST(PointCloudTest, AnyBytesAreSafeToRead) {
  std::mt19937_64 random(38401);
  const std::string alphabet = "0123456789.,;+-eE \t\r\n#xyznu\"\0\xff/";
  for (int i = 0; i < 3000; ++i) {
    std::string text = i % 2 == 0 ? "" : "x,y,z\n";
    for (std::size_t n = random() % 60; n > 0; --n) text += alphabet[random() % alphabet.size()];
    PointCloud cloud;
    std::string error;
    if (ParsePointCloud(text, "scan.csv", &cloud, &error)) {
      EXPECT_FALSE(cloud.empty());
    } else {
      EXPECT_THAT(error, HasSubstr("; allowed ")) << text;
      EXPECT_EQ(error.find('\n'), std::string::npos);
    }
  }
}

// --- Files --------------------------------------------------------------------------------------

TEST(PointCloudTest, MeshFilesGiveTheirVertices) {
  const std::vector<Eigen::Vector3d> expected = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {5, 5, 5}};
  EXPECT_TRUE(
      IsSame(Read("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 5 5 5\nf 1 2 3\n", ".obj").points, expected));
  EXPECT_TRUE(IsSame(Read("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 5 5 5\n", ".OBJ").points, expected));
  EXPECT_TRUE(
      IsSame(Read("OFF\n4 1 0\n0 0 0\n1 0 0\n0 1 0\n5 5 5\n3 0 1 2\n", ".off").points, expected));
  EXPECT_EQ(Read("solid\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\n"
                 "endloop\nendfacet\nendsolid\n",
                 ".stl")
                .points.size(),
            3u);
  for (const char* ending : {".csv", ".txt", ".xyz", ".CSV"}) {
    EXPECT_TRUE(IsSame(Read("0 0 0\n1 0 0\n0 1 0\n5 5 5\n", ending).points, expected)) << ending;
  }
}

constexpr char kPlyHeader[] = "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\n";

TEST(PointCloudTest, PlyHasNormalsAndDisplacementsAmongOtherProperties) {
  const PointCloud cloud =
      Read(std::string(kPlyHeader) +
               "property float nz\nproperty float y\nproperty uchar red\nproperty float z\n"
               "property float nx\nproperty float ny\nproperty double uy\nproperty double ux\n"
               "end_header\n1 2 2 255 3 0 0 5 4\n10 0 20 0 30 -2 0 50 40\n",
           ".ply");
  EXPECT_THAT(cloud.points, ElementsAre(Eigen::Vector3d(1, 2, 3), Eigen::Vector3d(10, 20, 30)));
  EXPECT_THAT(cloud.normals, ElementsAre(Eigen::Vector3d(0, 0, 1), Eigen::Vector3d(-1, 0, 0)));
  EXPECT_THAT(cloud.displacements,
              ElementsAre(Eigen::Vector3d(4, 5, 0), Eigen::Vector3d(40, 50, 0)));
  EXPECT_THAT(Read(std::string(kPlyHeader) +
                       "property float y\nproperty float z\nproperty float nx\nend_header\n"
                       "1 2 3 0\n1 2 3 0\n",
                   ".ply")
                  .normals,
              IsEmpty());
}

TEST(PointCloudTest, MeshFilesNameThePointThatIsNotFinite) {
  const std::string xyz = std::string(kPlyHeader) + "property float y\nproperty float z\n";
  EXPECT_EQ(ReadError(xyz + "end_header\n1 2 3\n1 nan 3\n", ".ply"),
            ":0: found 'nan' as y of point 1; allowed finite numbers");
  EXPECT_EQ(ReadError(xyz + "end_header\n1 2 inf\n1 nan 3\n", ".ply"),
            ":0: found 'inf' as z of point 0, the first of 2 points that are not finite; allowed "
            "finite numbers");
  EXPECT_EQ(ReadError(xyz + "property float nx\nproperty float ny\nproperty float nz\nend_header\n"
                            "1 2 3 0 0 1\n1 2 3 0 0 0\n",
                      ".ply"),
            ":0: found at point 1 a normal of no length; allowed a direction at every point, or no "
            "normals at all");
  EXPECT_THAT(ReadError("v 1 2\n", ".obj"), StartsWith(":1: found a vertex with 2 coordinates"));
  EXPECT_THAT(ReadError("", ".ply"), StartsWith(":0: found an empty file"));
}

TEST(PointCloudTest, FilesThatAreNoneOfTheseAreRefused) {
  PointCloud cloud;
  std::string error;
  EXPECT_FALSE(ReadPointCloud("missing.csv", &cloud, &error));
  EXPECT_THAT(error, StartsWith("missing.csv:0: found a file that cannot be read ("));
  EXPECT_FALSE(ReadPointCloud("missing.ply", &cloud, &error));
  EXPECT_THAT(error, StartsWith("missing.ply:0: found a file that cannot be read ("));
  EXPECT_FALSE(ReadPointCloud("scan.csw", &cloud, &error));
  EXPECT_EQ(error,
            "scan.csw:0: found a name that ends with '.csw'; allowed .csv | .txt | .xyz | .ply | "
            ".obj | .stl | .off; did you mean '.csv'?");
}

PointCloud HardCloud(bool normals, bool displacements) {
  std::mt19937_64 random(11);
  PointCloud cloud;
  const auto any = [&] {  // Any finite bits.
    for (;;) {
      const std::uint64_t bits = random();
      double value;
      std::memcpy(&value, &bits, sizeof(value));
      if (std::isfinite(value)) return value;
    }
  };
  for (int i = 0; i < 500; ++i) {
    cloud.points.emplace_back(any(), any(), any());
    const Eigen::Vector3d direction(std::sin(i), std::cos(3 * i), 0.1 * i - 20);
    if (normals) cloud.normals.push_back(direction.normalized());
    if (displacements) cloud.displacements.emplace_back(any(), any(), any());
  }
  cloud.points[0] = {-0.0, 0.0, std::numeric_limits<double>::denorm_min()};
  cloud.points[1] = {std::numeric_limits<double>::max(), std::numeric_limits<double>::min(), 0.1};
  return cloud;
}

TEST(PointCloudTest, WhatIsWrittenReadsBackBitForBit) {
  for (const char* ending : {".csv", ".ply"}) {
    for (const bool normals : {false, true}) {
      for (const bool displacements : {false, true}) {
        const PointCloud cloud = HardCloud(normals, displacements);
        const TemporaryFile file(ending);
        std::string error;
        ASSERT_TRUE(WritePointCloud(
            file.name(), cloud, {"seed: 7", "x y z", "two\nlines", "", "# 1,2,3"}, &error))
            << error;
        PointCloud back;
        ASSERT_TRUE(ReadPointCloud(file.name(), &back, &error)) << error;
        EXPECT_TRUE(IsSame(cloud.points, back.points)) << ending;
        EXPECT_TRUE(IsSame(cloud.normals, back.normals)) << ending;
        EXPECT_TRUE(IsSame(cloud.displacements, back.displacements)) << ending;
      }
    }
  }
}

TEST(PointCloudTest, WhatCouldNotBeReadBackIsNotWritten) {
  const TemporaryFile file(".csv");
  PointCloud cloud;
  std::string error;
  EXPECT_FALSE(WritePointCloud(file.name(), cloud, {}, &error));
  EXPECT_THAT(error, HasSubstr(":0: found no points to write; allowed one at least"));
  cloud.points = {{0, 0, 0}, {0, NAN, 0}};
  EXPECT_FALSE(WritePointCloud(file.name(), cloud, {}, &error));
  EXPECT_THAT(error, HasSubstr("as y of point 1; allowed finite numbers"));
  cloud.points[1] = {1, 1, 1};
  EXPECT_FALSE(std::filesystem::exists(file.name()));
  EXPECT_FALSE(WritePointCloud("scan.obj", cloud, {}, &error));
  EXPECT_EQ(error, "scan.obj:0: found a name that ends with '.obj'; allowed .csv | .ply");
  EXPECT_FALSE(WritePointCloud("no_such_folder/scan.csv", cloud, {}, &error));
  EXPECT_THAT(error, StartsWith("no_such_folder/scan.csv:0: found a file that cannot be written"));
}

TEST(PointCloudTest, TheExtentIsTheDiagonalOfTheBoundingBox) {
  EXPECT_EQ(Extent({}), 0.0);
  EXPECT_EQ(Extent({{5, 5, 5}}), 0.0);
  EXPECT_DOUBLE_EQ(Extent({{1, 10, 0}, {0, 12, 1}, {1, 11, 2}}), 3.0);
}

}  // namespace
}  // namespace darboux
