#include "geometry/scan_simulator.h"

#include <glog/logging.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "geometry/mesh_builder.h"
#include "geometry/occlusion.h"
#include "geometry/random_stream.h"
#include "geometry/text_file.h"

namespace darboux {
namespace {

using Eigen::AlignedBox3d;
using Eigen::Vector3d;

constexpr double kPi = 3.14159265358979323846;
// Rays start at the face, and end at bodies, to this part of the extent.
constexpr double kTolerance = 1e-9;
// One in so many random points has to be seen.
constexpr std::uint64_t kTriesPerPoint = 200;
constexpr std::uint64_t kFirstTries = 15;
constexpr int kMostPoints = 10000000;
// Waves that a bias field is the sum of.
constexpr int kWaves = 256;

// What random numbers are for; the numbers are part of what a seed means.
enum Purpose : std::uint64_t { kPlace = 1, kNoise, kOutlier, kWhichOutlier, kWave, kMotion, kPick };

AlignedBox3d Bounds(const ScanSurface& surface) {
  AlignedBox3d box;
  for (const Vector3d& vertex : surface.mesh.vertices) box.extend(vertex);
  for (const FacePoint& point : surface.points) box.extend(point.position);
  return box;
}

// N. Max, "Weights for computing vertex normals from facet normals" (1999): exact on spheres, and
// no angle, which would differ between machines in the last digit.
std::vector<Vector3d> VertexNormals(const TriangleMesh& mesh) {
  std::vector<Vector3d> normals(mesh.vertices.size(), Vector3d::Zero());
  for (const std::array<int, 3>& triangle : mesh.triangles) {
    std::array<Vector3d, 3> x;
    for (std::size_t k = 0; k < 3; ++k) {
      x[k] = mesh.vertices[static_cast<std::size_t>(triangle[k])];
    }
    const Vector3d normal = (x[1] - x[0]).cross(x[2] - x[0]);
    for (std::size_t k = 0; k < 3; ++k) {
      const double next = (x[(k + 1) % 3] - x[k]).squaredNorm();
      const double last = (x[(k + 2) % 3] - x[k]).squaredNorm();
      if (!(next > 0.0 && last > 0.0)) continue;
      normals[static_cast<std::size_t>(triangle[k])] += normal / next / last;
    }
  }
  for (Vector3d& normal : normals) normal.stableNormalize();
  return normals;
}

// The sum of waves cos(k . x + phase) with Gaussian k has, over all seeds, the Gaussian correlation
// (A. Rahimi and B. Recht, "Random features for large-scale kernel machines", 2007).
class SmoothField {
 public:
  SmoothField(std::uint64_t seed, const Vector3d& center, double length) : center_(center) {
    for (int m = 0; m < kWaves; ++m) {
      RandomStream random(seed, kWave, static_cast<std::uint64_t>(m));
      const double a = random.Normal(), b = random.Normal(), c = random.Normal();
      waves_.push_back(Vector3d(a, b, c) / (2.0 * kPi * length));
      phases_.push_back(random.Uniform());
    }
  }

  double operator()(const Vector3d& x) const {
    double sum = 0.0;
    for (std::size_t m = 0; m < waves_.size(); ++m) {
      double sine, cosine;
      PortableSinCos(waves_[m].dot(x - center_) + phases_[m], &sine, &cosine);
      sum += cosine;
    }
    return sum;
  }

 private:
  Vector3d center_;
  std::vector<Vector3d> waves_;  // turns per length
  std::vector<double> phases_;   // turns
};

// Which points of a face are seen, and from where.
class Eyes {
 public:
  Eyes(const ScanSurface& surface,
       const std::vector<Occluder>& occluders,
       const ScanOptions& options,
       double extent)
      : occluders_(occluders),
        viewpoints_(options.viewpoints),
        extent_(extent),
        occlusion_(surface, kTolerance * extent) {
    double sine;
    PortableSinCos(options.grazing_deg / 360.0, &sine, &least_cosine_);
  }

