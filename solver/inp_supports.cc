#include "solver/inp_supports.h"

#include <Eigen/Dense>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <set>

#include "solver/support_conditions.h"

namespace darboux {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// Below this, directions are parallel and values equal.
constexpr double kSame = 1e-9;

// direction . (displacement of the fibre, or of all of its nodes) = value.
struct Hold {
  Vector3d direction;
  double value = 0.0;
  bool whole = false;
};

struct ColumnHolds {
  std::vector<Hold> holds;
  std::vector<Vector3d> rotations;  // axes about which the director does not turn; shells only
};

// Rows (direction, value) brought to echelon form: independent, each with a pivot of 1 whose column
// is zero in all others.
struct Echelon {
  Eigen::Matrix<double, Eigen::Dynamic, 4> rows;
  std::vector<int> pivots;
  double contradiction = 0.0;  // of rows that depend on others

  void Add(const Vector3d& direction, double value) {
    Eigen::Matrix<double, 1, 4> row;
    row << direction.transpose(), value;
    for (size_t i = 0; i < pivots.size(); ++i) {
      row -= row[pivots[i]] * rows.row(static_cast<int>(i));
    }
    int pivot;
    if (row.head<3>().cwiseAbs().maxCoeff(&pivot) < kSame) {
      contradiction = std::max(contradiction, std::abs(row[3]));
      return;
    }
    row /= row[pivot];
    row[pivot] = 1.0;
    for (int i = 0; i < rows.rows(); ++i) {
      rows.row(i) -= rows(i, pivot) * row;
      rows(i, pivot) = 0.0;
    }
    rows.conservativeResize(rows.rows() + 1, 4);
    rows.bottomRows<1>() = row;
    pivots.push_back(pivot);
    for (int i = 0; i < rows.rows(); ++i) {
      for (int k = 0; k < 3; ++k) {
        if (std::abs(rows(i, k)) < kSame) rows(i, k) = 0.0;
      }
    }
  }
};

// A condition on a node per row; nothing where the node is missing.
void AddNodeConditions(const Echelon& echelon, int node, InpSupports* result) {
  for (int i = 0; i < echelon.rows.rows(); ++i) {
    InpCondition condition;
    condition.terms.push_back({{node, echelon.pivots[i] + 1}, 1.0});
    for (int k = 0; k < 3; ++k) {
      if (k != echelon.pivots[i] && echelon.rows(i, k) != 0.0) {
        condition.terms.push_back({{node, k + 1}, echelon.rows(i, k)});
      }
    }
    condition.target = echelon.rows(i, 3);
    result->conditions.push_back(std::move(condition));
  }
}

class Builder {
 public:
  Builder(const RigidFrame& frame, InpSupports* result) : frame_(frame), result_(result) {}

  void AddSolid(const InpMesh::Column& column, const ColumnHolds& held) {
    Echelon whole, middle;
    for (const Hold& hold : held.holds) {
      if (hold.whole) whole.Add(hold.direction, hold.value);
    }
    for (const int node : column.nodes) {
      if (node > 0) AddNodeConditions(whole, node, result_);
    }
    // What holds the middle surface besides: rows after those of the whole fibre.
    middle = whole;
    const int first = static_cast<int>(whole.rows.rows());
    for (const Hold& hold : held.holds) {
      if (!hold.whole) middle.Add(hold.direction, hold.value);
    }
    for (int i = first; i < middle.rows.rows(); ++i) {
      InpCondition condition;
      // Middle nodes are at corners; elsewhere the mean of both faces stands for them.
      const std::vector<int> nodes = column.is_corner
                                         ? std::vector<int>{column.nodes[1]}
                                         : std::vector<int>{column.nodes[0], column.nodes[2]};
      for (const int node : nodes) {
        condition.terms.push_back({{node, middle.pivots[i] + 1}, 1.0});
      }
      for (int k = 0; k < 3; ++k) {
        if (k == middle.pivots[i] || middle.rows(i, k) == 0.0) continue;
        for (const int node : nodes) {
          condition.terms.push_back({{node, k + 1}, middle.rows(i, k)});
        }
      }
      condition.target = nodes.size() * middle.rows(i, 3);
      result_->conditions.push_back(std::move(condition));
    }
    Note(middle);
    for (const Hold& hold : held.holds) AddRigid(column, hold);
  }

  void AddShell(const InpMesh::Column& column, const ColumnHolds& held) {
    const int node = column.nodes[0];
    const Vector3d& n = column.normal;
    // Axes of rotations, within the tangent plane.
    std::vector<Vector3d> turns;
    for (Vector3d axis : held.rotations) {
      axis -= n * n.dot(axis);
      for (const Vector3d& other : turns) axis -= other * other.dot(axis);
      if (axis.norm() > 1e-6) turns.push_back(axis.normalized());
    }
    Matrix3d axes = Matrix3d::Identity();
    std::vector<int> held_turns;
    if (!turns.empty()) {
      axes = Axes(n, turns, held, &held_turns);
      if (!axes.isIdentity(0.0)) result_->axes[node] = axes;
    }
    Echelon echelon;
    for (const Hold& hold : held.holds) echelon.Add(axes * hold.direction, hold.value);
    AddNodeConditions(echelon, node, result_);
    for (const int k : held_turns) result_->conditions.push_back({{{{node, 4 + k}, 1.0}}, 0.0});
    Note(echelon);
    for (const Hold& hold : held.holds) AddRigid(column, hold);
    for (const Vector3d& axis : turns) {
      // A rotation about the axis moves the director along axis x n.
      result_->rigid_rows.push_back(frame_.DerivativeRow(axis.cross(n), n));
    }
  }

