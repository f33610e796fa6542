#include "solver/svg_plot.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <iterator>
#include <limits>

namespace darboux {
namespace {

// The canvas, in px.
constexpr double kPanelWidth = 470.0, kPanelHeight = 390.0;
constexpr double kLeft = 66.0, kRight = 22.0, kTop = 62.0, kBottom = 50.0;
constexpr double kLegendRow = 19.0, kLegendColumn = 230.0;
constexpr double kMark = 3.6;

// Dark enough on white, told apart by most colour-blind eyes (Okabe and Ito's set, darkened), and
// by their marks where colours repeat.
constexpr const char* kColours[] = {
    "#000000", "#0072b2", "#d55e00", "#009e73", "#b0578d", "#a07000", "#3a9ad0", "#777777"};
constexpr int kNumColours = static_cast<int>(std::size(kColours));
constexpr int kNumMarks = 5;

std::string Number(double value) {
  char text[32];
  std::snprintf(text, sizeof(text), "%.2f", value);
  return text;
}

// Length of the UTF-8 character at `i`, 0 where there is none.
size_t CharacterLength(const std::string& text, size_t i) {
  const auto byte = [&text](size_t k) { return static_cast<unsigned char>(text[k]); };
  if (byte(i) < 0x80) return 1;
  const size_t length = byte(i) >= 0xf0 ? 4 : byte(i) >= 0xe0 ? 3 : byte(i) >= 0xc2 ? 2 : 0;
  if (length == 0 || byte(i) > 0xf4 || i + length > text.size()) return 0;
  for (size_t k = i + 1; k < i + length; ++k) {
    if ((byte(k) & 0xc0) != 0x80) return 0;
  }
  return length;
}

std::string Escape(const std::string& text) {
  std::string result;
  for (size_t i = 0; i < text.size();) {
    const size_t length = CharacterLength(text, i);
    const char c = text[i];
    if (length == 0 || (length == 1 && static_cast<unsigned char>(c) < 0x20)) {
      result += '?';
    } else if (c == '&') {
      result += "&amp;";
    } else if (c == '<') {
      result += "&lt;";
    } else if (c == '>') {
      result += "&gt;";
    } else if (c == '"') {
      result += "&quot;";
    } else {
      result += text.substr(i, length);
    }
    i += std::max<size_t>(length, 1);
  }
  return result;
}

std::string Text(double x,
                 double y,
                 const std::string& text,
                 const std::string& anchor = "start",
                 const std::string& more = "") {
  return "<text x=\"" + Number(x) + "\" y=\"" + Number(y) + "\" text-anchor=\"" + anchor + "\"" +
         more + ">" + Escape(text) + "</text>\n";
}

std::string Line(double x1, double y1, double x2, double y2, const std::string& style) {
  return "<line x1=\"" + Number(x1) + "\" y1=\"" + Number(y1) + "\" x2=\"" + Number(x2) +
         "\" y2=\"" + Number(y2) + "\" " + style + "/>\n";
}

std::string Mark(double x, double y, int kind, const std::string& colour, bool open) {
  const std::string style = "fill=\"" + (open ? "white" : colour) + "\" stroke=\"" + colour +
                            "\" stroke-width=\"1.2\"/>\n";
  const auto polygon = [&](std::initializer_list<std::pair<double, double>> corners) {
    std::string points;
    for (const auto& [dx, dy] : corners) {
      points += (points.empty() ? "" : " ") + Number(x + kMark * dx) + "," + Number(y + kMark * dy);
    }
    return "<polygon points=\"" + points + "\" " + style;
  };
  switch (kind % kNumMarks) {
    case 1:
      return polygon({{-0.9, -0.9}, {0.9, -0.9}, {0.9, 0.9}, {-0.9, 0.9}});
    case 2:
      return polygon({{0.0, -1.2}, {1.1, 0.8}, {-1.1, 0.8}});
    case 3:
      return polygon({{0.0, -1.3}, {1.3, 0.0}, {0.0, 1.3}, {-1.3, 0.0}});
    case 4:
      return polygon({{0.0, 1.2}, {1.1, -0.8}, {-1.1, -0.8}});
    default:
      return "<circle cx=\"" + Number(x) + "\" cy=\"" + Number(y) + "\" r=\"" + Number(kMark) +
             "\" " + style;
  }
}

// "0.001", "100", "1e-05", "20000"
std::string TickLabel(double value) {
  char text[32];
  std::snprintf(text, sizeof(text), value >= 1e6 || value < 1e-4 ? "%.0e" : "%g", value);
  return text;
}

// One axis, from `low` to `high` of the data to `from` and `to` on the canvas.
struct Axis {
  double low = 0.0, high = 0.0, from = 0.0, to = 0.0;  // low, high: log10
  double operator()(double value) const {
    return from + (to - from) * (std::log10(value) - low) / (high - low);
  }
  bool Holds(double value) const {
    return value > 0.0 && std::log10(value) >= low - 1e-9 && std::log10(value) <= high + 1e-9;
  }
  // Decades, and 2 and 5 of them where there are few.
  std::vector<double> Ticks() const {
    std::vector<double> ticks;
    const double span = high - low;
    const int stride = std::max(1, static_cast<int>(std::ceil(span / 10.0)));
    for (int k = static_cast<int>(std::floor(low)); k <= high + 1.0; ++k) {
      if (k % stride != 0) continue;
      for (const double m : {1.0, 2.0, 5.0}) {
        if (m > 1.0 && span > 2.5) continue;
        const double value = m * std::pow(10.0, k);
        if (Holds(value)) ticks.push_back(value);
      }
    }
    return ticks;
  }
};

bool IsShown(double x, double y) {
  return std::isfinite(x) && std::isfinite(y) && x > 0.0 && y > 0.0;
}

Axis MakeAxis(const SvgPanel& panel, bool is_x, double from, double to) {
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (const SvgSeries& series : panel.series) {
    for (size_t i = 0; i < std::min(series.x.size(), series.y.size()); ++i) {
      if (!IsShown(series.x[i], series.y[i])) continue;
      const double value = std::log10(is_x ? series.x[i] : series.y[i]);
      low = std::min(low, value);
      high = std::max(high, value);
    }
  }
  if (low > high) low = high = 0.0;  // Nothing to show.
  const double margin = std::max(0.06 * (high - low), 0.15);
  return {low - margin, high + margin, from, to};
}

// Names of the legend in the order of their first appearance.
std::vector<std::string> LegendNames(const std::vector<SvgPanel>& panels) {
  std::vector<std::string> names;
  for (const SvgPanel& panel : panels) {
    for (const SvgSeries& series : panel.series) {
      if (!series.name.empty() &&
          std::find(names.begin(), names.end(), series.name) == names.end()) {
        names.push_back(series.name);
      }
    }
  }
  return names;
}

std::string DrawSeries(const SvgSeries& series, const Axis& x, const Axis& y, int number) {
  const std::string colour = kColours[number % kNumColours];
  std::string points, marks;
  for (size_t i = 0; i < std::min(series.x.size(), series.y.size()); ++i) {
    if (!IsShown(series.x[i], series.y[i])) continue;
    const double px = x(series.x[i]), py = y(series.y[i]);
    points += (points.empty() ? "" : " ") + Number(px) + "," + Number(py);
    marks += Mark(px, py, number, colour, i < series.open.size() && series.open[i]);
  }
  if (points.empty()) return "";
  const bool background = series.style == SvgSeries::Style::kBackground;
  return "<polyline points=\"" + points + "\" fill=\"none\" stroke=\"" +
         (background ? "#c8c8c8" : colour) + "\" stroke-width=\"" + (background ? "7" : "1.1") +
         "\" stroke-linejoin=\"round\" stroke-linecap=\"round\"/>\n" + (background ? "" : marks);
}

std::string DrawPanel(const SvgPanel& panel, double left, const std::vector<std::string>& names) {
  const double x0 = left + kLeft, x1 = left + kPanelWidth - kRight;
  const double y0 = kPanelHeight - kBottom, y1 = kTop;
  const Axis x = MakeAxis(panel, true, x0, x1), y = MakeAxis(panel, false, y0, y1);
  std::string svg = Text(0.5 * (x0 + x1), y1 - 12.0, panel.title, "middle");
  for (const double tick : x.Ticks()) {
    svg += Line(x(tick), y0, x(tick), y1, "stroke=\"#ececec\"");
    svg += Text(x(tick), y0 + 16.0, TickLabel(tick), "middle");
  }
  for (const double tick : y.Ticks()) {
    svg += Line(x0, y(tick), x1, y(tick), "stroke=\"#ececec\"");
    svg += Text(x0 - 6.0, y(tick) + 4.0, TickLabel(tick), "end");
  }
  for (const SvgLevel& level : panel.levels) {
    if (!y.Holds(level.y)) continue;
    svg += Line(x0, y(level.y), x1, y(level.y), "stroke=\"#888888\" stroke-dasharray=\"5 3\"");
    svg += Text(x0 + 4.0, y(level.y) - 3.0, level.label, "start", " fill=\"#555555\"");
  }
  svg += "<rect x=\"" + Number(x0) + "\" y=\"" + Number(y1) + "\" width=\"" + Number(x1 - x0) +
         "\" height=\"" + Number(y0 - y1) + "\" fill=\"none\" stroke=\"#333333\"/>\n";
  svg += Text(0.5 * (x0 + x1), y0 + 36.0, panel.x_label, "middle");
  const double middle = 0.5 * (y0 + y1), at = left + 16.0;
  svg += Text(at,
              middle,
              panel.y_label,
              "middle",
              " transform=\"rotate(-90 " + Number(at) + " " + Number(middle) + ")\"");
  for (const bool background : {true, false}) {  // Broad lines below all others.
    for (const SvgSeries& series : panel.series) {
      if ((series.style == SvgSeries::Style::kBackground) != background) continue;
      const auto name = std::find(names.begin(), names.end(), series.name);
      svg += DrawSeries(series, x, y, static_cast<int>(name - names.begin()));
    }
  }
  return svg;
}

}  // namespace

std::string MakeSvg(const std::string& title, const std::vector<SvgPanel>& panels) {
  const std::vector<std::string> names = LegendNames(panels);
  const double width = kPanelWidth * std::max<size_t>(panels.size(), 1);
  const int columns = std::max(1, static_cast<int>((width - kLeft) / kLegendColumn));
  const int rows = (static_cast<int>(names.size()) + columns - 1) / columns;
  const double height = kPanelHeight + kLegendRow * rows + 12.0;
  std::string svg =
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<svg xmlns=\"http://www.w3.org/2000/svg\" "
      "version=\"1.1\" width=\"" +
      Number(width) + "\" height=\"" + Number(height) + "\" viewBox=\"0 0 " + Number(width) + " " +
      Number(height) +
      "\" font-family=\"Helvetica, Arial, sans-serif\" font-size=\"12\">\n<rect x=\"0.00\" " +
      "y=\"0.00\" width=\"" + Number(width) + "\" height=\"" + Number(height) +
      "\" fill=\"white\"/>\n";
  svg += Text(0.5 * width, 24.0, title, "middle", " font-size=\"15\"");
  for (size_t i = 0; i < panels.size(); ++i) svg += DrawPanel(panels[i], kPanelWidth * i, names);
  for (size_t i = 0; i < names.size(); ++i) {
    const double x = kLeft + kLegendColumn * (i % columns);
    const double y = kPanelHeight + kLegendRow * (i / columns) + 8.0;
    bool background = false;
    for (const SvgPanel& panel : panels) {
      for (const SvgSeries& series : panel.series) {
        background = background ||
                     (series.name == names[i] && series.style == SvgSeries::Style::kBackground);
      }
    }
    const std::string colour = kColours[i % kNumColours];
    if (background) {
      svg += Line(x, y, x + 24.0, y, "stroke=\"#c8c8c8\" stroke-width=\"7\"");
    } else {
      svg += Line(x, y, x + 24.0, y, "stroke=\"" + colour + "\"");
      svg += Mark(x + 12.0, y, static_cast<int>(i), colour, false);
    }
    svg += Text(x + 31.0, y + 4.0, names[i]);
  }
  return svg + "</svg>\n";
}

}  // namespace darboux
