#include "geometry/implicit_mesh.h"

#include <glog/logging.h>

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <sstream>
#include <unordered_map>
#include <utility>
#include <vector>

#include "geometry/implicit_function.h"
#include "geometry/isotropic_remesher.h"

namespace darboux {
namespace {

using Projection = ImplicitFunction::Projection;
using Sides = IsotropicRemesher::Sides;

constexpr const char* kAxisName[3] = {"x", "y", "z"};

// Width of the lattice relative to the edge length.
constexpr double kLatticeWidth = 0.8;

std::string Number(double x) {
  std::ostringstream out;
  out.precision(6);
  out << x;
  return out.str();
}

std::string Point(const Eigen::Vector3d& p) {
  return "(" + Number(p.x()) + ", " + Number(p.y()) + ", " + Number(p.z()) + ")";
}

Eigen::Vector3d FreeAxes(Sides sides) {
  Eigen::Vector3d is_free;
  for (int i = 0; i < 3; ++i) is_free[i] = (sides >> (2 * i) & 3) != 0 ? 0.0 : 1.0;
  return is_free;
}

// Tetrahedra of a cube whose corners are numbered by bits (1: x, 2: y, 4: z): one for each order
// in which the axes can be walked from corner 0 to corner 7. All edges go from a corner to one with
// more bits. Positively oriented.
constexpr int kTetrahedra[6][4] = {
    {0, 1, 3, 7}, {0, 3, 2, 7}, {0, 2, 6, 7}, {0, 6, 4, 7}, {0, 4, 5, 7}, {0, 5, 1, 7}};

class ImplicitMesher {
 public:
  ImplicitMesher(const Expression& function,
                 const Eigen::AlignedBox3d& bounds,
                 double target,
                 const ImplicitMeshOptions& options,
                 std::string* error)
      : function_(function),
        bounds_(bounds),
        target_(target),
        options_(options),
        size_(bounds.diagonal().norm()),
        error_(error) {}

  bool Run(TriangleMesh* mesh) {
    return CheckInput() && MakeLattice() && March() && CheckSingularPoints() && CheckPieces() &&
           Remesh(mesh) && CheckResult(*mesh);
  }

 private:
  bool Fail(const std::string& message) {
    *error_ = message;
    return false;
  }

  bool FailNotFinite(const std::string& what, const Eigen::Vector3d& p) {
    return Fail(what + " is not finite at " + Point(p) + "; it has to be everywhere in the bounds");
  }

  bool CheckInput() {
    if (!options_.IsValid(error_)) return false;
    for (int i = 0; i < 3; ++i) {
      const double low = bounds_.min()[i], high = bounds_.max()[i];
      if (!(std::isfinite(low) && std::isfinite(high) && std::isfinite(high - low) && low < high)) {
        return Fail("the bounds of " + std::string(kAxisName[i]) + " are found to be [" +
                    Number(low) + ", " + Number(high) +
                    "]; allowed are two finite ascending numbers");
      }
    }
    const double side = bounds_.sizes().minCoeff();
    if (!(std::isfinite(target_) && target_ > 0.0 && target_ <= side)) {
      return Fail("edge length " + Number(target_) +
                  "; allowed is > 0 and at most the shortest side of the bounds, " + Number(side));
    }
    return true;
  }

  bool MakeLattice() {
    double num_samples = 1.0;
    for (int i = 0; i < 3; ++i) {
      num_samples *= std::ceil(bounds_.sizes()[i] / (kLatticeWidth * target_)) + 1.0;
    }
    if (num_samples > static_cast<double>(options_.max_samples)) {
      const double smallest =
          target_ * std::cbrt(num_samples / static_cast<double>(options_.max_samples));
      return Fail("edge length " + Number(target_) +
                  " is too small for the bounds: " + Number(num_samples) +
                  " samples of the function; allowed are " + std::to_string(options_.max_samples) +
                  ", that is an edge length of about " + Number(smallest) + " or tighter bounds");
    }
    spacing_ = 0.0;
    for (int i = 0; i < 3; ++i) {
      const double low = bounds_.min()[i], side = bounds_.sizes()[i];
      const int n = std::max(2, static_cast<int>(std::ceil(side / (kLatticeWidth * target_))));
      // Inner planes are shifted irregularly by up to a tenth of their distance. On an even
      // lattice, surfaces with planes of symmetry would pass exactly through its points, and
      // rounding, hence the unit of length, would decide on which side they are.
      for (int j = 0; j <= n; ++j) {
        constexpr double kGolden = 0.6180339887498949;
        const double turn = (j + 0.377 * (i + 1)) * kGolden;
        const double shift = 0.2 * (turn - std::floor(turn) - 0.5);
        lattice_[i].push_back(j == 0 ? low : low + side * std::min(1.0, (j + shift) / n));
      }
      lattice_[i].back() = bounds_.max()[i];
      spacing_ = std::max(spacing_, side / n);
    }
    return true;
  }

