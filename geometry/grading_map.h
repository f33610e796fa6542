#ifndef DARBOUX_GEOMETRY_GRADING_MAP_H_
#define DARBOUX_GEOMETRY_GRADING_MAP_H_

#include <array>
#include <vector>

namespace darboux {

// A smooth monotone map of [0, 1] onto itself that spreads the cells of a lattice unevenly: cell
// number f (a fraction of all cells) lies at x(f) with
//
//   dx/df = exp(s(f)) / integral of exp(s) over [0, 1]
//
// where s, the logarithm of the cells' size, is a cubic spline: a straight s is a geometric
// grading. s has two continuous derivatives and x three, so that a lattice seen through the map
// loses no order of convergence.
class GradingMap {
 public:
  // The identity.
  GradingMap() = default;
  // s at equally spaced f = 0 ... 1; at least three values, finite, any constant added to all of
  // them is without effect. Periodic: s(0) = s(1), the last value is not read; otherwise the spline
  // has natural ends.
  GradingMap(const std::vector<double>& log_sizes, bool periodic);

  bool is_identity() const { return values_.empty(); }
  const std::vector<double>& log_sizes() const { return values_; }

  // x and its first to third derivatives; f in [0, 1].
  std::array<double, 4> Evaluate(double f) const;
  // f of x in [0, 1].
  double Inverse(double x) const;
  // Size of the cells at f relative to their mean: dx/df.
  double Size(double f) const { return Evaluate(f)[1]; }

 private:
  struct Spline {
    double s, s_1, s_2;  // s and its derivatives by f
  };
  Spline EvaluateSpline(int interval, double t) const;  // t in [0, 1] within the interval
  // Integral of exp(s) from the start of the interval to t, in f.
  double Integral(int interval, double t) const;

  std::vector<double> values_, curvatures_;  // s and d^2 s / df^2 at the knots
  std::vector<double> reached_;              // x at the knots
  double scale_ = 1.0;                       // 1 / integral of exp(s)
};

}  // namespace darboux

#endif  // DARBOUX_GEOMETRY_GRADING_MAP_H_
