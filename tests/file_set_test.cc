#include "solver/file_set.h"

#include <filesystem>
#include <fstream>
#include <set>
#include <string>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/temporary_folder.h"

namespace darboux {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

class FileSetTest : public FolderTest {
 protected:
  std::set<std::string> Names() const { return FilesIn(folder_); }

  std::string error_;
};

TEST_F(FileSetTest, FilesAppearWhenAllAreThere) {
  std::ofstream(folder_ / "a") << "old";
  FileSet files(folder_.string());
  ASSERT_TRUE(files.Add("a", "new", &error_));
  ASSERT_TRUE(files.Add("b", std::string("\0\r\n", 3), &error_));
  EXPECT_EQ(Names(), (std::set<std::string>{"a", "a.part", "b.part"}));
  EXPECT_EQ(Read("a"), "old");
  ASSERT_TRUE(files.Commit(&error_)) << error_;
  EXPECT_EQ(Names(), (std::set<std::string>{"a", "b"}));
  EXPECT_EQ(Read("a"), "new");
  EXPECT_EQ(Read("b"), std::string("\0\r\n", 3));
}

TEST_F(FileSetTest, WhatIsOutdatedGoesWithTheCommitUnlessItIsAdded) {
  for (const char* name : {"a", "b", "c"}) std::ofstream(folder_ / name) << "old";
  FileSet files(folder_.string());
  files.Outdate("a");
  files.Outdate("b");
  files.Outdate("never there");
  ASSERT_TRUE(files.Add("b", "new", &error_));
  EXPECT_EQ(Read("a"), "old");
  ASSERT_TRUE(files.Commit(&error_)) << error_;
  EXPECT_EQ(Names(), (std::set<std::string>{"b", "c"}));
  EXPECT_EQ(Read("b"), "new");
}

TEST_F(FileSetTest, NothingIsLeftOfWhatIsNotCommitted) {
  std::ofstream(folder_ / "a") << "old";
  fs::create_directory(folder_ / "b");
  {
    FileSet files(folder_.string());
    ASSERT_TRUE(files.Add("a", "new", &error_));
    ASSERT_TRUE(files.Add("b", "new", &error_));
    EXPECT_FALSE(files.Commit(&error_));
    EXPECT_THAT(error_, HasSubstr("b: is a folder, cannot be replaced"));
  }
  EXPECT_EQ(Names(), (std::set<std::string>{"a", "b"}));
  EXPECT_EQ(Read("a"), "old");
  FileSet nowhere((folder_ / "missing").string());
  EXPECT_FALSE(nowhere.Add("a", "new", &error_));
  EXPECT_THAT(error_, HasSubstr("a: cannot be written: "));
}

TEST_F(FileSetTest, FoldersAreMadeWhereTheyCanBe) {
  const std::string deep = (folder_ / "x" / "y" / "").string();
  EXPECT_TRUE(IsWritableFolder(deep, &error_));
  EXPECT_FALSE(fs::exists(folder_ / "x"));
  EXPECT_TRUE(MakeFolder(deep, &error_)) << error_;
  EXPECT_TRUE(fs::is_directory(deep));
  std::ofstream(folder_ / "file") << "text";
  for (const char* name : {"file", "file/below"}) {
    EXPECT_FALSE(IsWritableFolder((folder_ / name).string(), &error_)) << name;
    EXPECT_FALSE(MakeFolder((folder_ / name).string(), &error_));
    EXPECT_THAT(error_, HasSubstr("is no folder"));
  }
  EXPECT_FALSE(IsWritableFolder("", &error_));
}

}  // namespace
}  // namespace darboux