  int Count(int axis) const { return static_cast<int>(lattice_[axis].size()); }

  Eigen::Vector3d LatticePoint(int i, int j, int k) const {
    return {lattice_[0][i], lattice_[1][j], lattice_[2][k]};
  }

  bool SampleLayer(int k, std::vector<double>* values) {
    values->resize(static_cast<size_t>(Count(0)) * Count(1));
    size_t at = 0;
    for (int j = 0; j < Count(1); ++j) {
      for (int i = 0; i < Count(0); ++i, ++at) {
        const Eigen::Vector3d p = LatticePoint(i, j, k);
        const double f = function_.Value(p);
        if (!std::isfinite(f)) return FailNotFinite("the function", p);
        (*values)[at] = f;
        if (std::abs(f) < std::abs(nearest_zero_)) {
          nearest_zero_ = f;
          nearest_zero_at_ = p;
        }
        const bool on_box = i == 0 || j == 0 || k == 0 || i + 1 == Count(0) || j + 1 == Count(1) ||
                            k + 1 == Count(2);
        if (on_box && f < 0.0) negative_on_box_ = true;
        if (on_box && f >= 0.0) positive_on_box_ = true;
      }
    }
    return true;
  }

  // Marching tetrahedra, layer by layer.
  bool March() {
    std::array<std::vector<double>, 3> layers;  // k - 1, k, k + 1
    if (!SampleLayer(0, &layers[1])) return false;
    for (int k = 0; k + 1 < Count(2); ++k) {
      if (!SampleLayer(k + 1, &layers[2])) return false;
      for (int j = 0; j + 1 < Count(1); ++j) {
        for (int i = 0; i + 1 < Count(0); ++i) MarchCell(i, j, k, layers[1], layers[2]);
      }
      if (static_cast<std::int64_t>(raw_.triangles.size()) >
          10 * static_cast<std::int64_t>(options_.max_triangles)) {
        return FailTooManyTriangles("far more");
      }
      if (k > 0) CollectNearMisses(k, layers);
      std::rotate(layers.begin(), layers.begin() + 1, layers.end());
    }
    vertex_on_edge_.clear();
    if (negative_on_box_ && positive_on_box_ && !options_.allow_boundary) {
      return FailLeavesBounds();
    }
    if (raw_.triangles.empty()) {
      return Fail("the function has no zero within the bounds: it is " +
                  std::string(nearest_zero_ < 0.0 ? "negative" : "positive") + " at all of " +
                  Number(static_cast<double>(Count(0)) * Count(1) * Count(2)) +
                  " points, nearest to zero with " + Number(nearest_zero_) + " at " +
                  Point(nearest_zero_at_) +
                  "; a surface needs both signs, and to be larger than the edge length " +
                  Number(target_));
    }
    if (!positive_on_box_) {
      return Fail(
          "the function is negative at the bounds, outside the closed surface; it has to be "
          "negative inside and positive outside: change its sign");
    }
    double area = 0.0;
    for (const std::array<int, 3>& t : raw_.triangles) {
      const Eigen::Vector3d& a = raw_.vertices[t[0]];
      area += 0.5 * (raw_.vertices[t[1]] - a).cross(raw_.vertices[t[2]] - a).norm();
    }
    const double num_triangles = area / (0.25 * std::sqrt(3.0) * target_ * target_);
    if (num_triangles > options_.max_triangles) return FailTooManyTriangles(Number(num_triangles));
    return true;
  }

  bool FailTooManyTriangles(const std::string& number) {
    return Fail("edge length " + Number(target_) + " is too small for the surface: about " +
                number + " triangles; allowed are " + std::to_string(options_.max_triangles));
  }

