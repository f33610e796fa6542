#include "solver/tangent_stiffness.h"

#include <glog/logging.h>

#include <algorithm>
#include <cmath>

#include "costs/strain_derivatives.h"
#include "solver/element_product.h"
#include "solver/parallel_for.h"

namespace darboux {
namespace {

constexpr int kVectors = 5;  // kinematic vectors of a point

Eigen::Matrix3d StiffnessPerArea(double stiffness, double nu) {
  Eigen::Matrix3d c;
  c << 1.0, nu, 0.0, nu, 1.0, 0.0, 0.0, 0.0, 0.5 * (1.0 - nu);
  return stiffness * c;
}

// The fifteen kinematic numbers of a point from the control displacements of its element, given by
// their components in a basis.
template <int C>
Eigen::Matrix<double, 3, kVectors> Inputs(const StrainPoint& point,
                                          const Eigen::Matrix<double, 3, C>& basis,
                                          const Eigen::Matrix<double, C, Eigen::Dynamic>& u) {
  double k[C * kVectors] = {};
  for (Eigen::Index i = 0; i < u.cols(); ++i) {
    const double* const w = point.weights.data() + 6 * i + kRowD1;
    const double* const v = u.data() + C * i;
    for (int b = 0; b < kVectors; ++b) {
      for (int a = 0; a < C; ++a) k[C * b + a] += w[b] * v[a];
    }
  }
  const Eigen::Map<Eigen::Matrix<double, C, kVectors>> reduced(k);
  if constexpr (C == 3) {
    return reduced;
  } else {
    return basis.lazyProduct(reduced);
  }
}

// Adds minus the derivative of the force p N dA, its symmetric part, to the blocks i >= j of an
// element's n control vertices, 3 x 3 each, those of a j one behind the other. With N = x_1 x x_2
// the block (i, j) is the matrix of c x, c = p dA w_i (w_1j x_2 - w_2j x_1), and its symmetric part
// that of (c_ij - c_ji) / 2. On a closed surface under uniform pressure, summed, that is all of it.
void AddPressureStiffness(const StrainPoint& point,
                          const Eigen::Matrix<double, 3, kVectors>& k,
                          double pressure,
                          int n,
                          double* full) {
  const Eigen::Vector3d x1 = 0.5 * pressure * (point.t1 + k.col(0));
  const Eigen::Vector3d x2 = 0.5 * pressure * (point.t2 + k.col(1));
  for (int j = 0; j < n; ++j) {
    const auto wj = point.weights.col(j);
    for (int i = j + 1; i < n; ++i) {
      const auto wi = point.weights.col(i);
      const double by_x2 = wi[kRowValue] * wj[kRowD1] - wj[kRowValue] * wi[kRowD1];
      const double by_x1 = wi[kRowValue] * wj[kRowD2] - wj[kRowValue] * wi[kRowD2];
      const Eigen::Vector3d c = by_x2 * x2 - by_x1 * x1;
      double* const block = full + 9 * (static_cast<size_t>(j) * n + i);  // column by column
      block[1] += c[2];
      block[2] -= c[1];
      block[3] -= c[2];
      block[5] += c[0];
      block[6] += c[1];
      block[7] -= c[0];
    }
  }
}

// Adds the forces on an element's control vertices that derivatives by the fifteen kinematic
// numbers make.
void AddForces(const StrainPoint& point,
               const Eigen::Matrix<double, 3 * kVectors, 1>& derivatives,
               const std::vector<int>& vertices,
               Eigen::Matrix3Xd* forces) {
  for (size_t i = 0; i < vertices.size(); ++i) {
    for (int b = 0; b < kVectors; ++b) {
      forces->col(vertices[i]) += point.weights(kRowD1 + b, i) * derivatives.segment<3>(3 * b);
    }
  }
}

Eigen::Matrix3Xd Gather(const Eigen::Matrix3Xd& field, const std::vector<int>& vertices) {
  Eigen::Matrix3Xd result(3, vertices.size());
  for (size_t i = 0; i < vertices.size(); ++i) result.col(i) = field.col(vertices[i]);
  return result;
}

}  // namespace

TangentStiffness::TangentStiffness(const ShellProblem* problem,
                                   SparseBackend backend,
                                   int num_threads)
    : problem_(*problem),
      basis_(problem->unknown_basis()),
      membrane_(Eigen::Matrix3d::Zero()),
      bending_(Eigen::Matrix3d::Zero()) {
  const Material& material = problem->scaled_material();
  if (problem->effect(Effect::kMembrane).on) {
    membrane_ = StiffnessPerArea(material.MembraneStiffness(), material.poisson_ratio);
  }
  if (problem->effect(Effect::kBending).on) {
    bending_ = StiffnessPerArea(material.BendingStiffness(), material.poisson_ratio);
  }
  components_ = static_cast<int>(basis_.cols());
  point_begin_.push_back(0);
  for (const StrainPoints& points : problem->strain_points()) {
    point_begin_.push_back(point_begin_.back() + static_cast<int>(points->size()));
  }
  num_threads_ = ThreadsFor(problem->surface().num_elements(), num_threads);
  BuildPattern(backend);
}

void TangentStiffness::BuildPattern(SparseBackend backend) {
  const ShellSurface& surface = problem_.surface();
  const int num_vertices = surface.mesh().num_vertices;
  // Sets of vertices that share a term: elements, then conditions of supports.
  std::vector<const std::vector<int>*> terms;
  for (int e = 0; e < surface.num_elements(); ++e) terms.push_back(&surface.control_vertices(e));
  std::vector<const PlacedCondition*> springs;
  for (const PlacedCondition& c : problem_.conditions()) {
    if (c.stiffness != 0.0) springs.push_back(&c);
  }
  for (const PlacedCondition& pin : problem_.pins()) springs.push_back(&pin);
  for (const PlacedCondition* spring : springs) terms.push_back(&spring->vertices);
  pattern_ = std::make_unique<StiffnessPattern>(
      num_vertices,
      components_,
      [this](int vertex) { return problem_.IsFree(vertex); },
      terms,
      surface.num_elements(),
      backend);
  matrix_ = pattern_->MakeMatrix();

  support_values_ = Eigen::VectorXd::Zero(matrix_.nonZeros());
  for (const PlacedCondition* spring : springs) {
    AddSpring(spring->vertices, spring->coefficients, spring->stiffness, &support_values_);
  }
  workspaces_.resize(num_threads_);

  const auto& means = problem_.mean_conditions();
  const auto& pins = problem_.pins();
  const int gas = problem_.has_gas() ? 1 : 0;
  const int travels = problem_.grasp() != nullptr ? problem_.grasp()->num_driven() : 0;
  update_vectors_ =
      Eigen::MatrixXd::Zero(num_unknowns(), pins.size() + means.size() + gas + travels);
  update_weights_ = Eigen::VectorXd::Ones(update_vectors_.cols());
  for (size_t k = 0; k < pins.size(); ++k) {
    Eigen::Matrix3Xd row = Eigen::Matrix3Xd::Zero(3, num_vertices);
    for (size_t i = 0; i < pins[k].vertices.size(); ++i) {
      row.col(pins[k].vertices[i]) += pins[k].coefficients.col(i);
    }
    update_vectors_.col(k) = Reduce(row);
    update_weights_[k] = -pins[k].stiffness;
  }
  for (size_t k = 0; k < means.size(); ++k) {
    update_vectors_.col(pins.size() + k) = Reduce(means[k].coefficients);
    update_weights_[pins.size() + k] = means[k].stiffness;
  }
}

void TangentStiffness::AddSpring(const std::vector<int>& vertices,
                                 const Eigen::Matrix3Xd& coefficients,
                                 double stiffness,
                                 Eigen::VectorXd* values) const {
  const Eigen::MatrixXd rows = basis_.transpose() * coefficients;
  for (size_t j = 0; j < vertices.size(); ++j) {
    for (size_t i = 0; i < vertices.size(); ++i) {
      const Eigen::MatrixXd block = stiffness * rows.col(i) * rows.col(j).transpose();
      pattern_->Add(vertices[i], vertices[j], block, values->data());
    }
  }
}

void TangentStiffness::SetControlSpring(int element,
                                        const Eigen::Matrix3Xd& coefficients,
                                        double stiffness) {
  control_values_ = Eigen::VectorXd::Zero(matrix_.nonZeros());
  AddSpring(
      problem_.surface().control_vertices(element), coefficients, stiffness, &control_values_);
}

void TangentStiffness::AddElementMatrix(int element,
                                        const Eigen::MatrixXd& block,
                                        Eigen::VectorXd* values) const {
  const std::vector<int>& vertices = problem_.surface().control_vertices(element);
  for (size_t j = 0; j < vertices.size(); ++j) {
    for (size_t i = 0; i < vertices.size(); ++i) {
      const Eigen::MatrixXd part = basis_.transpose() * block.block<3, 3>(3 * i, 3 * j) * basis_;
      pattern_->Add(vertices[i], vertices[j], part, values->data());
    }
  }
}

TangentStiffness::Stress TangentStiffness::InitialStress(const StrainPoint& point,
                                                         int index) const {
  Stress stress = point.area * problem_.initial_strains()[index];
  stress.head<3>() = membrane_ * stress.head<3>();
  stress.tail<3>() = bending_ * stress.tail<3>();
  return stress;
}

template <int C>
bool TangentStiffness::EvaluateElements(int begin, int end, const Request& request, int thread) {
  constexpr int kInputs = kVectors * C;
  constexpr int kBlock = C * C;
  using Block = Eigen::Matrix<double, C, C>;
  const StrainMeasure measure = problem_.measure();
  const ShellSurface& surface = problem_.surface();
  const Eigen::Matrix<double, 3, C> basis = basis_;
  Workspace& work = workspaces_[thread];
  const double gas_pressure =
      problem_.nonlinear() ? request.stress_factor * problem_.gas_pressure() : 0.0;
  StrainDerivatives strain;
  ElementProduct product;           // of three components
  std::vector<double> strain_rows;  // of fewer: strains per control vertex
  std::vector<double> blocks;       // what is not in product: of i >= j, [j][i][b][a]
  for (int e = begin; e < end; ++e) {
    const std::vector<int>& vertices = surface.control_vertices(e);
    const int n = static_cast<int>(vertices.size());
    Eigen::Matrix<double, C, Eigen::Dynamic> u(C, n);
    for (int i = 0; i < n; ++i) {
      u.col(i).noalias() = basis.transpose().lazyProduct(problem_.displacements().col(vertices[i]));
    }
    const std::vector<StrainPoint>& points = *problem_.strain_points()[e];
    if (request.matrix) {
      if (C == 3) product.Begin(n, static_cast<int>(points.size()));
      if (C < 3) strain_rows.resize(static_cast<size_t>(6 * C) * n);
      if (C < 3 || gas_pressure != 0.0) blocks.assign(static_cast<size_t>(n) * n * kBlock, 0.0);
    }
    for (size_t q = 0; q < points.size(); ++q) {
      const StrainPoint& point = points[q];
      const int index = point_begin_[e] + static_cast<int>(q);
      const Eigen::Matrix<double, 3, kVectors> k = Inputs<C>(point, basis, u);
      if (!EvaluateStrainDerivatives(measure, point, k.data(), &strain)) return false;
      Stress stress;
      stress.head<3>() = point.area * (membrane_ * strain.strain.head<3>());
      stress.tail<3>() = point.area * (bending_ * strain.strain.tail<3>());
      work.energy += 0.5 * stress.dot(strain.strain);
      if (!problem_.initial_strains().empty()) {
        const Stress initial = InitialStress(point, index);
        stress += initial;
        work.energy += initial.dot(strain.strain);
      }
      if (request.stresses != nullptr) (*request.stresses)[index] = stress;
      if (request.gradient == nullptr && !request.matrix) continue;
      Eigen::Matrix<double, 6, kInputs> b_matrix;
      if constexpr (C == 3) {
        b_matrix = strain.gradient;
      } else {
        for (int b = 0; b < kVectors; ++b) {
          b_matrix.template middleCols<C>(C * b).noalias() =
              strain.gradient.middleCols<3>(3 * b).lazyProduct(basis);
        }
      }
      if (request.gradient != nullptr) {
        const Eigen::Matrix<double, kInputs, 1> g = b_matrix.transpose().lazyProduct(stress);
        for (int i = 0; i < n; ++i) {
          const double* const w = point.weights.data() + 6 * i + kRowD1;
          double* const force = work.gradient.data() + C * vertices[i];
          for (int a = 0; a < C; ++a) {
            force[a] += w[0] * g[a] + w[1] * g[C + a] + w[2] * g[2 * C + a] + w[3] * g[3 * C + a] +
                        w[4] * g[4 * C + a];
          }
        }
      }
      if (!request.matrix) continue;

      if constexpr (C < 3) {
        // The unknowns of a flat plate in the linear theory drive one of the two strains alone:
        // three rows of strains to multiply, not five kinematic vectors.
        const int first = C == 1 ? 3 : 0;
        const Eigen::Matrix3d stiffness = point.area * (C == 1 ? bending_ : membrane_);
        double* const rows = strain_rows.data();
        double* const scaled = rows + 3 * C * n;
        for (int i = 0; i < n; ++i) {
          const double* const w = point.weights.data() + 6 * i + kRowD1;
          Eigen::Map<Eigen::Matrix<double, 3, C>> row(rows + 3 * C * i);
          row = w[0] * b_matrix.template block<3, C>(first, 0);
          for (int b = 1; b < kVectors; ++b) {
            row += w[b] * b_matrix.template block<3, C>(first, C * b);
          }
          Eigen::Map<Eigen::Matrix<double, 3, C>>(scaled + 3 * C * i) = stiffness.lazyProduct(row);
        }
        for (int j = 0; j < n; ++j) {
          const double* const from = scaled + 3 * C * j;
          double* const to = blocks.data() + static_cast<size_t>(j) * n * kBlock;
          for (int i = j; i < n; ++i) {
            const double* const row = rows + 3 * C * i;
            for (int b = 0; b < C; ++b) {
              for (int a = 0; a < C; ++a) {
                to[i * kBlock + b * C + a] += row[3 * a] * from[3 * b] +
                                              row[3 * a + 1] * from[3 * b + 1] +
                                              row[3 * a + 2] * from[3 * b + 2];
              }
            }
          }
        }
      } else {
        Eigen::Matrix<double, 6, kInputs> c_matrix;
        c_matrix.template topRows<3>().noalias() =
            (point.area * membrane_).lazyProduct(b_matrix.template topRows<3>());
        c_matrix.template bottomRows<3>().noalias() =
            (point.area * bending_).lazyProduct(b_matrix.template bottomRows<3>());
        ElementProduct::PointMatrix m = b_matrix.transpose().lazyProduct(c_matrix);
        if (request.initial_stresses != nullptr && !IsLinear(measure)) {
          AddStressStiffness(measure,
                             point,
                             k.data(),
                             request.stress_factor * (*request.initial_stresses)[index],
                             &m);
        }
        product.SetPoint(static_cast<int>(q), point, m);
        if (gas_pressure != 0.0) {
          AddPressureStiffness(point, k, gas_pressure * point.area, n, blocks.data());
        }
      }
    }
    if (!request.matrix) continue;
    if (C == 3) product.Multiply();
    pattern_->AddElement<C>(
        e,
        vertices,
        [&](int i, int j) {
          Block block = Block::Zero();
          if constexpr (C == 3) block = product.Block(i, j);
          if (!blocks.empty()) {
            block +=
                Eigen::Map<const Block>(blocks.data() + (static_cast<size_t>(j) * n + i) * kBlock);
          }
          return block;
        },
        work.values.data());
  }
  return true;
}

bool TangentStiffness::Evaluate(const Request& request) {
  const int num_vertices = pattern_->num_vertices();
  if (!problem_.UpdateGas()) return false;
  // Scaled so that weights are that of mean conditions, of the order of which the others are.
  const double weight = problem_.scaled_material().MembraneStiffness();
  int column = static_cast<int>(problem_.pins().size() + problem_.mean_conditions().size());
  if (request.matrix && problem_.has_gas()) {
    update_vectors_.col(column) =
        std::sqrt(problem_.gas_weight() / weight) * Reduce(problem_.gas_vector());
    update_weights_[column++] = weight;
  }
  if (request.matrix && problem_.grasp() != nullptr) {
    std::vector<Grasp::Travel> travels;
    if (!problem_.grasp()->LineariseTravels(&travels)) return false;
    num_travels_ = static_cast<int>(travels.size());
    update_vectors_.rightCols(problem_.grasp()->num_driven()).setZero();
    travel_changes_.setZero(num_unknowns(), num_travels_);
    travel_compliances_.setZero(num_travels_);
    update_weights_.tail(problem_.grasp()->num_driven()).setConstant(-weight);
    for (int k = 0; k < num_travels_; ++k, ++column) {
      // A finger without contact has nothing to eliminate.
      const bool touches = travels[k].stiffness > 0.0;
      const Eigen::VectorXd coupling = Reduce(travels[k].coupling);
      if (touches) {
        update_vectors_.col(column) = coupling / std::sqrt(weight * travels[k].stiffness);
        travel_changes_.col(k) = -coupling / travels[k].stiffness;
        travel_compliances_[k] = 1.0 / travels[k].stiffness;
      }
    }
  }
  StressField stresses;
  Request inner = request;
  if (request.stresses != nullptr) {
    stresses.resize(num_points());
    inner.stresses = &stresses;
  }
  // Linear strains have one stiffness; what iterates, because of contact, makes it once.
  const bool is_constant = IsLinear(problem_.measure()) && problem_.grasp() != nullptr;
  const bool has_shell = is_constant && shell_values_.size() > 0;
  if (has_shell) inner.matrix = false;
  std::vector<char> defined(num_threads_, 1);
  ParallelFor(num_threads_, problem_.surface().num_elements(), [&](int thread, int begin, int end) {
    Workspace& work = workspaces_[thread];
    work.energy = 0.0;
    if (request.gradient != nullptr) work.gradient.setZero(components_, num_vertices);
    if (inner.matrix) work.values.setZero(matrix_.nonZeros());
    if (has_shell && request.gradient == nullptr && request.energy == nullptr &&
        request.stresses == nullptr) {
      return;
    }
    defined[thread] = components_ == 3   ? EvaluateElements<3>(begin, end, inner, thread)
                      : components_ == 2 ? EvaluateElements<2>(begin, end, inner, thread)
                                         : EvaluateElements<1>(begin, end, inner, thread);
  });
  if (std::find(defined.begin(), defined.end(), 0) != defined.end()) return false;

  Eigen::Matrix3Xd force;
  if (request.matrix) {
    Eigen::Map<Eigen::VectorXd> values(matrix_.valuePtr(), matrix_.nonZeros());
    values = support_values_;
    if (has_shell) {
      values += shell_values_;
    } else {
      for (const Workspace& work : workspaces_) values += work.values;
      if (is_constant) shell_values_ = values - support_values_;
    }
    if (request.control_spring) values += control_values_;
  }
  if ((request.gradient != nullptr || request.matrix) && !AddFollowerForces(request, &force)) {
    return false;
  }
  if (request.stresses != nullptr) request.stresses->swap(stresses);
  if (request.energy != nullptr) {
    double energy = problem_.SupportEnergy() -
                    problem_.DeadForce().cwiseProduct(problem_.displacements()).sum();
    for (const Workspace& work : workspaces_) energy += work.energy;
    *request.energy = energy;
  }
  if (request.gradient != nullptr) {
    Eigen::Matrix3Xd gradient = problem_.SupportGradient() - problem_.DeadForce() - force;
    if (problem_.has_gas()) gradient -= GasForce();
    Eigen::VectorXd reduced = Reduce(gradient);
    for (const Workspace& work : workspaces_) {
      for (int k = 0; k < pattern_->num_blocks(); ++k) {
        reduced.segment(components_ * k, components_) +=
            work.gradient.col(pattern_->vertex_of_block(k));
      }
    }
    request.gradient->swap(reduced);
  }
  return true;
}

template <typename Use>
bool TangentStiffness::ForEachFollower(bool with_stiffness,
                                       double stiffness_part,
                                       const Use& use) const {
  Eigen::Matrix3Xd part;
  Eigen::MatrixXd stiffness;
  std::vector<const double*> blocks;
  for (const ShellProblem::PlacedForce& placed : problem_.follower_forces()) {
    blocks.clear();
    for (const int v : problem_.surface().control_vertices(placed.element)) {
      blocks.push_back(problem_.displacements().col(v).data());
    }
    if (placed.last != nullptr) blocks.push_back(placed.last);
    if (!placed.force->LineariseSoftened(
            blocks.data(), stiffness_part, &part, with_stiffness ? &stiffness : nullptr)) {
      return false;
    }
    if (part.isZero(0.0)) continue;  // A finger that does not touch.
    use(placed, part, stiffness);
  }
  return true;
}

bool TangentStiffness::AddFollowerForces(const Request& request, Eigen::Matrix3Xd* force) {
  *force = Eigen::Matrix3Xd::Zero(3, pattern_->num_vertices());
  return ForEachFollower(
      request.matrix,
      request.stress_factor,
      [&](const auto& placed, const auto& part, const auto& stiffness) {
        const std::vector<int>& vertices = problem_.surface().control_vertices(placed.element);
        for (size_t i = 0; i < vertices.size(); ++i) force->col(vertices[i]) += part.col(i);
        if (!request.matrix) return;
        pattern_->AddElement<Eigen::Dynamic>(
            placed.element,
            vertices,
            [&](int i, int j) -> Eigen::MatrixXd {
              const Eigen::Matrix3d symmetric =
                  0.5 * (stiffness.template block<3, 3>(3 * i, 3 * j) +
                         stiffness.template block<3, 3>(3 * j, 3 * i).transpose());
              return basis_.transpose() * symmetric * basis_;
            },
            matrix_.valuePtr());
      });
}

Eigen::Matrix3Xd TangentStiffness::GasForce() const {
  return problem_.force_unit() * problem_.gas_pressure() * problem_.gas_vector();
}

bool TangentStiffness::FollowerForces(Eigen::Matrix3Xd* force) const {
  *force = Eigen::Matrix3Xd::Zero(3, pattern_->num_vertices());
  if (!problem_.UpdateGas()) return false;
  if (problem_.has_gas()) *force = GasForce();
  return ForEachFollower(false, 1.0, [&](const auto& placed, const auto& part, const auto&) {
    const std::vector<int>& vertices = problem_.surface().control_vertices(placed.element);
    for (size_t i = 0; i < vertices.size(); ++i) force->col(vertices[i]) += part.col(i);
  });
}

Eigen::VectorXd TangentStiffness::ExternalGradient() const {
  Eigen::Matrix3Xd force;
  CHECK(FollowerForces(&force));
  return Reduce(problem_.SupportGradient() - problem_.DeadForce() - force);
}

Eigen::VectorXd TangentStiffness::TravelChanges(const Eigen::VectorXd& step) const {
  if (num_travels_ == 0) return Eigen::VectorXd();
  return travel_changes_.transpose() * step;
}

Eigen::VectorXd TangentStiffness::UpdateWeights(double part_of_means) const {
  Eigen::VectorXd weights = update_weights_;
  weights.segment(problem_.pins().size(), problem_.mean_conditions().size()) *= part_of_means;
  return weights;
}

double TangentStiffness::ForceScale() const {
  Eigen::Matrix3Xd force;
  if (!FollowerForces(&force)) force.setZero();
  return Reduce(problem_.SupportGradient()).norm() + Reduce(problem_.DeadForce() + force).norm();
}

void TangentStiffness::LinearisedStresses(const Eigen::VectorXd& step,
                                          StressField* stresses) const {
  stresses->resize(num_points());
  const Eigen::Matrix3Xd change = Expand(step);
  const ShellSurface& surface = problem_.surface();
  ParallelFor(num_threads_, surface.num_elements(), [&](int, int begin, int end) {
    const Eigen::Matrix3d identity = Eigen::Matrix3d::Identity();
    StrainDerivatives strain;
    for (int e = begin; e < end; ++e) {
      const std::vector<int>& vertices = surface.control_vertices(e);
      const Eigen::Matrix3Xd u = Gather(problem_.displacements(), vertices);
      const Eigen::Matrix3Xd du = Gather(change, vertices);
      const std::vector<StrainPoint>& points = *problem_.strain_points()[e];
      for (size_t q = 0; q < points.size(); ++q) {
        const StrainPoint& point = points[q];
        const Eigen::Matrix<double, 3, kVectors> k = Inputs<3>(point, identity, u),
                                                 dk = Inputs<3>(point, identity, du);
        CHECK(EvaluateStrainDerivatives(problem_.measure(), point, k.data(), &strain));
        const Stress extrapolated =
            strain.strain +
            strain.gradient * Eigen::Map<const Eigen::Matrix<double, kBendingInputs, 1>>(dk.data());
        Stress& stress = (*stresses)[point_begin_[e] + q];
        stress.head<3>() = point.area * (membrane_ * extrapolated.head<3>());
        stress.tail<3>() = point.area * (bending_ * extrapolated.tail<3>());
        if (!problem_.initial_strains().empty()) {
          stress += InitialStress(point, point_begin_[e] + static_cast<int>(q));
        }
      }
    }
  });
}

Eigen::VectorXd TangentStiffness::StressForces(const StressField& stresses) const {
  const ShellSurface& surface = problem_.surface();
  const Eigen::Matrix3d identity = Eigen::Matrix3d::Identity();
  std::vector<Eigen::Matrix3Xd> parts(num_threads_);
  ParallelFor(num_threads_, surface.num_elements(), [&](int thread, int begin, int end) {
    Eigen::Matrix3Xd& part = parts[thread];
    part.setZero(3, pattern_->num_vertices());
    StrainDerivatives strain;
    for (int e = begin; e < end; ++e) {
      const std::vector<int>& vertices = surface.control_vertices(e);
      const Eigen::Matrix3Xd u = Gather(problem_.displacements(), vertices);
      const std::vector<StrainPoint>& points = *problem_.strain_points()[e];
      for (size_t q = 0; q < points.size(); ++q) {
        const Eigen::Matrix<double, 3, kVectors> k = Inputs<3>(points[q], identity, u);
        CHECK(EvaluateStrainDerivatives(problem_.measure(), points[q], k.data(), &strain));
        AddForces(points[q],
                  strain.gradient.transpose() * stresses[point_begin_[e] + q],
                  vertices,
                  &part);
      }
    }
  });
  for (int t = 1; t < num_threads_; ++t) {
    if (parts[t].size() > 0) parts[0] += parts[t];
  }
  return Reduce(parts[0]);
}

bool TangentStiffness::StrainDefect(const Eigen::VectorXd& step, Eigen::VectorXd* forces) {
  const ShellSurface& surface = problem_.surface();
  if (IsLinear(problem_.measure())) {
    *forces = Eigen::VectorXd::Zero(step.size());
    return true;
  }
  const Eigen::Matrix3Xd change = Expand(step);
  const Eigen::Matrix3d identity = Eigen::Matrix3d::Identity();
  std::vector<Eigen::Matrix3Xd> parts(num_threads_);
  std::vector<char> defined(num_threads_, 1);
  ParallelFor(num_threads_, surface.num_elements(), [&](int thread, int begin, int end) {
    Eigen::Matrix3Xd& part = parts[thread];
    part.setZero(3, pattern_->num_vertices());
    StrainDerivatives here, there;
    for (int e = begin; e < end; ++e) {
      const std::vector<int>& vertices = surface.control_vertices(e);
      const Eigen::Matrix3Xd u = Gather(problem_.displacements(), vertices);
      const Eigen::Matrix3Xd du = Gather(change, vertices);
      for (const StrainPoint& point : *problem_.strain_points()[e]) {
        const Eigen::Matrix<double, 3, kVectors> k = Inputs<3>(point, identity, u);
        const Eigen::Matrix<double, 3, kVectors> dk = Inputs<3>(point, identity, du);
        const Eigen::Matrix<double, 3, kVectors> moved = k + dk;
        if (!EvaluateStrainDerivatives(problem_.measure(), point, k.data(), &here) ||
            !EvaluateStrainDerivatives(problem_.measure(), point, moved.data(), &there)) {
          defined[thread] = 0;
          return;
        }
        const Stress defect =
            there.strain - here.strain -
            here.gradient * Eigen::Map<const Eigen::Matrix<double, kBendingInputs, 1>>(dk.data());
        Stress stress;
        stress.head<3>() = point.area * (membrane_ * defect.head<3>());
        stress.tail<3>() = point.area * (bending_ * defect.tail<3>());
        AddForces(point, here.gradient.transpose() * stress, vertices, &part);
      }
    }
  });
  if (std::find(defined.begin(), defined.end(), 0) != defined.end()) return false;
  for (size_t t = 1; t < parts.size(); ++t) parts[0] += parts[t];
  *forces = Reduce(parts[0]);
  return true;
}

double TangentStiffness::LargestRotation(const Eigen::VectorXd& step) const {
  const Eigen::Matrix3Xd change = Expand(step);
  const ShellSurface& surface = problem_.surface();
  std::vector<double> largest(num_threads_, 0.0);
  ParallelFor(num_threads_, surface.num_elements(), [&](int thread, int begin, int end) {
    for (int e = begin; e < end; ++e) {
      const std::vector<int>& vertices = surface.control_vertices(e);
      const StrainPoint& point = problem_.strain_points()[e]->front();
      Eigen::Vector3d x1 = point.t1, x2 = point.t2, d1 = Eigen::Vector3d::Zero(), d2 = d1;
      for (size_t i = 0; i < vertices.size(); ++i) {
        const auto u = problem_.displacements().col(vertices[i]);
        x1 += point.weights(kRowD1, i) * u;
        x2 += point.weights(kRowD2, i) * u;
        d1 += point.weights(kRowD1, i) * change.col(vertices[i]);
        d2 += point.weights(kRowD2, i) * change.col(vertices[i]);
      }
      const Eigen::Vector3d normal = x1.cross(x2).normalized();
      largest[thread] = std::max({largest[thread],
                                  std::abs(normal.dot(d1)) / x1.norm(),
                                  std::abs(normal.dot(d2)) / x2.norm()});
    }
  });
  return *std::max_element(largest.begin(), largest.end());
}

Eigen::Matrix3Xd TangentStiffness::Expand(const Eigen::VectorXd& x) const {
  Eigen::Matrix3Xd result = Eigen::Matrix3Xd::Zero(3, pattern_->num_vertices());
  for (int k = 0; k < pattern_->num_blocks(); ++k) {
    result.col(pattern_->vertex_of_block(k)) = basis_ * x.segment(components_ * k, components_);
  }
  return result;
}

Eigen::VectorXd TangentStiffness::Reduce(const Eigen::Matrix3Xd& covector) const {
  Eigen::VectorXd result(num_unknowns());
  for (int k = 0; k < pattern_->num_blocks(); ++k) {
    result.segment(components_ * k, components_) =
        basis_.transpose() * covector.col(pattern_->vertex_of_block(k));
  }
  return result;
}

Eigen::VectorXd TangentStiffness::Reduce(const std::vector<int>& vertices,
                                         const Eigen::Matrix3Xd& covector) const {
  Eigen::VectorXd result = Eigen::VectorXd::Zero(num_unknowns());
  for (size_t i = 0; i < vertices.size(); ++i) {
    const int block = pattern_->block_of_vertex(vertices[i]);
    if (block < 0) continue;
    result.segment(components_ * block, components_) += basis_.transpose() * covector.col(i);
  }
  return result;
}

}  // namespace darboux