  // The viewpoint; -1: none sees it, or there are no viewpoints.
  int Find(const FacePoint& point) const {
    // From the best viewpoint on: most of the others need not be asked.
    std::vector<std::pair<double, int>> order;
    const bool has_normal = !point.normal.isZero(0.0);
    for (std::size_t v = 0; v < viewpoints_.size(); ++v) {
      const Vector3d ray = viewpoints_[v] - point.position;
      const double distance = ray.norm();
      if (!(distance > 0.0)) continue;
      const double cosine = has_normal ? point.normal.dot(ray) / distance : 0.0;
      if (has_normal && cosine < least_cosine_) continue;
      order.emplace_back(has_normal ? -cosine : distance, static_cast<int>(v));
    }
    std::sort(order.begin(), order.end());
    for (const auto& [unused, v] : order) {
      if (Sees(viewpoints_[static_cast<std::size_t>(v)], point.position)) return v;
    }
    return -1;
  }

 private:
  bool Sees(const Vector3d& viewpoint, const Vector3d& x) const {
    const Vector3d ray = viewpoint - x;
    const double length = ray.norm();
    if (occlusion_.IsCut(x, ray / length, length)) return false;
    return std::none_of(occluders_.begin(), occluders_.end(), [&](const Occluder& body) {
      return CutsSegment(body, x, viewpoint, extent_);
    });
  }

  const std::vector<Occluder>& occluders_;
  const std::vector<Vector3d>& viewpoints_;
  double extent_;
  double least_cosine_ = 0.0;
  Occlusion occlusion_;
};

// Random places on triangles, uniform by area.
class Places {
 public:
  explicit Places(const ScanSurface& surface) : surface_(surface) {
    for (const std::array<int, 3>& triangle : surface.mesh.triangles) {
      const Vector3d a = Vertex(triangle[0]);
      total_ += 0.5 * (Vertex(triangle[1]) - a).cross(Vertex(triangle[2]) - a).norm();
      sums_.push_back(total_);
    }
  }

  double area() const { return total_; }

  FacePoint Draw(RandomStream* random) const {
    const double at = random->Uniform() * total_;
    // The first sum above: a triangle without area is never drawn.
    const auto found = std::upper_bound(sums_.begin(), sums_.end(), at);
    const std::size_t t =
        std::min(static_cast<std::size_t>(found - sums_.begin()), sums_.size() - 1);
    double b1 = random->Uniform(), b2 = random->Uniform();
    if (b1 + b2 > 1.0) {
      b1 = 1.0 - b1;
      b2 = 1.0 - b2;
    }
    if (surface_.evaluate) return surface_.evaluate(static_cast<int>(t), b1, b2);
    const std::array<int, 3>& triangle = surface_.mesh.triangles[t];
    const Vector3d a = Vertex(triangle[0]);
    const Vector3d ab = Vertex(triangle[1]) - a, ac = Vertex(triangle[2]) - a;
    return {a + b1 * ab + b2 * ac, ab.cross(ac).stableNormalized()};
  }

 private:
  const Vector3d& Vertex(int v) const {
    return surface_.mesh.vertices[static_cast<std::size_t>(v)];
  }