  bool FailLeavesBounds() {
    for (size_t v = 0; v < raw_.vertices.size(); ++v) {
      for (int side = 0; side < 6; ++side) {
        if ((sides_[v] >> side & 1) == 0) continue;
        const int axis = side / 2;
        const double plane = side % 2 == 0 ? bounds_.min()[axis] : bounds_.max()[axis];
        return Fail("the surface leaves the bounds at " + Point(raw_.vertices[v]) +
                    " through the plane " + kAxisName[axis] + " = " + Number(plane) +
                    "; allowed is a closed surface within the bounds");
      }
    }
    return Fail("the surface leaves the bounds; allowed is a closed surface within the bounds");
  }

  void MarchCell(
      int i, int j, int k, const std::vector<double>& lower, const std::vector<double>& upper) {
    double f[8];
    int negative = 0;
    for (int corner = 0; corner < 8; ++corner) {
      const size_t at = static_cast<size_t>(j + (corner >> 1 & 1)) * Count(0) + i + (corner & 1);
      f[corner] = (corner & 4) != 0 ? upper[at] : lower[at];
      if (f[corner] < 0.0) ++negative;
    }
    if (negative == 0 || negative == 8) return;

    const std::array<int, 3> cell = {i, j, k};
    const auto on_edge = [&](int a, int b) {
      return a < b ? VertexOnEdge(cell, a, b, f[a], f[b]) : VertexOnEdge(cell, b, a, f[b], f[a]);
    };
    const auto add = [this](int a, int b, int c) { raw_.triangles.push_back({a, b, c}); };
    for (const int(&tetrahedron)[4] : kTetrahedra) {
      std::array<int, 4> in{}, out{};
      int num_in = 0, num_out = 0;
      for (int c = 0; c < 4; ++c) (f[tetrahedron[c]] < 0.0 ? in[num_in++] : out[num_out++]) = c;
      if (num_in == 0 || num_in == 4) continue;
      // The corner that is alone, or both negative ones, first, in an even order.
      std::array<int, 4> order;
      if (num_in == 2) {
        order = {in[0], in[1], out[0], out[1]};
      } else {
        constexpr std::array<int, 4> kEven[4] = {
            {0, 1, 2, 3}, {1, 0, 3, 2}, {2, 0, 1, 3}, {3, 0, 2, 1}};
        order = kEven[num_in == 1 ? in[0] : out[0]];
      }
      int inversions = 0;
      for (int a = 0; a < 4; ++a) {
        for (int b = a + 1; b < 4; ++b) inversions += order[a] > order[b] ? 1 : 0;
      }
      if (inversions % 2 == 1) std::swap(order[2], order[3]);
      const int p = tetrahedron[order[0]], q = tetrahedron[order[1]], r = tetrahedron[order[2]],
                s = tetrahedron[order[3]];
      if (num_in == 2) {
        const int pr = on_edge(p, r), ps = on_edge(p, s), qs = on_edge(q, s), qr = on_edge(q, r);
        add(pr, ps, qs);
        add(pr, qs, qr);
      } else if (num_in == 1) {
        add(on_edge(p, q), on_edge(p, r), on_edge(p, s));
      } else {
        add(on_edge(p, q), on_edge(p, s), on_edge(p, r));
      }
    }
  }

