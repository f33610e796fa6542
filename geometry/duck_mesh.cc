#include "geometry/duck_mesh.h"

#include <glog/logging.h>

#include <Eigen/Dense>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <optional>
#include <vector>

#include "geometry/expression.h"
#include "geometry/icosphere.h"
#include "geometry/implicit_function.h"

namespace darboux {
namespace {

struct Part {
  double x, z;       // Centre, mm.
  double a, b, c;    // Semi-axes along x, y, z before pitching, mm.
  double pitch_deg;  // Of the x axis, upwards.
};

constexpr Part kParts[] = {
    {-4.0, 26.0, 37.0, 35.0, 26.0, 0.0},    // Body
    {9.0, 44.0, 20.0, 18.5, 18.0, 0.0},     // Neck
    {14.0, 60.0, 20.5, 20.0, 20.0, 0.0},    // Head
    {31.6, 56.0, 13.5, 11.0, 6.5, 8.0},     // Beak
    {-29.9, 38.0, 17.5, 14.0, 9.5, -35.0},  // Tail
};
constexpr double kBlend = 2.5;  // mm

// Where triangles are to be smaller, at the tips of beak and tail: without it the few vertices of
// a coarse mesh slip off the beak. Areas are to go with 1 / (1 + sum of weight
// exp(-d^2 / (2 radius^2))), d the distance from (x, 0, z), mm.
struct Refinement {
  double x, z, weight, radius;
};
constexpr Refinement kRefinements[] = {{40.0, 57.0, 8.0, 14.0}, {-40.0, 46.0, 3.0, 12.0}};

// Where everything begins: a sphere in the body, mm.
constexpr Part kSeed = {-5.0, 27.0, 25.0, 25.0, 25.0, 0.0};

// The duck, grown to the fraction t; 1 is the whole.
std::string Formula(double t) {
  const auto mix = [t](double from, double to) { return from + t * (to - from); };
  std::string sum;
  for (const Part& part : kParts) {
    // S (p - c) = ((X cos + Z sin) / a, Y / b, (Z cos - X sin) / c) in metres.
    const double pitch = t * part.pitch_deg * M_PI / 180.0;
    const double a = 1e-3 * mix(kSeed.a, part.a), b = 1e-3 * mix(kSeed.b, part.b),
                 c = 1e-3 * mix(kSeed.c, part.c);
    const double x = 1e-3 * mix(kSeed.x, part.x), z = 1e-3 * mix(kSeed.z, part.z);
    const double k = 1e-3 * kBlend;
    const double weight = 0.5 * std::cbrt(a * b * c) / k;
    char term[512];
    std::snprintf(term,
                  sizeof(term),
                  "exp(%.6g*(1-(%.6g*(x-%.6g)+%.6g*(z-%.6g))^2-(%.6g*y)^2"
                  "-(%.6g*(z-%.6g)-%.6g*(x-%.6g))^2))",
                  weight,
                  std::cos(pitch) / a,
                  x,
                  std::sin(pitch) / a,
                  z,
                  1.0 / b,
                  std::cos(pitch) / c,
                  z,
                  std::sin(pitch) / c,
                  x);
    if (!sum.empty()) sum += "+";
    sum += term;
  }
  char factor[32];
  std::snprintf(factor, sizeof(factor), "-%.6g*log(", 1e-3 * kBlend);
  return factor + sum + ")";
}

// Vertices that are mirror images in y = 0.
std::vector<int> MirrorImages(const TriangleMesh& sphere) {
  const int n = static_cast<int>(sphere.vertices.size());
  std::vector<int> image(n, -1);
  for (int v = 0; v < n; ++v) {
    if (image[v] >= 0) continue;
    const Eigen::Vector3d mirrored = sphere.vertices[v].cwiseProduct(Eigen::Vector3d(1, -1, 1));
    double nearest = std::numeric_limits<double>::infinity();
    for (int w = 0; w < n; ++w) {
      const double distance = (sphere.vertices[w] - mirrored).squaredNorm();
      if (distance < nearest) {
        nearest = distance;
        image[v] = w;
      }
    }
    image[image[v]] = v;
  }
  return image;
}

// Evens a mesh within a surface at fixed connectivity. Every vertex in turn goes down the energy of
// its triangles
//
//   sum_t Q^3 + w (a + 1/a),  Q = (l_1^2 + l_2^2 + l_3^2) / (4 sqrt 3 A),  a = A rho / mean(A rho)
//
// with edges l_i, area A, the weight w of areas and their density rho: Q is 1 for equilateral
// triangles and infinite for folded ones.
class Relaxation {
 public:
  explicit Relaxation(const TriangleMesh& sphere)
      : mirror_image_(MirrorImages(sphere)),
        opposite_edges_(sphere.vertices.size()),
        density_(sphere.triangles.size()) {
    for (size_t t = 0; t < sphere.triangles.size(); ++t) {
      for (int k = 0; k < 3; ++k) {
        const std::array<int, 3>& corner = sphere.triangles[t];
        opposite_edges_[corner[k]].push_back(
            {corner[(k + 1) % 3], corner[(k + 2) % 3], static_cast<int>(t)});
      }
    }
  }