  const ScanSurface& surface_;
  std::vector<double> sums_;  // of the areas up to each triangle
  double total_ = 0.0;
};

std::string Number(double value) {
  std::string text;
  AppendNumber(value, &text);
  return text;
}

}  // namespace

bool ScanOptions::IsValid(std::string* error) const {
  const auto fail = [&](const char* name, double found, const char* allowed) {
    *error = std::string(name) + ": found " + Number(found) + "; allowed " + allowed;
    return false;
  };
  const auto in = [](double value, double low, double high) {
    return value >= low && value <= high && std::isfinite(value);
  };
  constexpr double kMax = std::numeric_limits<double>::max();
  if (num_points < 1 || num_points > kMostPoints) {
    return fail("num_points", num_points, "1 to 10000000");
  }
  if (!(grazing_deg > 0.0 && grazing_deg <= 90.0)) {
    return fail("grazing_deg", grazing_deg, "an angle in (0, 90] degrees");
  }
  if (!in(noise, 0.0, kMax)) return fail("noise", noise, "a length >= 0");
  if (!in(bias, 0.0, kMax)) return fail("bias", bias, "a length >= 0");
  if (!in(bias_length, 0.0, kMax)) {
    return fail("bias_length", bias_length, "a length > 0, or 0 for a quarter of the extent");
  }
  if (!in(outliers, 0.0, 1.0)) return fail("outliers", outliers, "a part in [0, 1]");
  if (!in(spike_share, 0.0, 1.0)) return fail("spike_share", spike_share, "a part in [0, 1]");
  if (!in(spike_size, 0.0, kMax))
    return fail("spike_size", spike_size, "a part >= 0 of the extent");
  if (!in(outlier_box, 0.0, kMax)) return fail("outlier_box", outlier_box, "a factor >= 0");
  if (!in(max_angle_deg, 0.0, 180.0)) {
    return fail("max_angle_deg", max_angle_deg, "an angle in [0, 180] degrees");
  }
  if (!in(max_translation, 0.0, kMax)) {
    return fail("max_translation", max_translation, "a factor >= 0 of the extent");
  }
  for (const Vector3d& viewpoint : viewpoints) {
    if (!viewpoint.allFinite()) {
      return fail("viewpoints", std::numeric_limits<double>::quiet_NaN(), "finite numbers");
    }
  }
  return true;
}

FacePoint EvaluateFace(const ShellSurface& surface,
                       const Eigen::Matrix3Xd& displacements,
                       double offset,
                       const ElementPoint& at) {
  const StrainPoint point = surface.MakePoint(at);
  const std::vector<int>& vertices = surface.control_vertices(at.element);
  Vector3d x = point.position, x1 = point.t1, x2 = point.t2;
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    const auto column = static_cast<Eigen::Index>(i);
    const Vector3d u = displacements.col(vertices[i]);
    x += point.weights(kRowValue, column) * u;
    x1 += point.weights(kRowD1, column) * u;
    x2 += point.weights(kRowD2, column) * u;
  }
  const Vector3d normal = x1.cross(x2);
  const double length = normal.norm();
  // A crumpled point has none; the rest state's is as good as any.
  const Vector3d n = length > 0.0 && std::isfinite(length) ? Vector3d(normal / length) : point.n;
  return {x + offset * n, n};
}

ScanSurface ScanSurfaceOf(const ShellSurface& surface,
                          const Eigen::Matrix3Xd& displacements,
                          double offset,
                          int parts) {
  CHECK_GE(parts, 1);
  CHECK_EQ(displacements.cols(), surface.mesh().num_vertices);
  const auto evaluate = [&surface, displacements, offset](const ElementPoint& at) {
    return EvaluateFace(surface, displacements, offset, at);
  };
  ScanSurface scanned;
  struct Corner {
    double s, t;
  };
  std::vector<std::array<Corner, 3>> cells;  // of an element, in the order of its triangles
  const double size = 1.0 / parts;
  std::vector<Corner> corners;
  std::vector<std::array<int, 3>> triangles;
  for (int j = 0; j <= parts; ++j) {
    for (int i = 0; i + j <= parts; ++i) {
      const int here = static_cast<int>(corners.size()), above = here + parts + 1 - j;
      corners.push_back({i * size, j * size});
      if (i + j < parts) triangles.push_back({here, here + 1, above});
      if (i + j + 1 < parts) triangles.push_back({here + 1, above + 1, above});
    }
  }
  for (const std::array<int, 3>& triangle : triangles) {
    cells.push_back({corners[static_cast<std::size_t>(triangle[0])],
                     corners[static_cast<std::size_t>(triangle[1])],
                     corners[static_cast<std::size_t>(triangle[2])]});
  }
  for (int e = 0; e < surface.num_elements(); ++e) {
    const int first = static_cast<int>(scanned.mesh.vertices.size());
    for (const Corner& corner : corners) {
      scanned.mesh.vertices.push_back(evaluate({e, corner.s, corner.t}).position);
    }
    for (const std::array<int, 3>& triangle : triangles) {
      scanned.mesh.triangles.push_back(
          {first + triangle[0], first + triangle[1], first + triangle[2]});
    }
  }
  scanned.evaluate = [evaluate, cells](int triangle, double b1, double b2) {
    const int count = static_cast<int>(cells.size());
    const std::array<Corner, 3>& cell = cells[static_cast<std::size_t>(triangle % count)];
    const double s = cell[0].s + b1 * (cell[1].s - cell[0].s) + b2 * (cell[2].s - cell[0].s);
    const double t = cell[0].t + b1 * (cell[1].t - cell[0].t) + b2 * (cell[2].t - cell[0].t);
    // Rounding must not lead out of the element.
    const double in_s = std::min(std::max(s, 0.0), 1.0);
    return evaluate({triangle / count, in_s, std::min(std::max(t, 0.0), 1.0 - in_s)});
  };
  return scanned;
}

