#include "costs/strain_derivatives.h"

#include <cmath>

#include "costs/cross_matrix.h"

namespace darboux {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// Deformed tangents and what follows from them.
struct Deformed {
  Deformed(const StrainPoint& p, const Kinematics<double>& k)
      : x1(p.t1 + k.d1), x2(p.t2 + k.d2), big_n(x1.cross(x2)) {}

  // Of the Koiter measure only.
  void Normalise() {
    length = big_n.norm();
    n = big_n / length;
    dual1 = x2.cross(n) / length;
    dual2 = n.cross(x1) / length;
  }

  Vector3d x1, x2, big_n;
  double length = 0.0;
  Vector3d n;             // unit normal
  Vector3d dual1, dual2;  // x^a with x^a . x_b = delta^a_b, x^a . n = 0
};

// Bending rows 11, 22, 12 with the factor of the engineering strain, the block of H they read, and
// b n + H, whose component along the normal they are.
struct BendingRow {
  double factor;
  int block;
  Vector3d q;
};

void MakeRows(const StrainPoint& p, const Kinematics<double>& k, BendingRow rows[3]) {
  rows[0] = {1.0, 2, k.h11 + p.b11 * p.n};
  rows[1] = {1.0, 4, k.h22 + p.b22 * p.n};
  rows[2] = {2.0, 3, k.h12 + p.b12 * p.n};
}

}  // namespace

bool EvaluateStrainDerivatives(StrainMeasure measure,
                               const StrainPoint& p,
                               const double* kinematics,
                               StrainDerivatives* result) {
  EvaluateMembraneStrain(measure, p, kinematics, result->strain.data());
  if (!EvaluateBendingStrain(measure, p, kinematics, result->strain.data() + 3)) return false;
  const Kinematics<double> k(kinematics);
  auto& g = result->gradient;
  g.setZero();
  const auto block = [&g](int row, int column) { return g.block<1, 3>(row, 3 * column); };

  Deformed x(p, k);
  const bool linear = IsLinear(measure);
  const Vector3d& x1 = linear ? p.t1 : x.x1;
  const Vector3d& x2 = linear ? p.t2 : x.x2;
  block(0, 0) = x1.transpose();
  block(1, 1) = x2.transpose();
  block(2, 0) = x2.transpose();
  block(2, 1) = x1.transpose();

  if (measure == StrainMeasure::kLinearSeed || measure == StrainMeasure::kNonlinearSeed) {
    const Vector3d n1 = -p.b11 * p.t1 - p.b12 * p.t2;
    const Vector3d n2 = -p.b12 * p.t1 - p.b22 * p.t2;
    block(3, 0) = n1.transpose();
    block(4, 1) = n2.transpose();
    block(5, 0) = n2.transpose();
    block(5, 1) = n1.transpose();
  }
  if (linear) {
    block(3, 2) = p.n.transpose();
    block(4, 4) = p.n.transpose();
    block(5, 3) = 2.0 * p.n.transpose();
    return true;
  }
  BendingRow rows[3];
  MakeRows(p, k, rows);
  if (measure == StrainMeasure::kNonlinearSeed) {
    // q . (x_1 x x_2)
    for (int a = 0; a < 3; ++a) {
      const BendingRow& row = rows[a];
      block(3 + a, 0) += row.factor * x.x2.cross(row.q).transpose();
      block(3 + a, 1) += row.factor * row.q.cross(x.x1).transpose();
      block(3 + a, row.block) = row.factor * x.big_n.transpose();
    }
    return true;
  }
  // q . n' with dn' = -x^a (n' . dx_a) (Weingarten).
  x.Normalise();
  for (int a = 0; a < 3; ++a) {
    const BendingRow& row = rows[a];
    block(3 + a, 0) = -row.factor * row.q.dot(x.dual1) * x.n.transpose();
    block(3 + a, 1) = -row.factor * row.q.dot(x.dual2) * x.n.transpose();
    block(3 + a, row.block) = row.factor * x.n.transpose();
  }
  return true;
}

void AddStressStiffness(StrainMeasure measure,
                        const StrainPoint& p,
                        const double* kinematics,
                        const Eigen::Matrix<double, 6, 1>& stress,
                        Eigen::Matrix<double, kBendingInputs, kBendingInputs>* stiffness) {
  if (IsLinear(measure)) return;
  auto& s = *stiffness;
  const auto block = [&s](int row, int column) { return s.block<3, 3>(3 * row, 3 * column); };
  const auto add_symmetric = [&](int row, int column, const Matrix3d& value) {
    block(row, column) += value;
    block(column, row) += value.transpose();
  };
  block(0, 0).diagonal().array() += stress[0];
  block(1, 1).diagonal().array() += stress[1];
  block(0, 1).diagonal().array() += stress[2];
  block(1, 0).diagonal().array() += stress[2];

  const Kinematics<double> k(kinematics);
  Deformed x(p, k);
  BendingRow rows[3];
  MakeRows(p, k, rows);
  Vector3d q = Vector3d::Zero();
  for (int a = 0; a < 3; ++a) q += stress[3 + a] * rows[a].factor * rows[a].q;
  if (measure == StrainMeasure::kNonlinearSeed) {
    // d^2 of H . (x_1 x x_2): dH . (dx_1 x x_2 + x_1 x dx_2) and q . (dx_1 x dx_2).
    const Matrix3d by_d1 = -CrossMatrix(x.x2), by_d2 = CrossMatrix(x.x1);
    for (int a = 0; a < 3; ++a) {
      const double m = stress[3 + a] * rows[a].factor;
      add_symmetric(rows[a].block, 0, m * by_d1);
      add_symmetric(rows[a].block, 1, m * by_d2);
    }
    add_symmetric(0, 1, -CrossMatrix(q));
    return;
  }
  x.Normalise();
  // d^2 (q . n') for fixed q, from dn' = -x^a (n' . dx_a) and
  // dx^a = -(x^a . dx_b) x^b + (x^a . x^b) (n' . dx_b) n':
  //   u, v -> q^b [(n'.u_a) (x^a.v_b) + (n'.v_a) (x^a.u_b)] - (q.n') x^a.x^b (n'.u_a) (n'.v_b)
  const Vector3d* dual[2] = {&x.dual1, &x.dual2};
  const double along = q.dot(x.n);
  const Matrix3d normal = x.n * x.n.transpose();
  for (int a = 0; a < 2; ++a) {
    const Matrix3d mixed = x.n * dual[a]->transpose();
    for (int b = 0; b < 2; ++b) {
      const double qb = q.dot(*dual[b]);
      block(a, b) += qb * mixed;
      block(b, a) += qb * mixed.transpose();
      block(a, b) -= along * dual[a]->dot(*dual[b]) * normal;
    }
    // dH . dn' = -(x^a . dH) (n' . dx_a)
    for (int row = 0; row < 3; ++row) {
      const double m = stress[3 + row] * rows[row].factor;
      add_symmetric(rows[row].block, a, -m * mixed.transpose());
    }
  }
}

}  // namespace darboux
