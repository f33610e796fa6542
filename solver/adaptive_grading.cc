#include "solver/adaptive_grading.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "solver/fields.h"

namespace darboux {
namespace {

using ScaledStrains = Eigen::Matrix<double, 6, 1>;

// Columns that need no cells are not made wider than this much at a time: G relative to the
// largest.
constexpr double kFloor = 1e-4;
constexpr double kExponent = 0.25;
// Knots of a map: enough for a layer at either end, few enough to be smooth.
constexpr int kMostKnots = 8;
constexpr double kSmoothing = 0.03;

// ScaledStrains as roots of energy per area: |r|^2 / 2 is the energy density.
ScaledStrains Scaled(const Material& material,
                     const Eigen::Vector3d& e,
                     const Eigen::Vector3d& rho) {
  const double nu = material.poisson_ratio;
  const auto scaled = [nu](double stiffness, const Eigen::Vector3d& x) -> Eigen::Vector3d {
    return std::sqrt(stiffness) * Eigen::Vector3d(x[0] + nu * x[1],
                                                  std::sqrt(1.0 - nu * nu) * x[1],
                                                  std::sqrt(2.0 * (1.0 - nu)) * x[2]);
  };
  ScaledStrains result;
  result << scaled(material.MembraneStiffness(), e), scaled(material.BendingStiffness(), rho);
  return result;
}

// Scaled strains at the middles of all cells, rows of the lattice one after the other.
class CellStrains {
 public:
  CellStrains(const ShellProblem& problem, std::vector<FieldSite> sites)
      : problem_(problem), sites_(std::move(sites)) {}

  std::vector<ScaledStrains> OfState() const {
    std::vector<ScaledStrains> result;
    for (const FieldSite& site : sites_) result.push_back(At(problem_.displacements(), site));
    return result;
  }

  // Change by a small step along z, per unit of it.
  std::vector<ScaledStrains> Along(const Eigen::Matrix3Xd& z) const {
    const double size = z.cwiseAbs().maxCoeff();
    std::vector<ScaledStrains> result(sites_.size(), ScaledStrains::Zero());
    if (!(size > 0.0)) return result;
    // ScaledStrains are quadratic in the step at most to leading order: central differences have no
    // error of that order, and a step of this size loses four digits to rounding.
    constexpr double kStep = 1e-3;
    const double step = kStep * problem_.material().thickness / size;
    const Eigen::Matrix3Xd& u = problem_.displacements();
    const Eigen::Matrix3Xd up = u + step * z, down = u - step * z;
    for (size_t i = 0; i < sites_.size(); ++i) {
      result[i] = (At(up, sites_[i]) - At(down, sites_[i])) / (2.0 * step);
    }
    return result;
  }

 private:
  ScaledStrains At(const Eigen::Matrix3Xd& displacements, const FieldSite& site) const {
    const ShellFields fields = EvaluateFields(problem_, displacements, site);
    const ScaledStrains r =
        Scaled(problem_.material(), fields.membrane_strain, fields.bending_strain);
    return r.allFinite() ? r : ScaledStrains::Zero().eval();
  }