  // Back to the surface, along its gradient.
  void Project(const ImplicitFunction& function, TriangleMesh* mesh) const {
    for (Eigen::Vector3d& p : mesh->vertices) {
      Eigen::Vector3d gradient;
      CHECK(Project(function, &p, &gradient)) << p.transpose();
    }
  }

  void Sweep(const ImplicitFunction& function,
             double t_grown,
             double area_weight,
             TriangleMesh* mesh) {
    area_weight_ = area_weight;
    UpdateDensity(t_grown, *mesh);
    for (size_t v = 0; v < mesh->vertices.size(); ++v) {
      const size_t image = static_cast<size_t>(mirror_image_[v]);
      if (image < v) continue;
      Eigen::Vector3d& p = mesh->vertices[v];
      Eigen::Vector3d normal, descent;
      function.Value(p, &normal);
      normal.normalize();
      const double energy = Energy(*mesh, v, p, normal, &descent);
      descent -= descent.dot(normal) * normal;
      if (image == v) descent.y() = 0.0;
      const double edge = (mesh->vertices[opposite_edges_[v][0].a] - p).norm();
      Eigen::Vector3d step = 0.05 * edge * edge * descent;
      if (step.norm() > 0.2 * edge) step *= 0.2 * edge / step.norm();
      for (int i = 0; i < 6; ++i, step *= 0.5) {
        Eigen::Vector3d q = p + step;
        if (!Project(function, &q, &normal)) continue;
        if (image == v) q.y() = 0.0;
        if (!(Energy(*mesh, v, q, normal.normalized(), &descent) < energy)) continue;
        p = q;
        break;
      }
      if (image != v) mesh->vertices[image] = p.cwiseProduct(Eigen::Vector3d(1.0, -1.0, 1.0));
    }
  }

 private:
  struct OppositeEdge {
    int a, b, triangle;
  };

  static bool Project(const ImplicitFunction& function,
                      Eigen::Vector3d* p,
                      Eigen::Vector3d* gradient) {
    const double size = DuckBounds().diagonal().norm();
    return function.Project(size, 0.5 * size, Eigen::Vector3d::Ones(), p, gradient) ==
           ImplicitFunction::Projection::kOnSurface;
  }