ScanSurface ScanSurfaceOf(TriangleMesh mesh, std::vector<Vector3d> normals, double offset) {
  ScanSurface scanned;
  scanned.mesh = std::move(mesh);
  if (offset == 0.0) return scanned;
  if (normals.empty()) normals = VertexNormals(scanned.mesh);
  CHECK_EQ(normals.size(), scanned.mesh.vertices.size());
  for (std::size_t v = 0; v < normals.size(); ++v) scanned.mesh.vertices[v] += offset * normals[v];
  return scanned;
}

void ScanVertices(ScanSurface* surface) {
  const TriangleMesh& mesh = surface->mesh;
  const std::vector<Vector3d> normals = VertexNormals(mesh);
  std::vector<bool> is_used(mesh.vertices.size(), false);
  for (const std::array<int, 3>& triangle : mesh.triangles) {
    for (const int v : triangle) is_used[static_cast<std::size_t>(v)] = true;
  }
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
    if (is_used[v]) surface->points.push_back({mesh.vertices[v], normals[v]});
  }
}

std::vector<Vector3d> ViewpointsAround(const ScanSurface& surface, int count, double distance) {
  const AlignedBox3d box = Bounds(surface);
  CHECK(!box.isEmpty());
  const double radius = distance * 0.5 * box.diagonal().norm();
  std::vector<Vector3d> directions;
  if (count == 6) {
    for (int k = 0; k < 3; ++k) {
      directions.push_back(Vector3d::Unit(k));
      directions.push_back(-Vector3d::Unit(k));
    }
  } else if (count == 8) {
    for (int k = 0; k < 8; ++k) {
      directions.push_back(Vector3d(k & 1 ? -1 : 1, k & 2 ? -1 : 1, k & 4 ? -1 : 1) /
                           std::sqrt(3.0));
    }
  } else {
    const double golden = 0.5 * (std::sqrt(5.0) - 1.0);  // turns from one to the next
    for (int k = 0; k < count; ++k) {
      const double z = 1.0 - (2.0 * k + 1.0) / count, r = std::sqrt(1.0 - z * z);
      double sine, cosine;
      PortableSinCos(k * golden, &sine, &cosine);
      directions.emplace_back(r * cosine, r * sine, z);
    }
  }
  std::vector<Vector3d> viewpoints;
  for (const Vector3d& direction : directions) {
    viewpoints.push_back(box.center() + radius * direction);
  }
  return viewpoints;
}

bool CutsSegment(const Occluder& body, const Vector3d& from, const Vector3d& to, double scale) {
  const Vector3d way = to - from;
  const double length = way.norm();
  if (!(length > 0.0)) return false;
  const Vector3d direction = way / length;
  const Ball ball = body.pose.Bounds(*body.shape);
  if (std::isfinite(ball.radius)) {
    const double along = std::min(std::max((ball.center - from).dot(direction), 0.0), length);
    if ((from + along * direction - ball.center).norm() > ball.radius + kTolerance * scale) {
      return false;
    }
  }
  const double tolerance = kTolerance * scale;
  const bool is_convex = body.shape->IsConvex();
  // Along the ray the distance phi changes by no more than the way, so phi is a safe step. Where
  // the body is convex phi is a convex function of the way: it never falls again once it has grown,
  // and Newton's steps, which are longer, never jump over its zero. Grazing rays take many steps.
  constexpr int kMaxSteps = 10000;
  double at = 0.0;
  for (int step = 0; step < kMaxSteps; ++step) {
    Distance distance;
    body.pose.Evaluate(*body.shape, from + at * direction, &distance);
    const double phi = distance.value;
    // A step that shrinks with phi comes to an end above a zero, never on it.
    if (phi <= (is_convex && step == 0 ? 0.0 : tolerance)) return true;
    if (is_convex) {
      const double slope = distance.normal.dot(direction);
      if (slope >= 0.0) return false;
      at += phi / -slope;
    } else {
      at += phi;
    }
    if (at >= length) return false;
  }
  return true;
}