  double contradiction() const { return contradiction_; }

 private:
  // Axes of a node whose director is held, rows; the numbers of those about which it does not turn.
  static Matrix3d Axes(const Vector3d& n,
                       const std::vector<Vector3d>& turns,
                       const ColumnHolds& held,
                       std::vector<int>* held_turns) {
    const auto global = [](const Vector3d& axis) {
      for (int k = 0; k < 3; ++k) {
        if (std::abs(axis[k]) > 1.0 - kSame) return k;
      }
      return -1;
    };
    const int normal = global(n);
    if (turns.size() == 2 && normal >= 0) {
      *held_turns = {(normal + 1) % 3, (normal + 2) % 3};
      return Matrix3d::Identity();
    }
    if (turns.size() == 1 && global(turns[0]) >= 0) {
      *held_turns = {global(turns[0])};
      return Matrix3d::Identity();
    }
    Matrix3d axes;
    Vector3d first = turns[0];
    if (turns.size() == 2 && !held.holds.empty()) {
      // Along what is held, where that is tangent: conditions on single components then.
      const Vector3d& direction = held.holds.front().direction;
      const Vector3d tangent = direction - n * n.dot(direction);
      if (tangent.norm() > 0.5) first = tangent.normalized();
    }
    axes.row(0) = first;
    axes.row(1) = n.cross(first);
    axes.row(2) = n;
    *held_turns = turns.size() == 2 ? std::vector<int>{0, 1} : std::vector<int>{0};
    return axes;
  }

  void AddRigid(const InpMesh::Column& column, const Hold& hold) {
    result_->rigid_rows.push_back(frame_.DisplacementRow(column.position, hold.direction));
    if (!hold.whole) return;
    // Along the fibre the displacement is the same.
    result_->rigid_rows.push_back(frame_.DerivativeRow(column.normal, hold.direction));
  }

  void Note(const Echelon& echelon) {
    contradiction_ = std::max(contradiction_, echelon.contradiction);
  }

  const RigidFrame& frame_;
  InpSupports* result_;
  double contradiction_ = 0.0;
};

}  // namespace

InpSupports MakeInpSupports(const Scene& scene, const InpMesh& mesh, const RigidFrame& frame) {
  InpSupports result;
  const ShellSurface& surface = mesh.surface();
  std::map<int, ColumnHolds> columns;
  double largest = 0.0;
  for (const SupportSpec& support : scene.supports) {
    std::set<int> chosen;
    if (support.on.kind == Region::Kind::kNear) {
      const Vector3d center(support.on.center[0], support.on.center[1], support.on.center[2]);
      for (size_t c = 0; c < mesh.columns().size(); ++c) {
        if ((mesh.columns()[c].position - center).norm() <= support.on.radius) {
          chosen.insert(static_cast<int>(c));
        }
      }
      if (chosen.empty()) {
        const int nearest = mesh.Nearest(center, true);
        chosen.insert(nearest);
        const double off =
            (mesh.columns()[nearest].position - surface.Position(surface.ClosestPoint(center)))
                .norm();
        if (off > 1e-6 * surface.size()) {
          result.remarks.push_back(support.location.key +
                                   ": held at the nearest node, which is off by " +
                                   std::to_string(off / mesh.element_size()) + " elements");
        }
      }
    } else {
      for (const Side side : SidesOf(support.on, surface)) {
        for (const InpMesh::Edge& edge : mesh.SideEdges(side)) {
          chosen.insert(edge.begin);
          chosen.insert(edge.end);
          if (edge.middle >= 0) chosen.insert(edge.middle);
        }
      }
    }
    const Vector3d normal(support.normal[0], support.normal[1], support.normal[2]);
    for (const int c : chosen) {
      const InpMesh::Column& column = mesh.columns()[c];
      ColumnHolds& held = columns[c];
      if (support.kind == SupportSpec::Kind::kSymmetry) {
        held.holds.push_back({normal, 0.0, true});
        held.rotations.push_back(column.normal.cross(normal));
        continue;
      }
      const bool clamped = support.kind == SupportSpec::Kind::kClamped;
      const Vector3d target = EvaluateAt(support.displacement, surface, column.at);
      largest = std::max(largest, target.cwiseAbs().maxCoeff());
      for (int k = 0; k < 3; ++k) {
        if (support.kind == SupportSpec::Kind::kFix && !support.fix[k]) continue;
        held.holds.push_back({Vector3d::Unit(k), target[k], clamped});
      }
      if (clamped) {
        const Vector3d tangent = column.normal.unitOrthogonal();
        held.rotations.push_back(tangent);
        held.rotations.push_back(column.normal.cross(tangent));
      }
    }
  }
  Builder builder(frame, &result);
  for (const auto& [c, held] : columns) {
    if (mesh.is_solid()) {
      builder.AddSolid(mesh.columns()[c], held);
    } else {
      builder.AddShell(mesh.columns()[c], held);
    }
  }
  if (builder.contradiction() > 1e-6 * largest) {
    result.remarks.push_back("supports contradict each other at some node: the first one counts");
  }
  return result;
}

void HoldNode(int node, const std::vector<Vector3d>& directions, InpSupports* supports) {
  Echelon echelon;
  for (const Vector3d& direction : directions) echelon.Add(direction, 0.0);
  AddNodeConditions(echelon, node, supports);
}

}  // namespace darboux
