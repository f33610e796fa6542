#include "tools/html_report.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "tests/solve_util.h"

namespace darboux {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

int Count(const std::string& text, const std::string& part) {
  int count = 0;
  for (size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++count;
  return count;
}

constexpr char kHostile[] =
    "</script><script>alert(1)</script><!--\xe2\x80\xa8<img src=x onerror=alert(2)>&amp;\"'";

TEST(JsonForHtmlTest, NothingEndsTheElementAndAllIsReadBack) {
  const nlohmann::ordered_json json = {{kHostile, kHostile}, {"n", 0.1}};
  const std::string text = JsonForHtml(json);
  for (const char* part : {"<", ">", "&", "\xe2\x80\xa8"}) EXPECT_THAT(text, Not(HasSubstr(part)));
  EXPECT_EQ(nlohmann::ordered_json::parse(text), json);
}

TEST(JsonForHtmlTest, TextThatIsNoUtf8IsReplaced) {
  EXPECT_EQ(JsonForHtml(std::string("a\xff") + "b"),
            "\"a\xef\xbf\xbd"
            "b\"");
}

TEST(TextForHtmlTest, HasNoMarkup) {
  EXPECT_EQ(TextForHtml("<a href=\"x\">'&"), "&lt;a href=&quot;x&quot;&gt;&#39;&amp;");
}

TEST(MakeReportHtmlTest, AHostileNameAddsNoElement) {
  if (!HasReportPage()) GTEST_SKIP() << NoReportPage();
  const auto page = [](const std::string& name) {
    Report report = MakeReport("tool", name);
    report.arrays.AddFloats(Eigen::Vector3d(1.0, 2.0, 3.0));
    report.header["documents"]["summary"] = {{"name", name}, {name, name}};
    return MakeReportHtml(report);
  };
  const std::string plain = page("plain"), hostile = page(kHostile);
  for (const char* part : {"<script", "</script", "<!--", "<img", "<title"}) {
    EXPECT_EQ(Count(hostile, part), Count(plain, part)) << part;
  }
  EXPECT_EQ(Count(plain, "<script"), 3);  // header, one array, the page's own
  EXPECT_THAT(hostile, HasSubstr("<title>&lt;/script&gt;"));
  // The marks are gone, and data comes before what reads it.
  EXPECT_THAT(plain, Not(HasSubstr("<!--darboux:")));
  EXPECT_LT(plain.find("id=\"darboux-header\""), plain.find("id=\"darboux-0\""));
  EXPECT_THAT(plain, HasSubstr("AACAPwAAAEAAAEBA"));
}

TEST(MakeReportHtmlTest, ThePageAsksForNothingAndNamesItsLibraries) {
  if (!HasReportPage()) GTEST_SKIP() << NoReportPage();
  const std::string page = MakeReportHtml(MakeReport("tool", "name"));
  EXPECT_THAT(page, HasSubstr("default-src 'none'; script-src 'sha256-"));
  for (const char* part : {" src=\"http", "<link", "@import", "url(http"}) {
    EXPECT_THAT(page, Not(HasSubstr(part)));
  }
  for (const char* package : {"three ", "chart.js ", "@kurkle/color "}) {
    EXPECT_THAT(page, HasSubstr(package));
  }
  EXPECT_GE(Count(page, "Permission is hereby granted"), 3);
  EXPECT_LT(page.size(), 1u << 20);
}

TEST(MakeReportHtmlTest, AReportOfFiftyThousandTrianglesIsSmall) {
  if (!HasReportPage()) GTEST_SKIP() << NoReportPage();
  Scene scene = SceneFromData("clamped_plate.yaml");
  scene.surface.divisions = {80, 80};
  const Solution solution = SolveScene(scene);
  const Report report = MakeSceneReport("tool", *solution.problem, solution.summary, {});
  EXPECT_GE(report.header["views"][0]["triangles"], 50000);
  EXPECT_LT(MakeReportHtml(report).size(), 10u << 20);
}

}  // namespace
}  // namespace darboux
