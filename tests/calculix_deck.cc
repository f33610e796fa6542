#include "tests/calculix_deck.h"

#include <Eigen/Geometry>
#include <cmath>
#include <cstdio>
#include <sstream>

namespace darboux {
namespace {

using Eigen::Vector3d;

std::string Number(double value) {
  char text[40];
  std::snprintf(text, sizeof(text), "%.14g", value);
  return text;
}

struct Shape {
  std::vector<double> value, da, db;
};

// Shape functions of a face at (a, b): 4 or 8 nodes on [-1, 1]^2, 6 on the unit triangle. Corners
// first, then the middles of the edges, both around.
Shape Evaluate(size_t num_nodes, double a, double b) {
  Shape shape;
  const auto add = [&shape](double value, double da, double db) {
    shape.value.push_back(value);
    shape.da.push_back(da);
    shape.db.push_back(db);
  };
  if (num_nodes == 6) {
    const double c = 1.0 - a - b;
    add(c * (2 * c - 1), 1 - 4 * c, 1 - 4 * c);
    add(a * (2 * a - 1), 4 * a - 1, 0);
    add(b * (2 * b - 1), 0, 4 * b - 1);
    add(4 * a * c, 4 * (c - a), -4 * a);
    add(4 * a * b, 4 * b, 4 * a);
    add(4 * b * c, -4 * b, 4 * (c - b));
    return shape;
  }
  constexpr int kA[] = {-1, 1, 1, -1}, kB[] = {-1, -1, 1, 1};
  for (int i = 0; i < 4; ++i) {
    const double p = 1 + kA[i] * a, q = 1 + kB[i] * b;
    if (num_nodes == 4) {
      add(0.25 * p * q, 0.25 * kA[i] * q, 0.25 * kB[i] * p);
    } else {
      const double r = kA[i] * a + kB[i] * b - 1;
      add(0.25 * p * q * r, 0.25 * kA[i] * q * (r + p), 0.25 * kB[i] * p * (r + q));
    }
  }
  if (num_nodes == 4) return shape;
  add(0.5 * (1 - a * a) * (1 - b), -a * (1 - b), -0.5 * (1 - a * a));
  add(0.5 * (1 + a) * (1 - b * b), 0.5 * (1 - b * b), -b * (1 + a));
  add(0.5 * (1 - a * a) * (1 + b), -a * (1 + b), 0.5 * (1 - a * a));
  add(0.5 * (1 - a) * (1 - b * b), -0.5 * (1 - b * b), -b * (1 - a));
  return shape;
}

struct Point {
  double a, b, weight;
};

// Gauss' four points a side, for quads; the same folded onto the triangle (Duffy).
std::vector<Point> Rule(bool triangle) {
  const double x[] = {std::sqrt(3.0 / 7 - 2.0 / 7 * std::sqrt(1.2)),
                      std::sqrt(3.0 / 7 + 2.0 / 7 * std::sqrt(1.2))};
  const double w[] = {(18 + std::sqrt(30.0)) / 36, (18 - std::sqrt(30.0)) / 36};
  std::vector<Point> rule;
  for (int i = 0; i < 4; ++i) {
    for (int j = 0; j < 4; ++j) {
      const double a = (i % 2 ? 1 : -1) * x[i / 2], b = (j % 2 ? 1 : -1) * x[j / 2];
      const double weight = w[i / 2] * w[j / 2];
      if (triangle) {
        const double p = 0.5 * (1 + a), q = 0.5 * (1 + b);
        rule.push_back({p, q * (1 - p), 0.25 * weight * (1 - p)});
      } else {
        rule.push_back({a, b, weight});
      }
    }
  }
  return rule;
}

}  // namespace

const char* ToString(CalculixElement element) {
  switch (element) {
    case CalculixElement::kS4:
      return "S4";
    case CalculixElement::kS6:
      return "S6";
    case CalculixElement::kS8R:
      return "S8R";
    case CalculixElement::kC3D20R:
      return "C3D20R";
  }
  return "";
}

CalculixMesh::CalculixMesh(CalculixElement element,
                           std::array<int, 2> cells,
                           double thickness,
                           const std::function<PatchPoint(double s, double t)>& patch)
    : element_(element), thickness_(thickness), step_(element == CalculixElement::kS4 ? 1 : 2) {
  size_ = {step_ * cells[0] + 1, step_ * cells[1] + 1};
  lattice_.assign(static_cast<size_t>(size_[0]) * size_[1] * layers(), 0);
  for (int k = 0; k < layers(); ++k) {
    for (int j = 0; j < size_[1]; ++j) {
      for (int i = 0; i < size_[0]; ++i) {
        // Corners and middles of edges; S6 has a node on its diagonals as well.
        const int odd = step_ == 1 ? 0 : i % 2 + j % 2 + (IsSolid() ? k % 2 : 0);
        if (odd > (element == CalculixElement::kS6 ? 2 : 1)) continue;
        const PatchPoint point = patch(i / (size_[0] - 1.0), j / (size_[1] - 1.0));
        const double offset = IsSolid() ? 0.5 * (k - 1) * thickness : 0.0;
        nodes_.push_back(point.position + offset * point.normal);
        At(i, j, k) = static_cast<int>(nodes_.size());
      }
    }
  }
  for (int cj = 0; cj < cells[1]; ++cj) {
    for (int ci = 0; ci < cells[0]; ++ci) {
      const int i = step_ * ci, j = step_ * cj;
      const auto n = [&](int di, int dj, int k = 0) { return At(i + di, j + dj, k); };
      switch (element) {
        case CalculixElement::kS4:
          elements_.push_back({n(0, 0), n(1, 0), n(1, 1), n(0, 1)});
          break;
        case CalculixElement::kS8R:
          elements_.push_back(
              {n(0, 0), n(2, 0), n(2, 2), n(0, 2), n(1, 0), n(2, 1), n(1, 2), n(0, 1)});
          break;
        case CalculixElement::kS6:
          if ((ci + cj) % 2 == 0) {
            elements_.push_back({n(0, 0), n(2, 0), n(2, 2), n(1, 0), n(2, 1), n(1, 1)});
            elements_.push_back({n(0, 0), n(2, 2), n(0, 2), n(1, 1), n(1, 2), n(0, 1)});
          } else {
            elements_.push_back({n(0, 0), n(2, 0), n(0, 2), n(1, 0), n(1, 1), n(0, 1)});
            elements_.push_back({n(2, 0), n(2, 2), n(0, 2), n(2, 1), n(1, 2), n(1, 1)});
          }
          break;
        case CalculixElement::kC3D20R:
          elements_.push_back({n(0, 0, 0), n(2, 0, 0), n(2, 2, 0), n(0, 2, 0), n(0, 0, 2),
                               n(2, 0, 2), n(2, 2, 2), n(0, 2, 2), n(1, 0, 0), n(2, 1, 0),
                               n(1, 2, 0), n(0, 1, 0), n(1, 0, 2), n(2, 1, 2), n(1, 2, 2),
                               n(0, 1, 2), n(0, 0, 1), n(2, 0, 1), n(2, 2, 1), n(0, 2, 1)});
          break;
      }
    }
  }
}

std::vector<int> CalculixMesh::SideNodes(Side side) const {
  std::vector<int> nodes;
  const bool along_t = side == kSMin || side == kSMax;
  for (int k = 0; k < layers(); ++k) {
    for (int i = 0; i < size_[along_t ? 1 : 0]; ++i) {
      const int fixed = side == kSMin || side == kTMin ? 0 : size_[along_t ? 0 : 1] - 1;
      const int node = along_t ? At(fixed, i, k) : At(i, fixed, k);
      if (node > 0) nodes.push_back(node);
    }
  }
  return nodes;
}

int CalculixMesh::CornerNode(int s, int t) const {
  return At(s * (size_[0] - 1), t * (size_[1] - 1), middle());
}

void CalculixMesh::AddFaceForces(const std::vector<int>& face,
                                 double share,
                                 const std::function<Vector3d(const Vector3d& position)>& per_area,
                                 Forces* forces) const {
  for (const Point& point : Rule(face.size() == 6)) {
    const Shape shape = Evaluate(face.size(), point.a, point.b);
    Vector3d x = Vector3d::Zero(), xa = x, xb = x;
    for (size_t i = 0; i < face.size(); ++i) {
      x += shape.value[i] * nodes_[face[i] - 1];
      xa += shape.da[i] * nodes_[face[i] - 1];
      xb += shape.db[i] * nodes_[face[i] - 1];
    }
    const Vector3d force = share * point.weight * xa.cross(xb).norm() * per_area(x);
    for (size_t i = 0; i < face.size(); ++i) {
      forces->emplace(face[i], Vector3d::Zero()).first->second += shape.value[i] * force;
    }
  }
}

CalculixMesh::Forces CalculixMesh::AreaForces(
    const std::function<Vector3d(const Vector3d& position)>& per_area) const {
  Forces forces;
  for (const std::vector<int>& e : elements_) {
    if (IsSolid()) {
      AddFaceForces({e[0], e[1], e[2], e[3], e[8], e[9], e[10], e[11]}, 0.5, per_area, &forces);
      AddFaceForces({e[4], e[5], e[6], e[7], e[12], e[13], e[14], e[15]}, 0.5, per_area, &forces);
    } else {
      AddFaceForces(e, 1.0, per_area, &forces);
    }
  }
  return forces;
}

CalculixMesh::Forces CalculixMesh::SideForces(Side side, const Vector3d& per_length) const {
  Forces forces;
  const bool along_t = side == kSMin || side == kSMax;
  const int fixed = side == kSMin || side == kTMin ? 0 : size_[along_t ? 0 : 1] - 1;
  const auto n = [&](int i, int k) { return along_t ? At(fixed, i, k) : At(i, fixed, k); };
  const auto add = [&](int node, const Vector3d& force) {
    forces.emplace(node, Vector3d::Zero()).first->second += force;
  };
  for (int i = 0; i + step_ < size_[along_t ? 1 : 0]; i += step_) {
    if (IsSolid()) {
      AddFaceForces(
          {n(i, 0),
           n(i + 2, 0),
           n(i + 2, 2),
           n(i, 2),
           n(i + 1, 0),
           n(i + 2, 1),
           n(i + 1, 2),
           n(i, 1)},
          1.0 / thickness_,
          [&](const Vector3d&) { return per_length; },
          &forces);
      continue;
    }
    // Sides are straight here, with nodes at equal distances.
    const Vector3d chord = nodes_[n(i + step_, 0) - 1] - nodes_[n(i, 0) - 1];
    const Vector3d force = chord.norm() * per_length;
    add(n(i, 0), force / (step_ == 1 ? 2.0 : 6.0));
    add(n(i + step_, 0), force / (step_ == 1 ? 2.0 : 6.0));
    if (step_ == 2) add(n(i + 1, 0), force * (4.0 / 6.0));
  }
  return forces;
}

CalculixMesh::Forces CalculixMesh::CornerForces(int s, int t, const Vector3d& force) const {
  const int i = s * (size_[0] - 1), j = t * (size_[1] - 1);
  if (!IsSolid()) return {{At(i, j, 0), force}};
  return {{At(i, j, 0), force / 6}, {At(i, j, 1), force * (4.0 / 6)}, {At(i, j, 2), force / 6}};
}

std::string MakeDeck(const CalculixMesh& mesh, const CalculixDeck& deck) {
  std::ostringstream out;
  out << "*NODE, NSET=NALL\n";
  for (size_t i = 0; i < mesh.nodes().size(); ++i) {
    const Vector3d& x = mesh.nodes()[i];
    out << i + 1 << ", " << Number(x.x()) << ", " << Number(x.y()) << ", " << Number(x.z()) << "\n";
  }
  out << "*ELEMENT, TYPE=" << ToString(mesh.element()) << ", ELSET=EALL\n";
  for (size_t i = 0; i < mesh.elements().size(); ++i) {
    out << i + 1;
    const std::vector<int>& nodes = mesh.elements()[i];
    for (size_t k = 0; k < nodes.size(); ++k) {
      // At most 16 numbers in a line.
      out << (k == 15 ? ",\n" : ", ") << nodes[k];
    }
    out << "\n";
  }
  out << "*NSET, NSET=PRINTED\n";
  for (const int node : deck.printed) out << node << ",\n";
  out << "*MATERIAL, NAME=M\n*ELASTIC\n"
      << Number(deck.young_modulus) << ", " << Number(deck.poisson_ratio) << "\n";
  if (mesh.IsSolid()) {
    out << "*SOLID SECTION, ELSET=EALL, MATERIAL=M\n";
  } else {
    out << "*SHELL SECTION, ELSET=EALL, MATERIAL=M\n" << Number(mesh.thickness()) << "\n";
  }
  if (deck.cylindrical) out << "*TRANSFORM, NSET=NALL, TYPE=C\n0, 0, 0, 1, 0, 0\n";
  out << "*BOUNDARY\n";
  for (const CalculixFix& fix : deck.fixed) {
    for (const int node : fix.nodes) out << node << ", " << fix.first << ", " << fix.last << "\n";
  }
  if (deck.nonlinear) {
    out << "*STEP, NLGEOM, INC=1000\n*STATIC\n"
        << Number(deck.first_increment) << ", 1.0, 1e-6, " << Number(deck.largest_increment)
        << "\n";
  } else {
    out << "*STEP\n*STATIC\n";
  }
  out << "*CLOAD\n";
  for (const auto& [node, global] : deck.forces) {
    Vector3d force = global;
    if (deck.cylindrical) {
      const Vector3d& x = mesh.nodes()[node - 1];
      const Vector3d radial = Vector3d(0.0, x.y(), x.z()).normalized();
      const Vector3d tangential = Vector3d::UnitX().cross(radial);
      force = {global.dot(radial), global.dot(tangential), global.x()};
    }
    for (int i = 0; i < 3; ++i) {
      if (force[i] != 0.0) out << node << ", " << i + 1 << ", " << Number(force[i]) << "\n";
    }
  }
  // FREQUENCY: of the last increment alone.
  out << "*NODE PRINT, NSET=PRINTED, FREQUENCY=100000, GLOBAL=YES\nU\n*END STEP\n";
  return out.str();
}

bool ReadDat(const std::string& text, std::map<int, Vector3d>* displacements) {
  std::istringstream lines(text);
  std::string line;
  bool found = false;
  while (std::getline(lines, line)) {
    if (line.find("displacements (vx,vy,vz)") != std::string::npos) {
      displacements->clear();
      found = true;
      continue;
    }
    int node;
    Vector3d u;
    if (found && std::sscanf(line.c_str(), "%d %lf %lf %lf", &node, &u[0], &u[1], &u[2]) == 4) {
      (*displacements)[node] = u;
    }
  }
  return found && !displacements->empty();
}

}  // namespace darboux