  // density_ is divided by the mean of A rho.
  void UpdateDensity(double t_grown, const TriangleMesh& mesh) {
    double sum = 0.0;
    for (size_t t = 0; t < mesh.triangles.size(); ++t) {
      const Eigen::Vector3d &a = mesh.vertices[mesh.triangles[t][0]],
                            &b = mesh.vertices[mesh.triangles[t][1]],
                            &c = mesh.vertices[mesh.triangles[t][2]];
      density_[t] = 1.0;
      for (const Refinement& r : kRefinements) {
        const double d2 = ((a + b + c) / 3.0 - 1e-3 * Eigen::Vector3d(r.x, 0.0, r.z)).squaredNorm();
        density_[t] += t_grown * r.weight * std::exp(-0.5e6 * d2 / (r.radius * r.radius));
      }
      sum += density_[t] * 0.5 * (b - a).cross(c - a).norm();
    }
    for (double& density : density_) density *= static_cast<double>(density_.size()) / sum;
  }

  // Of the triangles at v, were it at p; also the direction in which it decreases.
  double Energy(const TriangleMesh& mesh,
                size_t v,
                const Eigen::Vector3d& p,
                const Eigen::Vector3d& surface_normal,
                Eigen::Vector3d* descent) const {
    double energy = 0.0;
    descent->setZero();
    for (const OppositeEdge& edge : opposite_edges_[v]) {
      const Eigen::Vector3d &a = mesh.vertices[edge.a], &b = mesh.vertices[edge.b];
      Eigen::Vector3d normal = (a - p).cross(b - p);
      if (!(normal.dot(surface_normal) > 0.0)) return std::numeric_limits<double>::infinity();
      const double norm = normal.norm();
      const double area = 0.5 * norm;
      normal /= norm;
      const double squares = (a - p).squaredNorm() + (b - p).squaredNorm() + (a - b).squaredNorm();
      const double quality = squares / (4.0 * std::sqrt(3.0) * area);
      const double relative_area = area * density_[edge.triangle];
      energy += quality * quality * quality + area_weight_ * (relative_area + 1.0 / relative_area);
      const Eigen::Vector3d d_area = 0.5 * normal.cross(b - a);
      const Eigen::Vector3d d_squares = 2.0 * (2.0 * p - a - b);
      *descent -= 3.0 * quality * quality * quality * (d_squares / squares - d_area / area) +
                  area_weight_ * (relative_area - 1.0 / relative_area) / area * d_area;
    }
    return energy;
  }

  const std::vector<int> mirror_image_;
  std::vector<std::vector<OppositeEdge>> opposite_edges_;  // Per vertex.
  std::vector<double> density_;                            // Per triangle.
  double area_weight_ = 0.0;
};

}  // namespace

std::string DuckFormula() { return Formula(1.0); }

Eigen::AlignedBox3d DuckBounds() {
  return {Eigen::Vector3d(-0.06, -0.045, -0.01), Eigen::Vector3d(0.06, 0.045, 0.09)};
}

TriangleMesh MakeDuckMesh(int frequency) {
  CHECK_GE(frequency, 4);
  constexpr int kGrowthSteps = 40;
  const int sweeps_per_step = 2 * frequency;
  const int last_sweeps = 50 * frequency;

  TriangleMesh mesh = MakeIcosphere(1e-3 * kSeed.a, frequency);
  Relaxation relaxation(mesh);
  for (Eigen::Vector3d& p : mesh.vertices) p += Eigen::Vector3d(1e-3 * kSeed.x, 0, 1e-3 * kSeed.z);
  for (int step = 0; step <= kGrowthSteps; ++step) {
    const double t = static_cast<double>(step) / kGrowthSteps;
    std::string error;
    const std::optional<Expression> expression =
        Expression::Parse(Formula(t), {"x", "y", "z"}, &error);
    CHECK(expression.has_value()) << error;
    const ImplicitFunction function(*expression);
    relaxation.Project(function, &mesh);
    const bool is_grown = step == kGrowthSteps;
    const int sweeps = is_grown ? last_sweeps : sweeps_per_step;
    // Areas count more while the beak pulls its vertices out of the head.
    const double area_weight = is_grown ? 4.0 : 6.0;
    for (int i = 0; i < sweeps; ++i) relaxation.Sweep(function, t, area_weight, &mesh);
  }
  return mesh;
}

}  // namespace darboux