  const ShellProblem& problem_;
  const std::vector<FieldSite> sites_;
};

// Least-squares fit of s, given at the middles of cells whose borders lie at fractions f, by its
// values at `knots` + 1 equally spaced fractions (piecewise linear), with a penalty on their second
// differences.
std::vector<double> FitKnots(const std::vector<double>& f,
                             const std::vector<double>& s,
                             int knots,
                             bool periodic) {
  const int n = static_cast<int>(s.size());
  const int unknowns = periodic ? knots : knots + 1;
  Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(unknowns, unknowns);
  Eigen::VectorXd right = Eigen::VectorXd::Zero(unknowns);
  const auto middle = [&](int c) {  // Of cell c, which may lie beyond either end.
    const int turns = c < 0 ? -1 : c >= n ? 1 : 0;
    const int k = c - turns * n;
    return 0.5 * (f[k] + f[k + 1]) + turns;
  };
  constexpr double kPoints[3][2] = {
      {0.1127016653792583, 5.0 / 18.0}, {0.5, 8.0 / 18.0}, {0.8872983346207417, 5.0 / 18.0}};
  for (int c = 0; c < n; ++c) {
    for (const auto& point : kPoints) {
      const double at = f[c] + point[0] * (f[c + 1] - f[c]);
      const double weight = point[1] * (f[c + 1] - f[c]);
      // s on the line through the middles around, or the nearest two.
      int left = at < middle(c) ? c - 1 : c;
      if (!periodic) left = std::clamp(left, 0, n - 2);
      const double x0 = middle(left), x1 = middle(left + 1);
      const double s0 = s[(left + n) % n], s1 = s[(left + 1) % n];
      const double value = s0 + (s1 - s0) * (at - x0) / (x1 - x0);
      const int k = std::min(static_cast<int>(at * knots), knots - 1);
      const double t = at * knots - k;
      const int a = k, b = (k + 1) % unknowns;
      matrix(a, a) += weight * (1.0 - t) * (1.0 - t);
      matrix(a, b) += weight * (1.0 - t) * t;
      matrix(b, a) += weight * (1.0 - t) * t;
      matrix(b, b) += weight * t * t;
      right[a] += weight * (1.0 - t) * value;
      right[b] += weight * t * value;
    }
  }
  constexpr double kSecond[3] = {1.0, -2.0, 1.0};
  for (int k = periodic ? 0 : 1; k < knots; ++k) {
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) {
        matrix((k - 1 + i + unknowns) % unknowns, (k - 1 + j + unknowns) % unknowns) +=
            kSmoothing * kSecond[i] * kSecond[j];
      }
    }
  }
  const Eigen::VectorXd x = matrix.ldlt().solve(right);
  std::vector<double> result(x.data(), x.data() + x.size());
  if (periodic) result.push_back(result.front());
  return result;
}

}  // namespace

