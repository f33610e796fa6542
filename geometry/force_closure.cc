#include "geometry/force_closure.h"

#include <glog/logging.h>
#include <libqhull_r/libqhull_r.h>

#include <Eigen/Geometry>
#include <Eigen/QR>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <cstdio>

namespace darboux {
namespace {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Wrench = Eigen::Matrix<double, 6, 1>;
using Wrenches = Eigen::Matrix<double, 6, Eigen::Dynamic>;

constexpr double kPi = 3.14159265358979323846;
// Of the largest wrench: what is no more than rounding.
constexpr double kRounding = 1e-9;
// Part of a motion that is not worth a word.
constexpr double kNegligible = 1e-6;

// Unit and across the normal of contact i, see the header.
Vector3d FirstEdge(const std::vector<GraspContact>& contacts,
                   const Vector3d& center,
                   double length,
                   size_t i) {
  const Vector3d &p = contacts[i].position, &n = contacts[i].normal;
  std::vector<Vector3d> towards;
  Vector3d mean = Vector3d::Zero();
  for (const GraspContact& contact : contacts) mean += contact.position / contacts.size();
  towards.push_back(mean - p);
  for (const GraspContact& contact : contacts) towards.push_back(contact.position - p);
  towards.push_back(center - p);
  for (const Vector3d& way : towards) {
    const Vector3d across = way - n * n.dot(way);
    if (across.norm() > kNegligible * length) return across.normalized();
  }
  // All on one line, normals along it: any direction will do that is the same for all.
  const Vector3d any = contacts.front().normal.unitOrthogonal();
  const Vector3d across = any - n * n.dot(any);
  return across.norm() > kNegligible ? Vector3d(across.normalized()) : n.unitOrthogonal();
}

struct Facet {
  Wrench normal;  // outward, unit
  double offset;  // normal . x + offset <= 0 within
};

// The convex hull of points that span the space. Empty where Qhull gives up.
std::vector<Facet> Hull(const Wrenches& points) {
  std::vector<Facet> facets;
  std::FILE* const silent = std::fopen("/dev/null", "w");
  Wrenches copy = points;
  char command[] = "qhull Qx";  // facets that rounding splits are merged
  qhT storage;
  qhT* const qh = &storage;
  qh_zero(qh, silent != nullptr ? silent : stderr);
  const int failed = qh_new_qhull(qh,
                                  6,
                                  static_cast<int>(copy.cols()),
                                  copy.data(),
                                  False,
                                  command,
                                  nullptr,
                                  silent != nullptr ? silent : stderr);
  if (failed == 0) {
    facetT* facet;
    FORALLfacets { facets.push_back({Eigen::Map<const Wrench>(facet->normal), facet->offset}); }
  }
  qh_freeqhull(qh, qh_ALL);
  int kept, total;
  qh_memfreeshort(qh, &kept, &total);
  if (silent != nullptr) std::fclose(silent);
  return facets;
}

// Whether some x >= 0 has a x = b, to rounding: non-negative least squares (C. L. Lawson, R. J.
// Hanson, 1974, chapter 23).
bool HasNonNegativeSolution(const Wrenches& a, const Wrench& b) {
  const int n = static_cast<int>(a.cols());
  Eigen::VectorXd x = Eigen::VectorXd::Zero(n);
  std::vector<int> passive;  // columns with x > 0
  const auto solve = [&] {
    MatrixXd columns(6, passive.size());
    for (size_t k = 0; k < passive.size(); ++k) columns.col(k) = a.col(passive[k]);
    return Eigen::VectorXd(columns.colPivHouseholderQr().solve(b));
  };
  for (int iteration = 0; iteration < 10 * n; ++iteration) {
    const Wrench residual = b - a * x;
    if (residual.norm() <= kRounding * b.norm()) return true;
    Eigen::VectorXd slope = a.transpose() * residual;
    for (const int k : passive) slope[k] = 0.0;
    Eigen::Index enters;
    // Nothing that would make it smaller: it is the distance from b to the cone of the columns.
    if (slope.maxCoeff(&enters) <= kRounding * b.norm() * a.col(enters).norm()) return false;
    passive.push_back(static_cast<int>(enters));
    Eigen::VectorXd next = solve();
    while (next.minCoeff() <= 0.0) {
      // As far as the first that would become negative; that one leaves.
      double part = 1.0;
      for (size_t k = 0; k < passive.size(); ++k) {
        const double now = x[passive[k]];
        if (next[k] <= 0.0) part = std::min(part, now / (now - next[k]));
      }
      std::vector<int> stay;
      for (size_t k = 0; k < passive.size(); ++k) {
        double& now = x[passive[k]];
        now += part * (next[k] - now);
        if (next[k] <= 0.0 && now <= 1e-14 * x.maxCoeff()) {
          now = 0.0;
        } else {
          stay.push_back(passive[k]);
        }
      }
      if (stay.size() == passive.size()) return false;
      passive.swap(stay);
      if (passive.empty()) break;
      next = solve();
    }
    for (size_t k = 0; k < passive.size(); ++k) x[passive[k]] = next[k];
  }
  return false;
}

int Rank(const Eigen::VectorXd& singular_values) {
  return static_cast<int>((singular_values.array() > kRounding * singular_values[0]).count());
}

// ---- What is lacking, in words --------------------------------------------------------------

std::string Text(double value) {
  char buffer[32];
  std::snprintf(buffer, sizeof(buffer), "%.3g", value == 0.0 ? 0.0 : value);
  return buffer;
}

std::string Text(Vector3d v, double scale) {
  for (int i = 0; i < 3; ++i) {
    if (std::abs(v[i]) < 1e-4 * scale) v[i] = 0.0;
  }
  return "(" + Text(v[0]) + ", " + Text(v[1]) + ", " + Text(v[2]) + ")";
}

// A motion (velocity at the centre, length * angular velocity) on which no wrench, or one_sided
// none but a negative one, does work.
std::string Describe(const Wrench& motion,
                     bool one_sided,
                     const std::vector<GraspContact>& contacts,
                     const Vector3d& center,
                     double length) {
  const Vector3d v = motion.head<3>(), w = motion.tail<3>() / length;
  if (motion.tail<3>().norm() < kNegligible * motion.norm()) {
    return (one_sided ? "no force towards " : "no force along ") + Text(v.normalized(), 1.0);
  }
  const Vector3d axis = w.normalized();
  const Vector3d point = center + w.cross(v) / w.squaredNorm();
  const double pitch = w.dot(v) / w.squaredNorm();
  const bool screw = std::abs(pitch) > kNegligible * length;
  const bool through_contacts =
      contacts.size() > 1 &&
      std::all_of(contacts.begin(), contacts.end(), [&](const GraspContact& c) {
        return axis.cross(c.position - point).norm() < 1e-4 * length;
      });
  std::string text = screw ? "no wrench about the screw" : "no moment about the axis";
  if (!screw && through_contacts) return "no moment about the line of the contacts";
  text += " through " + Text(point, length) + (one_sided ? ", right-handed, along " : " along ") +
          Text(axis, 1.0);
  if (screw) text += " of pitch " + Text(pitch);
  return text;
}

// Orthonormal columns of the space of `basis`, along the axes as far as that goes.
MatrixXd AlongAxes(MatrixXd basis) {
  MatrixXd result(basis.rows(), 0);
  while (basis.cols() > 0) {
    Eigen::Index axis;
    basis.rowwise().norm().maxCoeff(&axis);
    const Eigen::VectorXd part = basis.row(axis).transpose().normalized();
    result.conservativeResize(Eigen::NoChange, result.cols() + 1);
    result.rightCols<1>() = basis * part;
    // The rest of the space is across it.
    const Eigen::JacobiSVD<MatrixXd> svd(part.transpose(), Eigen::ComputeFullV);
    basis = basis * svd.matrixV().rightCols(part.size() - 1);
  }
  return result;
}

// Of motions on which no wrench does work: first the translations, then what is across them.
std::string DescribeAll(const MatrixXd& motions,
                        const std::vector<GraspContact>& contacts,
                        const Vector3d& center,
                        double length) {
  const Eigen::JacobiSVD<MatrixXd> svd(motions.bottomRows<3>(), Eigen::ComputeFullV);
  int turning = 0;
  for (Eigen::Index i = 0; i < svd.singularValues().size(); ++i) {
    turning += svd.singularValues()[i] > kNegligible ? 1 : 0;
  }
  const MatrixXd sorted = motions * svd.matrixV();
  const MatrixXd translations = AlongAxes(sorted.rightCols(sorted.cols() - turning));
  const MatrixXd rotations = AlongAxes(sorted.leftCols(turning));
  std::string text;
  for (const MatrixXd* part : {&translations, &rotations}) {
    for (Eigen::Index k = 0; k < part->cols(); ++k) {
      text += (text.empty() ? "" : "; ") +
              Describe(Wrench(part->col(k)), false, contacts, center, length);
    }
  }
  return text;
}

}  // namespace

Wrenches PrimitiveWrenches(const std::vector<GraspContact>& contacts,
                           const Vector3d& center,
                           double length,
                           int edges) {
  CHECK_GT(length, 0.0);
  CHECK_GE(edges, 3);
  std::vector<Wrench> list;
  for (size_t i = 0; i < contacts.size(); ++i) {
    const GraspContact& contact = contacts[i];
    const Vector3d& n = contact.normal;
    const auto add = [&](const Vector3d& force, double spin) {
      Wrench wrench;
      wrench << force, ((contact.position - center).cross(force) + spin * n) / length;
      list.push_back(wrench);
    };
    if (contact.friction == 0.0) {
      add(n, 0.0);
      continue;
    }
    const Vector3d t1 = FirstEdge(contacts, center, length, i), t2 = n.cross(t1);
    for (int k = 0; k < edges; ++k) {
      const double angle = 2.0 * kPi * k / edges;
      add(n + contact.friction * (std::cos(angle) * t1 + std::sin(angle) * t2), 0.0);
    }
    if (contact.arm == 0.0) continue;
    add(n, contact.friction * contact.arm);
    add(n, -contact.friction * contact.arm);
  }
  Wrenches wrenches(6, list.size());
  for (size_t k = 0; k < list.size(); ++k) wrenches.col(k) = list[k];
  return wrenches;
}

ForceClosure EvaluateForceClosure(const std::vector<GraspContact>& contacts,
                                  const Vector3d& center,
                                  double length,
                                  int edges) {
  ForceClosure result;
  if (contacts.empty()) {
    result.lacks = "no contact";
    return result;
  }
  const Wrenches wrenches = PrimitiveWrenches(contacts, center, length, edges);
  const double size = wrenches.colwise().norm().maxCoeff();
  const Eigen::JacobiSVD<MatrixXd> span(wrenches, Eigen::ComputeFullU);
  result.rank = Rank(span.singularValues());
  if (result.rank < 6) {
    result.lacks = DescribeAll(span.matrixU().rightCols(6 - result.rank), contacts, center, length);
    return result;
  }
  const auto open = [&](const Wrench& motion) {
    result.lacks = Describe(motion, true, contacts, center, length);
    return result;
  };
  // All in a plane that misses the origin: a flat hull, which Qhull does not take.
  const Wrench mean = wrenches.rowwise().mean();
  const Eigen::JacobiSVD<MatrixXd> around(wrenches.colwise() - mean, Eigen::ComputeFullU);
  const Eigen::VectorXd& spread = around.singularValues();
  if (wrenches.cols() < 7 || spread[5] <= kRounding * span.singularValues()[0]) {
    const Wrench normal = around.matrixU().col(5);
    return open(normal.dot(mean) > 0.0 ? Wrench(-normal) : normal);
  }
  const std::vector<Facet> facets = Hull(wrenches);
  if (facets.empty()) {
    result.lacks = "the hull of the wrenches is too flat to tell";
    return result;
  }
  const Facet& nearest =
      *std::max_element(facets.begin(), facets.end(), [](const Facet& a, const Facet& b) {
        return a.offset < b.offset;
      });
  if (-nearest.offset <= kRounding * size) return open(nearest.normal);
  result.closed = true;
  result.margin = -nearest.offset;
  return result;
}

std::optional<double> LeastFriction(const std::vector<GraspContact>& contacts,
                                    const Vector3d& center,
                                    double length,
                                    int edges) {
  std::vector<GraspContact> tried = contacts;
  const auto closes = [&](double friction) {
    for (GraspContact& contact : tried) contact.friction = friction;
    const Wrenches wrenches = PrimitiveWrenches(tried, center, length, edges);
    if (wrenches.cols() < 7) return false;
    const Eigen::JacobiSVD<MatrixXd> svd(wrenches, Eigen::ComputeThinV);
    if (Rank(svd.singularValues()) < 6) return false;
    // In coordinates in which no direction is thin, however small the friction: closure does not
    // depend on them.
    const Wrenches even = svd.matrixV().transpose();
    return HasNonNegativeSolution(even, -even.rowwise().sum());
  };
  if (closes(0.0)) return 0.0;
  constexpr double kMost = 1000.0;
  if (!closes(kMost)) return std::nullopt;
  // Friction only adds wrenches. Halved by angle: coefficients span many decades.
  double low = 0.0, high = std::atan(kMost);
  while (high - low > 1e-8 * high) {
    const double middle = 0.5 * (low + high);
    (closes(std::tan(middle)) ? high : low) = middle;
  }
  return std::tan(high);
}

}  // namespace darboux
