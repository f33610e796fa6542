#include "solver/svg_plot.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cctype>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <regex>
#include <string>
#include <vector>

namespace darboux {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

// Empty, or what is wrong: tags that do not nest, attributes without quotes, bare & or <.
std::string XmlMistake(const std::string& xml) {
  std::vector<std::string> open;
  size_t i = 0;
  const std::string prolog = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>";
  if (xml.compare(0, prolog.size(), prolog) != 0) return "no prolog";
  i = prolog.size();
  const std::regex tag(R"(^<(/?)([a-z]+)((?: [a-zA-Z0-9:\-]+="[^"<]*")*)(/?)>$)");
  const std::regex entity("&(?!(amp|lt|gt|quot);)");
  while (i < xml.size()) {
    if (xml[i] != '<') {
      const size_t end = std::min(xml.find('<', i), xml.size());
      const std::string text = xml.substr(i, end - i);
      if (std::regex_search(text, entity)) return "a bare & in '" + text + "'";
      if (open.empty() && text.find_first_not_of(" \n") != std::string::npos) return "text outside";
      i = end;
      continue;
    }
    const size_t end = xml.find('>', i);
    if (end == std::string::npos) return "no end of a tag";
    const std::string word = xml.substr(i, end - i + 1);
    std::smatch match;
    if (!std::regex_match(word, match, tag)) return "no tag: " + word;
    if (match[1] == "/") {
      if (open.empty() || open.back() != match[2]) return "does not close: " + word;
      open.pop_back();
    } else if (match[4] != "/") {
      open.push_back(match[2]);
    }
    i = end + 1;
  }
  return open.empty() ? "" : "not closed: " + open.back();
}

double Attribute(const std::string& xml, const std::string& name) {
  std::smatch match;
  const std::regex pattern(" " + name + "=\"([^\"]*)\"");
  EXPECT_TRUE(std::regex_search(xml, match, pattern)) << name;
  return std::strtod(match[1].str().c_str(), nullptr);
}

// All coordinates, of lines, marks, polygons and texts.
void ExpectInsideCanvas(const std::string& svg) {
  const double width = Attribute(svg, "width"), height = Attribute(svg, "height");
  ASSERT_GT(width, 0.0);
  ASSERT_GT(height, 0.0);
  int count = 0;
  const auto check = [&](const std::string& text, double limit) {
    char* end = nullptr;
    const double value = std::strtod(text.c_str(), &end);
    EXPECT_EQ(*end, '\0') << text;
    EXPECT_TRUE(std::isfinite(value)) << text;
    EXPECT_GE(value, 0.0);
    EXPECT_LE(value, limit);
    ++count;
  };
  const std::regex single(" (x|y|x1|x2|y1|y2|cx|cy)=\"([^\"]*)\"");
  for (std::sregex_iterator it(svg.begin(), svg.end(), single), end; it != end; ++it) {
    const std::string name = (*it)[1];
    check((*it)[2], name.find('x') != std::string::npos ? width : height);
  }
  const std::regex list(" points=\"([^\"]*)\"");
  const std::regex pair("([^, ]+),([^, ]+)");
  for (std::sregex_iterator it(svg.begin(), svg.end(), list), end; it != end; ++it) {
    const std::string points = (*it)[1];
    for (std::sregex_iterator p(points.begin(), points.end(), pair); p != end; ++p) {
      check((*p)[1], width);
      check((*p)[2], height);
    }
  }
  EXPECT_GT(count, 10);
}

SvgSeries Series(const std::string& name, std::vector<double> x, std::vector<double> y) {
  SvgSeries series;
  series.name = name;
  series.x = std::move(x);
  series.y = std::move(y);
  return series;
}

// Data of many kinds that a plot has to bear.
class SvgPlotTest : public ::testing::TestWithParam<std::vector<SvgSeries>> {};