bool SimulateScan(const ScanSurface& surface,
                  const std::vector<Occluder>& occluders,
                  const ScanOptions& options,
                  Scan* scan,
                  std::string* error) {
  *scan = Scan();
  if (!options.IsValid(error)) return false;
  const auto fail = [&](const std::string& what) {
    *error = "found " + what;
    return false;
  };
  const AlignedBox3d box = Bounds(surface);
  const bool has_points = !surface.points.empty();
  const Places places(surface);
  if (box.isEmpty() || (!has_points && surface.mesh.triangles.empty())) {
    return fail("nothing to scan; allowed triangles or points");
  }
  const double extent = box.diagonal().norm();
  if (!std::isfinite(extent) || !(extent > 0.0) ||
      (!has_points && !(std::isfinite(places.area()) && places.area() > 0.0))) {
    return fail("a surface without any extent, or an infinite one; allowed a finite one");
  }
  bool has_normals = true;
  for (const FacePoint& point : surface.points) {
    if (point.normal.isZero(0.0)) has_normals = false;
  }
  if (!has_normals && options.viewpoints.empty() &&
      (options.noise > 0.0 || options.outliers > 0.0)) {
    return fail("points without normals and no viewpoints; allowed either, for the rays");
  }
  if (!has_normals && options.bias > 0.0 && !options.bias_along_ray) {
    return fail("a bias along normals of points without any; allowed one along the rays");
  }
  if (!has_normals && options.bias > 0.0 && options.viewpoints.empty()) {
    return fail("points without normals and no viewpoints; allowed either, for the rays");
  }
  scan->extent = extent;
  const double length = scan->bias_length =
      options.bias_length > 0.0 ? options.bias_length : 0.25 * extent;

  // The points that are seen. Each has a number of its own, which its random numbers go by.
  const Eyes eyes(surface, occluders, options, extent);
  struct Seen {
    FacePoint face;
    int view;
    std::uint64_t number;
  };
  std::vector<Seen> seen;
  const auto look = [&](const FacePoint& face, std::uint64_t number) {
    const int view = eyes.Find(face);
    if (view >= 0 || options.viewpoints.empty()) seen.push_back({face, view, number});
  };
  const auto num_points = static_cast<std::size_t>(options.num_points);
  if (has_points) {
    // All are looked at, and of those seen as many as asked for are picked at random.
    scan->num_tried = static_cast<int>(surface.points.size());
    for (std::size_t i = 0; i < surface.points.size(); ++i) look(surface.points[i], i);
    if (seen.size() > num_points) {
      const auto key = [&](const Seen& s) {
        return RandomStream(options.seed, kPick, s.number).Bits();
      };
      std::nth_element(seen.begin(),
                       seen.begin() + static_cast<std::ptrdiff_t>(num_points),
                       seen.end(),
                       [&](const Seen& a, const Seen& b) {
                         return std::make_pair(key(a), a.number) < std::make_pair(key(b), b.number);
                       });
      seen.resize(num_points);
      std::sort(seen.begin(), seen.end(), [](const Seen& a, const Seen& b) {
        return a.number < b.number;
      });
    }
    if (seen.empty()) {
      return fail("no point that can be seen; allowed one at least, from viewpoints outside");
    }
  } else {
    for (std::uint64_t i = 0; seen.size() < num_points; ++i) {
      // A few more than one in so many at first, when that is still left to chance.
      if (i >= kTriesPerPoint * (seen.size() + kFirstTries)) {
        return fail("only " + std::to_string(seen.size()) + " of " + std::to_string(i) +
                    " random points that can be seen; allowed 1 in " +
                    std::to_string(kTriesPerPoint));
      }
      RandomStream random(options.seed, kPlace, i);
      look(places.Draw(&random), i);
      scan->num_tried = static_cast<int>(std::min<std::uint64_t>(i + 1, 2147483647));
    }
  }

  // Exactly this part of them is wrong: those with the smallest keys.
  const std::size_t count = seen.size();
  const auto num_wrong =
      static_cast<std::size_t>(std::floor(options.outliers * static_cast<double>(count) + 0.5));
  const auto num_spikes = static_cast<std::size_t>(
      std::floor(options.spike_share * static_cast<double>(num_wrong) + 0.5));
  std::vector<std::pair<std::uint64_t, std::size_t>> keys;
  for (std::size_t i = 0; i < count; ++i) {
    keys.emplace_back(RandomStream(options.seed, kWhichOutlier, seen[i].number).Bits(), i);
  }
  std::sort(keys.begin(), keys.end());
  std::vector<OutlierKind> kinds(count, OutlierKind::kNone);
  for (std::size_t k = 0; k < num_wrong; ++k) {
    kinds[keys[k].second] = k < num_spikes ? OutlierKind::kSpike : OutlierKind::kStray;
  }
  scan->num_spikes = static_cast<int>(num_spikes);
  scan->num_strays = static_cast<int>(num_wrong - num_spikes);

  std::vector<double> bias(count, 0.0);
  if (options.bias > 0.0) {
    const SmoothField field(options.seed, box.center(), length);
    double sum = 0.0;
    for (std::size_t i = 0; i < count; ++i) {
      bias[i] = field(seen[i].face.position);
      sum += bias[i] * bias[i];
    }
    const double rms = std::sqrt(sum / static_cast<double>(count));
    for (double& b : bias) b *= options.bias / rms;
  }

  RigidPose scan_from_model;
  if (options.moves) {
    RandomStream random(options.seed, kMotion, 0);
    const Vector3d turn = random.InBall(), shift = random.InBall();
    const double part = turn.norm();
    double sine, cosine;
    PortableSinCos(0.5 * options.max_angle_deg * part / 360.0, &sine, &cosine);
    if (part > 0.0) {
      const Vector3d axis = turn / part;
      scan_from_model.rotation =
          Eigen::Quaterniond(cosine, sine * axis.x(), sine * axis.y(), sine * axis.z())
              .normalized();
    }
    const Vector3d center = box.center();
    scan_from_model.translation =
        center + options.max_translation * extent * shift - scan_from_model.rotation * center;
  }
  scan->model_from_scan = scan_from_model.Inverse();

  for (std::size_t i = 0; i < count; ++i) {
    ScanTruth truth;
    truth.face = seen[i].face;
    truth.number = seen[i].number;
    truth.view = seen[i].view;
    truth.outlier = kinds[i];
    RandomStream noise(options.seed, kNoise, seen[i].number);
    RandomStream wrong(options.seed, kOutlier, seen[i].number);
    Vector3d x = truth.face.position;
    Vector3d normal = truth.face.normal;
    if (truth.outlier == OutlierKind::kStray) {
      const double a = wrong.Uniform(), b = wrong.Uniform(), c = wrong.Uniform();
      x = box.center() +
          options.outlier_box * box.sizes().cwiseProduct(Vector3d(a - 0.5, b - 0.5, c - 0.5));
      truth.face = {x, Vector3d::Zero()};
      truth.view = -1;
      if (has_normals) normal = wrong.Direction();
    } else {
      const Vector3d ray =
          truth.view < 0 ? normal
                         : Vector3d((x - options.viewpoints[static_cast<std::size_t>(truth.view)])
                                        .stableNormalized());
      truth.noise = options.noise * noise.Normal();
      truth.bias = bias[i];
      x += truth.noise * ray + truth.bias * (options.bias_along_ray ? ray : normal);
      if (truth.outlier == OutlierKind::kSpike) {
        x += options.spike_size * extent * (2.0 * wrong.Uniform() - 1.0) * ray;
      }
    }
    scan->cloud.points.push_back(scan_from_model * x);
    if (has_normals) {
      scan->cloud.normals.push_back((scan_from_model.rotation * normal).normalized());
    }
    scan->truth.push_back(truth);
  }
  return true;
}

}  // namespace darboux