  // The vertex where f changes sign between corners a and b of the cell; b has all bits of a.
  int VertexOnEdge(const std::array<int, 3>& cell, int a, int b, double fa, double fb) {
    std::array<int, 3> low = cell, high = cell;
    Sides sides = 0;
    for (int axis = 0; axis < 3; ++axis) {
      low[axis] += a >> axis & 1;
      high[axis] += b >> axis & 1;
      if (low[axis] != high[axis]) continue;
      if (low[axis] == 0) sides |= 1 << (2 * axis);
      if (low[axis] + 1 == Count(axis)) sides |= 2 << (2 * axis);
    }
    const std::uint64_t key =
        8 * (low[0] + static_cast<std::uint64_t>(Count(0)) *
                          (low[1] + static_cast<std::uint64_t>(Count(1)) * low[2])) +
        static_cast<std::uint64_t>(b ^ a);
    const auto [it, is_new] = vertex_on_edge_.insert({key, static_cast<int>(raw_.vertices.size())});
    if (!is_new) return it->second;

    // Regula falsi with halving (Illinois): a few digits do.
    const Eigen::Vector3d p = LatticePoint(low[0], low[1], low[2]);
    const Eigen::Vector3d q = LatticePoint(high[0], high[1], high[2]);
    double ta = 0.0, tb = 1.0, t = 0.5;
    for (int i = 0; i < 8 && tb - ta > 1e-3; ++i) {
      t = (ta * fb - tb * fa) / (fb - fa);
      if (!(t > ta && t < tb)) break;
      const double f = function_.Value(p + t * (q - p));
      if (f < 0.0) {
        (fa < 0.0 ? ta : tb) = t;
        (fa < 0.0 ? fa : fb) = f;
      } else {
        (fa < 0.0 ? tb : ta) = t;
        (fa < 0.0 ? fb : fa) = f;
      }
      if (!(std::abs(f) > 0.0)) break;
      (i % 2 == 0 ? fa : fb) *= 0.5;
    }
    // Not into the lattice point, where many edges meet.
    t = std::clamp(std::isfinite(t) ? t : 0.5, 0.02, 0.98);
    raw_.vertices.push_back(p + t * (q - p));
    sides_.push_back(sides);
    return it->second;
  }

  // Points without a change of sign around whose |f| is less than differences to the neighbours:
  // a piece of the surface may fit between the points of the lattice.
  void CollectNearMisses(int k, const std::array<std::vector<double>, 3>& layers) {
    const int row = Count(0);
    for (int j = 1; j + 1 < Count(1); ++j) {
      for (int i = 1; i + 1 < row; ++i) {
        const size_t at = static_cast<size_t>(j) * row + i;
        const double f = layers[1][at];
        const double dx =
            std::max(std::abs(layers[1][at - 1] - f), std::abs(layers[1][at + 1] - f));
        const double dy =
            std::max(std::abs(layers[1][at - row] - f), std::abs(layers[1][at + row] - f));
        const double dz = std::max(std::abs(layers[0][at] - f), std::abs(layers[2][at] - f));
        if (std::abs(f) >= std::hypot(dx, dy, dz)) continue;
        bool changes_sign = false;
        for (const std::vector<double>& layer : layers) {
          for (const int dj : {-row, 0, row}) {
            for (const int di : {-1, 0, 1}) {
              if ((layer[at + dj + di] < 0.0) != (f < 0.0)) changes_sign = true;
            }
          }
        }
        if (changes_sign) continue;
        Eigen::Vector3d p = LatticePoint(i, j, k), gradient;
        if (function_.Project(size_, 0.9 * spacing_, Eigen::Vector3d::Ones(), &p, &gradient) ==
            Projection::kOnSurface) {
          near_misses_.push_back(p);
        }
      }
    }
  }

  bool CheckPieces() {
    if (options_.allow_several_components) return true;
    std::vector<int> parent(raw_.vertices.size());
    std::iota(parent.begin(), parent.end(), 0);
    const auto root = [&parent](int v) {
      while (parent[v] != v) v = parent[v] = parent[parent[v]];
      return v;
    };
    for (const std::array<int, 3>& t : raw_.triangles) {
      parent[root(t[1])] = root(t[0]);
      parent[root(t[2])] = root(t[0]);
    }
    std::vector<int> roots;
    for (int v = 0; v < static_cast<int>(parent.size()); ++v) {
      if (root(v) == v) roots.push_back(v);
    }
    if (roots.size() == 1) return true;
    std::string places;
    for (size_t i = 0; i < std::min<size_t>(roots.size(), 3); ++i) {
      places += (i == 0 ? " at " : ", ") + Point(raw_.vertices[roots[i]]);
    }
    return Fail("the surface has " + std::to_string(roots.size()) + " pieces" + places +
                (roots.size() > 3 ? ", ..." : "") + " (edge length " + Number(target_) +
                "); allowed is 1");
  }