TEST_P(SvgPlotTest, IsWellFormedAndInsideItsCanvas) {
  SvgPanel panel;
  panel.title = "error & \"time\" <s>";
  panel.x_label = "dof";
  panel.y_label = "error, %";
  panel.series = GetParam();
  panel.levels = {{1.0, "1 %"}, {1e-30, "far below"}, {-1.0, "none"}};
  const std::string svg = MakeSvg("a <title> & \x01 \xff", {panel, panel});
  EXPECT_EQ(XmlMistake(svg), "");
  ExpectInsideCanvas(svg);
  EXPECT_THAT(svg, Not(HasSubstr("nan")));
  EXPECT_THAT(svg, Not(HasSubstr("inf\"")));
}

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

INSTANTIATE_TEST_SUITE_P(
    Data,
    SvgPlotTest,
    ::testing::Values(std::vector<SvgSeries>{},
                      std::vector<SvgSeries>{Series("one point", {100.0}, {1.0})},
                      std::vector<SvgSeries>{Series("equal", {1.0, 1.0}, {2.0, 2.0})},
                      std::vector<SvgSeries>{Series("wide", {1e-12, 1e12}, {1e-300, 1e300})},
                      std::vector<SvgSeries>{
                          Series("bad", {0.0, -1.0, kNan, kInfinity}, {1.0, 1.0, 1.0, 1.0})},
                      std::vector<SvgSeries>{Series("longer x", {1.0, 2.0, 3.0}, {0.5})},
                      std::vector<SvgSeries>{Series("a", {1, 10}, {1, 2}),
                                             Series("b & c", {2, 20}, {3, 0.1}),
                                             Series("c", {1, 2}, {1, 2}),
                                             Series("d", {1, 2}, {1, 3}),
                                             Series("e", {1, 2}, {1, 4}),
                                             Series("f", {1, 2}, {1, 5}),
                                             Series("g", {1, 2}, {1, 6}),
                                             Series("h", {1, 2}, {1, 7}),
                                             Series("i", {1, 2}, {1, 8}),
                                             Series("j", {1, 2}, {1, 9})}));

TEST(SvgPlotTest, LargerErrorsStandHigherAndMoreSecondsFurtherRight) {
  SvgPanel panel;
  panel.series = {Series("s", {1.0, 10.0, 100.0}, {1.0, 0.1, 0.01})};
  const std::string svg = MakeSvg("", {panel});
  std::smatch match;
  ASSERT_TRUE(std::regex_search(svg, match, std::regex("polyline points=\"([^\"]*)\"")));
  double x[3], y[3];
  ASSERT_EQ(std::sscanf(match[1].str().c_str(),
                        "%lf,%lf %lf,%lf %lf,%lf",
                        &x[0],
                        &y[0],
                        &x[1],
                        &y[1],
                        &x[2],
                        &y[2]),
            6);
  // Logarithmic: equal steps. SVG's y grows downwards.
  EXPECT_GT(x[1], x[0]);
  EXPECT_NEAR(x[2] - x[1], x[1] - x[0], 0.02);
  EXPECT_GT(y[1], y[0]);
  EXPECT_NEAR(y[2] - y[1], y[1] - y[0], 0.02);
}

TEST(SvgPlotTest, SaysWhatIsDrawn) {
  SvgPanel panel;
  panel.title = "cost";
  panel.x_label = "seconds";
  panel.y_label = "error";
  panel.series = {Series("coarse", {0.01, 3.0}, {20.0, 0.2})};
  panel.levels = {{1.0, "one per cent"}, {1e-9, "far below"}};
  const std::string svg = MakeSvg("What it costs", {panel});
  for (const char* text : {"What it costs",
                           ">cost<",
                           ">seconds<",
                           ">error<",
                           ">coarse<",
                           ">one per cent<",
                           ">0.1<",
                           ">1<",
                           ">10<"}) {
    EXPECT_THAT(svg, HasSubstr(text));
  }
  EXPECT_THAT(svg, Not(HasSubstr("far below")));
}

}  // namespace
}  // namespace darboux