LatticeAdvice AdviseLattice(const ShellProblem& problem,
                            const std::vector<Eigen::Matrix3Xd>& duals) {
  const ShellSurface& surface = problem.surface();
  const ParameterDomain& domain = surface.domain();
  const std::array<int, 2> divisions = domain.options().divisions;
  const std::array<bool, 2> periodic = domain.options().periodic;
  const int m = divisions[0], n = divisions[1];
  LatticeAdvice advice;
  advice.proportion = static_cast<double>(m) / n;
  advice.maps = domain.options().maps;

  std::vector<FieldSite> sites;
  std::vector<double> areas;
  for (int j = 0; j < n; ++j) {
    for (int i = 0; i < m; ++i) {
      const ElementPoint at = domain.LocateLattice(i + 0.5, j + 0.5);
      sites.push_back(MakeFieldSite(surface, at));
      const SurfaceJet jet = surface.ParametricJet(at);
      areas.push_back(jet.x_u.cross(jet.x_v).norm() * domain.Parameter(0, i + 0.5)[1] *
                      domain.Parameter(1, j + 0.5)[1]);
    }
  }
  const CellStrains strains(problem, std::move(sites));
  // |second difference| along a direction; at open ends that of the next cell.
  const auto second = [&](const std::vector<ScaledStrains>& r, int direction, int i, int j) {
    const int count = divisions[direction];
    if (count < 3) return 0.0;
    const auto at = [&](int k) -> const ScaledStrains& {
      k = (k + count) % count;
      return direction == 0 ? r[j * m + k] : r[k * m + i];
    };
    int k = direction == 0 ? i : j;
    if (!periodic[direction]) k = std::clamp(k, 1, count - 2);
    return (at(k - 1) - 2.0 * at(k) + at(k + 1)).norm();
  };

  const std::vector<ScaledStrains> primal = strains.OfState();
  std::array<std::vector<double>, 2> marginal = {std::vector<double>(m, 0.0),
                                                 std::vector<double>(n, 0.0)};
  for (const Eigen::Matrix3Xd& dual : duals) {
    const std::vector<ScaledStrains> z = strains.Along(dual);
    for (int j = 0; j < n; ++j) {
      for (int i = 0; i < m; ++i) {
        for (int d = 0; d < 2; ++d) {
          const double g = second(primal, d, i, j) * second(z, d, i, j) * areas[j * m + i];
          marginal[d][d == 0 ? i : j] += g;
          advice.totals[d] += g;
        }
      }
    }
  }

  for (int d = 0; d < 2; ++d) {
    const int count = divisions[d];
    const double largest = *std::max_element(marginal[d].begin(), marginal[d].end());
    if (count < 3 || !(largest > 0.0)) continue;
    const auto& range = d == 0 ? domain.options().u_range : domain.options().v_range;
    // Wanted sizes of the present cells, and the fractions of the new cells where they end.
    std::vector<double> log_size(count), fraction(count + 1, 0.0);
    for (int k = 0; k < count; ++k) {
      const double width =
          (domain.Parameter(d, k + 1)[0] - domain.Parameter(d, k)[0]) / (range[1] - range[0]);
      log_size[k] =
          std::log(width) - kExponent * std::log(std::max(marginal[d][k] / largest, kFloor));
      fraction[k + 1] = width;
    }
    std::vector<double> smooth = log_size;
    for (int k = 0; k < count; ++k) {
      const int a = periodic[d] ? (k + count - 1) % count : std::max(k - 1, 0);
      const int b = periodic[d] ? (k + 1) % count : std::min(k + 1, count - 1);
      smooth[k] = 0.25 * log_size[a] + 0.5 * log_size[k] + 0.25 * log_size[b];
    }
    for (int k = 0; k < count; ++k)
      fraction[k + 1] = fraction[k] + fraction[k + 1] / std::exp(smooth[k]);
    for (int k = 0; k < count; ++k) fraction[k] /= fraction[count];
    fraction[count] = 1.0;
    const int knots = std::clamp(count / 2, 4, kMostKnots);
    const GradingMap& present = domain.options().maps[d];
    advice.maps[d] = GradingMap(FitKnots(fraction, smooth, knots, periodic[d]), periodic[d]);
    for (int k = 0; k < count; ++k) {
      const double f = (k + 0.5) / count;
      advice.change =
          std::max(advice.change, std::abs(std::log(advice.maps[d].Size(f) / present.Size(f))));
    }
  }
  // Where the new cells are of other sizes than the old ones at the same place, G follows.
  double before = 0.0, after = 0.0;
  for (int d = 0; d < 2; ++d) {
    const auto& range = d == 0 ? domain.options().u_range : domain.options().v_range;
    for (int k = 0; k < divisions[d]; ++k) {
      const double width = domain.Parameter(d, k + 0.5)[1] * divisions[d] / (range[1] - range[0]);
      const double x = (domain.Parameter(d, k + 0.5)[0] - range[0]) / (range[1] - range[0]);
      const double size = advice.maps[d].Size(advice.maps[d].Inverse(x));
      before += marginal[d][k];
      after += marginal[d][k] * std::pow(size / width, 4.0);
    }
  }
  if (after > 0.0) advice.gain = before / after;
  if (m >= 3 && n >= 3 && advice.totals[0] > 0.0 && advice.totals[1] > 0.0) {
    advice.proportion *= std::pow(advice.totals[0] / advice.totals[1], 0.25);
  }
  return advice;
}

std::array<int, 2> DivisionsFor(double cells,
                                double proportion,
                                const std::array<int, 2>& least,
                                const std::array<int, 2>& multiple) {
  double columns = std::sqrt(cells * proportion), rows = cells / columns;
  if (rows < least[1]) {
    rows = least[1];
    columns = cells / rows;
  }
  if (columns < least[0]) {
    columns = least[0];
    rows = cells / columns;
  }
  const auto round = [&](int d, double count) {
    const int rounded = multiple[d] * static_cast<int>(std::lround(count / multiple[d]));
    return std::max(least[d], rounded);
  };
  return {round(0, columns), round(1, rows)};
}

bool LargestDivisions(int dof,
                      double proportion,
                      const std::array<int, 2>& least,
                      const std::array<int, 2>& multiple,
                      std::array<int, 2>* divisions) {
  // The ghost ring has three columns and rows more than the cells.
  constexpr double kSkew = 1.2;  // from the proportion
  *divisions = {0, 0};
  const double room = dof / 3.0;
  for (int m = least[0]; 3.0 + m <= room; m += multiple[0]) {
    const int n = static_cast<int>(room / (m + 3.0) - 3.0) / multiple[1] * multiple[1];
    if (n < least[1]) break;
    const double skew = std::max(m / (n * proportion), n * proportion / m);
    if (skew > kSkew || m * n <= (*divisions)[0] * (*divisions)[1]) continue;
    *divisions = {m, n};
  }
  return (*divisions)[0] > 0;
}

}  // namespace darboux