  // Where the linear model of f does not hold across a cell, looks for a point with f = 0 and
  // vanishing gradient.
  bool CheckSingularPoints() {
    for (const Eigen::Vector3d& start : raw_.vertices) {
      Eigen::Vector3d g;
      Eigen::Matrix3d h;
      function_.Value(start, &g, &h);
      if (!g.allFinite()) return FailNotFinite("the function's gradient", start);
      if (!h.allFinite()) continue;
      // In units of the lattice and of f's own differences, whatever their size.
      const double scale =
          std::max(g.lpNorm<Eigen::Infinity>(), h.lpNorm<Eigen::Infinity>() * spacing_);
      if (scale == 0.0) return FailSingular(start);
      const double first_norm = (g / scale).norm();
      if (first_norm > 1.5 * (h / scale * spacing_).norm()) continue;
      // Newton's method for a vanishing gradient. Where the second derivatives vanish as well it
      // converges by a factor a step only.
      Eigen::Vector3d p = start;
      double f = 0.0;
      for (int i = 0; i < 80; ++i) {
        const Eigen::JacobiSVD<Eigen::Matrix3d> svd(h / scale * spacing_,
                                                    Eigen::ComputeFullU | Eigen::ComputeFullV);
        if (svd.singularValues()[0] == 0.0) break;
        // Along a line of singular points the gradient does not change.
        Eigen::Vector3d step = Eigen::Vector3d::Zero();
        for (int k = 0; k < 3; ++k) {
          if (svd.singularValues()[k] <= 1e-6 * svd.singularValues()[0]) continue;
          step -=
              svd.matrixU().col(k).dot(g / scale) / svd.singularValues()[k] * svd.matrixV().col(k);
        }
        p += spacing_ * step;
        f = function_.Value(p, &g, &h);
        if (!std::isfinite(f) || !g.allFinite() || !h.allFinite()) break;
        if ((p - start).norm() > 3.0 * spacing_ || step.norm() < 1e-12) break;
      }
      if (!((p - start).norm() <= 3.0 * spacing_)) continue;
      if ((g / scale).norm() <= 1e-9 * first_norm && std::abs(f / scale) <= 1e-9 * spacing_) {
        return FailSingular(p);
      }
    }
    return true;
  }

  bool FailSingular(Eigen::Vector3d p) {
    for (int i = 0; i < 3; ++i) {
      if (std::abs(p[i]) < 1e-6 * spacing_) p[i] = 0.0;
    }
    return Fail("the function's gradient vanishes on the surface at " + Point(p) +
                ": a point without tangent plane; allowed are smooth surfaces");
  }

  bool Remesh(TriangleMesh* mesh) {
    const auto project = [this](Sides sides, Eigen::Vector3d* p, Eigen::Vector3d* normal) {
      Eigen::Vector3d q = *p, gradient;
      if (function_.Project(size_, 2.0 * target_, FreeAxes(sides), &q, &gradient) !=
          Projection::kOnSurface) {
        return false;
      }
      // Another sheet of the surface, or beyond the box.
      const double norm = gradient.stableNorm();
      if (!(norm > 0.0) || gradient.dot(*normal) < -0.5 * norm || !bounds_.contains(q)) {
        return false;
      }
      *p = q;
      *normal = gradient / norm;
      return true;
    };
    IsotropicRemesher remesher(raw_, sides_, target_, project);
    remesher.Run(options_.num_remeshing_iterations);
    *mesh = remesher.Result(&normals_);
    return true;
  }

  bool CheckResult(const TriangleMesh& mesh) {
    // Vertices that were never moved, hence not onto the surface.
    for (const Eigen::Vector3d& p : mesh.vertices) {
      Eigen::Vector3d gradient;
      const double f = function_.Value(p, &gradient);
      if (!std::isfinite(f) || !gradient.allFinite()) {
        return FailNotFinite("the function or its gradient", p);
      }
      const double norm = gradient.stableNorm();
      if (norm == 0.0) return FailSingular(p);
      if (!(std::abs(f) <= 1e-9 * size_ * norm)) {
        return Fail("no point of a smooth surface found near " + Point(p) +
                    ", where f = " + Number(f) + " with a gradient of " + Number(norm) +
                    "; the function has to be smooth there and the edge length, " +
                    Number(target_) + ", small enough for the shape");
      }
    }
    const double min_cosine = std::cos(options_.max_normal_angle);
    for (const std::array<int, 3>& t : mesh.triangles) {
      const Eigen::Vector3d& a = mesh.vertices[t[0]];
      const Eigen::Vector3d normal =
          (mesh.vertices[t[1]] - a).cross(mesh.vertices[t[2]] - a).normalized();
      for (const int v : t) {
        const double cosine = normal.dot(normals_[v]);
        if (cosine >= min_cosine) continue;
        const double angle = std::acos(std::clamp(cosine, -1.0, 1.0)) * 180.0 / M_PI;
        return Fail("edge length " + Number(target_) + " is too large for the shape at " +
                    Point(mesh.vertices[v]) + ": the normals of surface and triangle differ by " +
                    Number(angle) + " degrees; allowed are " +
                    Number(options_.max_normal_angle * 180.0 / M_PI));
      }
    }
    return CheckNearMisses(mesh);
  }

