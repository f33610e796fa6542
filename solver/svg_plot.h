#ifndef DARBOUX_SOLVER_SVG_PLOT_H_
#define DARBOUX_SOLVER_SVG_PLOT_H_

#include <string>
#include <vector>

namespace darboux {

// Plots with two logarithmic axes as one self-contained SVG 1.1 file: panels side by side, a legend
// common to all of them below.

// Points that belong together.
struct SvgSeries {
  std::string name;  // in the legend; empty: not there. One name has one colour and mark.
  std::vector<double> x, y;
  std::vector<bool> open;                           // marks drawn hollow; empty: none
  enum class Style { kLineAndMarks, kBackground };  // kBackground: a broad grey line, no marks
  Style style = Style::kLineAndMarks;
};

// A value to compare with.
struct SvgLevel {
  double y = 0.0;
  std::string label;
};

// One pair of axes.
struct SvgPanel {
  std::string title, x_label, y_label;
  std::vector<SvgSeries> series;
  std::vector<SvgLevel> levels;  // dashed horizontal lines; they do not widen the axes
};

// Points that are not finite or not positive are left out. Text is escaped; bytes that are no UTF-8
// and control characters become '?'.
std::string MakeSvg(const std::string& title, const std::vector<SvgPanel>& panels);

}  // namespace darboux

#endif  // DARBOUX_SOLVER_SVG_PLOT_H_
