#include <glog/logging.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <functional>
#include <memory>
#include <numeric>
#include <string>
#include <utility>
#include <vector>

#include "costs/gas_blocks.h"
#include "costs/load_work.h"
#include "solver/parallel_for.h"
#include "solver/shell_problem.h"

// The gas in a closed shell: its blocks, and its pressure by the volume that the shell encloses.

namespace darboux {

void ShellProblem::AddGas(const LoadSpec& load, double scale) {
  EffectReport& report = effects_[static_cast<int>(Effect::kGas)];
  report.on = true;
  report.why = std::string("the scene names a gas load, ") + ToString(load.law) +
               (load.prestressed ? ", rest shape pre-stressed" : "");
  const double unit = 1.0 / force_unit_;
  const double largest = (load.ambient_pressure + load.gauge_pressure) * unit;
  gas_ = std::make_unique<GasState>(load);
  double volume = 0.0;
  for (int e = 0; e < surface_->num_elements(); ++e) {
    double area = 0.0;
    for (const StrainPoint& point : *points_[e]) area += point.area;
    auto* cost = new FollowerPressure(points_[e],
                                      std::vector<double>(points_[e]->size(), unit),
                                      frame_.center,
                                      &gas_->pressure,
                                      scale * largest * area,
                                      !options_.nonlinear);
    Record(Effect::kGas,
           Potential::AddTo(problem_.get(), cost, Blocks(surface_->control_vertices(e))),
           1);
    followers_.push_back({e, cost});
    gas_->blocks.push_back({e, cost});
    volume += cost->RestVolume();
  }
  CHECK_GT(volume, 0.0);        // Closed meshes are wound outwards.
  constexpr double kAir = 1.4;  // diatomic
  const double gamma = load.law == GasLaw::kAdiabatic  ? kAir
                       : load.law == GasLaw::kIsobaric ? 0
                                                       : 1;
  gas_->law = Gas(load.gauge_pressure, load.ambient_pressure, gamma, volume, !options_.nonlinear);
  gas_->volumes.assign(gas_->blocks.size(), 0.0);
  if (gamma > 0.0) {
    AddGasShares(gamma * (load.ambient_pressure + load.gauge_pressure) / volume / force_unit_);
  }
  CHECK(UpdateGas());
}

void ShellProblem::AddGasShares(double stiffness) {
  // What the springs leave behind of a change of pressure. Stiffer ones need fewer passes, but
  // where Ceres damps, it damps every share.
  constexpr double kLeft = 1e-4;
  const int leaves = static_cast<int>(gas_->blocks.size());
  gas_->shares.assign(2 * leaves - 1, 0.0);
  const double spring = stiffness / kLeft * static_cast<double>(gas_->shares.size());
  double area = 0.0;
  std::vector<Eigen::Vector3d> centers;
  for (const auto& block : gas_->blocks) {
    for (const StrainPoint& point : *points_[block.first]) area += point.area;
    centers.push_back(points_[block.first]->front().position);
  }
  // Halved across the longest side of what is left: a factorisation by nested dissection meets
  // neighbours before it meets their sums.
  std::vector<int> order(leaves);
  std::iota(order.begin(), order.end(), 0);
  int used = 0;
  const std::function<double*(int, int)> add = [&](int begin, int end) -> double* {
    double* const share = &gas_->shares[used++];
    problem_->AddParameterBlock(share, 1);
    if (end - begin == 1) {
      const auto& [element, volume] = gas_->blocks[order[begin]];
      std::vector<double*> parameters = Blocks(surface_->control_vertices(element));
      parameters.push_back(share);
      auto* cost = new GasShare(volume, &gas_->volumes[order[begin]], spring, area);
      Record(Effect::kGas, problem_->AddResidualBlock(cost, nullptr, parameters), 1);
      return share;
    }
    Eigen::AlignedBox3d box;
    for (int k = begin; k < end; ++k) box.extend(centers[order[k]]);
    int axis;
    box.sizes().maxCoeff(&axis);
    const int middle = (begin + end) / 2;
    std::nth_element(
        order.begin() + begin, order.begin() + middle, order.begin() + end, [&](int a, int b) {
          return centers[a][axis] < centers[b][axis];
        });
    double* const left = add(begin, middle);
    double* const right = add(middle, end);
    Record(Effect::kGas,
           problem_->AddResidualBlock(new GasSum(spring, area), nullptr, {left, right, share}),
           1);
    return share;
  };
  double* const root = add(0, leaves);
  auto* cost = new GasSpring(&gas_->law, &gas_->change, area, 1.0 / force_unit_);
  Record(Effect::kGas, problem_->AddResidualBlock(cost, nullptr, {root}), 1);
}

void ShellProblem::SetGasCharge(double part) {
  if (gas_ == nullptr) return;
  gas_->law.SetCharge(part * gas_->gauge);
  gas_->at.resize(3, 0);
}

bool ShellProblem::UpdateGas() const {
  if (gas_ == nullptr) return true;
  GasState& gas = *gas_;
  if (gas.at.cols() == displacements_.cols() && gas.at == displacements_) return true;
  gas.at.resize(3, 0);
  std::fill(gas.shares.begin(), gas.shares.end(), 0.0);
  if (!displacements_.allFinite()) return false;
  const int count = static_cast<int>(gas.blocks.size());
  const int num_threads = ThreadsFor(count, options_.num_threads);
  std::vector<double> changes(num_threads, 0.0);
  std::vector<Eigen::Matrix3Xd> gradients(num_threads);
  gas.pressure = 1.0;  // Forces are gradients of the volume then.
  ParallelFor(num_threads, count, [&](int thread, int begin, int end) {
    gradients[thread].setZero(3, displacements_.cols());
    std::vector<const double*> blocks;
    for (int k = begin; k < end; ++k) {
      const std::vector<int>& vertices = surface_->control_vertices(gas.blocks[k].first);
      blocks.clear();
      for (const int vertex : vertices) blocks.push_back(displacements_.col(vertex).data());
      gas.volumes[k] = gas.blocks[k].second->SweptVolume(blocks.data());
      changes[thread] += gas.volumes[k];
      const Eigen::Matrix3Xd force = gas.blocks[k].second->ExactForce(blocks.data());
      for (size_t i = 0; i < vertices.size(); ++i) {
        gradients[thread].col(vertices[i]) += force.col(i);
      }
    }
  });
  gas.change = std::accumulate(changes.begin(), changes.end(), 0.0);
  gas.gradient = gradients.front();
  for (int t = 1; t < num_threads; ++t) gas.gradient += gradients[t];
  if (!gas.law.IsDefined(gas.change)) return false;
  gas.pressure = gas.law.GaugePressure(gas.change);
  gas.at = displacements_;
  return true;
}

double ShellProblem::gas_weight() const {
  return -force_unit_ * gas_->law.PressureDerivative(gas_->change);
}

GasReport ShellProblem::ReportGas() const {
  GasReport report;
  if (gas_ == nullptr || !UpdateGas()) return report;
  report.gauge_pressure = gas_->pressure;
  report.absolute_pressure = gas_->law.ambient() + gas_->pressure;
  report.volume = gas_->law.rest_volume() + gas_->change;
  report.volume_ratio = report.volume / gas_->law.rest_volume();
  return report;
}

}  // namespace darboux