  // Points of the surface have to be near vertices of the mesh.
  bool CheckNearMisses(const TriangleMesh& mesh) {
    const double reach = 1.1 * target_;
    const auto key = [this, reach](const Eigen::Vector3d& p, int dx, int dy, int dz) {
      const Eigen::Vector3d cell = (p - bounds_.min()) / reach;
      const auto part = [](double x, int d) {
        return static_cast<std::uint64_t>(static_cast<std::int64_t>(std::floor(x)) + d + 1);
      };
      return (part(cell.x(), dx) << 42) + (part(cell.y(), dy) << 21) + part(cell.z(), dz);
    };
    std::unordered_map<std::uint64_t, std::vector<int>> cells;
    if (!near_misses_.empty()) {
      for (size_t v = 0; v < mesh.vertices.size(); ++v) {
        cells[key(mesh.vertices[v], 0, 0, 0)].push_back(static_cast<int>(v));
      }
    }
    for (const Eigen::Vector3d& p : near_misses_) {
      bool is_near = false;
      for (int i = 0; i < 27 && !is_near; ++i) {
        const auto cell = cells.find(key(p, i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1));
        if (cell == cells.end()) continue;
        for (const int v : cell->second) {
          if ((mesh.vertices[v] - p).norm() < reach) is_near = true;
        }
      }
      if (!is_near) {
        return Fail("edge length " + Number(target_) +
                    " is too large: a piece of the surface smaller than that is lost at " +
                    Point(p));
      }
    }
    return true;
  }

  const ImplicitFunction function_;
  const Eigen::AlignedBox3d bounds_;
  const double target_;
  const ImplicitMeshOptions options_;
  const double size_;
  std::string* const error_;

  std::array<std::vector<double>, 3> lattice_;  // Coordinates of its planes.
  double spacing_ = 0.0;
  bool negative_on_box_ = false, positive_on_box_ = false;
  double nearest_zero_ = std::numeric_limits<double>::infinity();
  Eigen::Vector3d nearest_zero_at_ = Eigen::Vector3d::Zero();
  std::vector<Eigen::Vector3d> near_misses_;

  std::unordered_map<std::uint64_t, int> vertex_on_edge_;
  TriangleMesh raw_;
  std::vector<Sides> sides_;
  std::vector<Eigen::Vector3d> normals_;  // Of the result.
};

}  // namespace

bool ImplicitMeshOptions::IsValid(std::string* error) const {
  const auto fail = [error](const std::string& name, double found, const std::string& allowed) {
    *error = name + " is " + Number(found) + "; allowed is " + allowed;
    return false;
  };
  if (!(max_normal_angle > 0.0 && max_normal_angle < 0.5 * M_PI)) {
    return fail("max_normal_angle", max_normal_angle, "> 0 and < pi/2");
  }
  if (max_triangles < 4 || max_triangles > 100000000) {
    return fail("max_triangles", max_triangles, "4 to 100000000");
  }
  if (max_samples < 27) {
    return fail("max_samples", static_cast<double>(max_samples), "27 or more");
  }
  if (num_remeshing_iterations < 0 || num_remeshing_iterations > 1000) {
    return fail("num_remeshing_iterations", num_remeshing_iterations, "0 to 1000");
  }
  return true;
}

bool MeshImplicitSurface(const Expression& function,
                         const Eigen::AlignedBox3d& bounds,
                         double target_edge_length,
                         const ImplicitMeshOptions& options,
                         TriangleMesh* mesh,
                         std::string* error) {
  return ImplicitMesher(function, bounds, target_edge_length, options, error).Run(mesh);
}

}  // namespace darboux
