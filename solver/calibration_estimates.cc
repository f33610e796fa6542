#include "solver/calibration_estimates.h"

#include <algorithm>
#include <cmath>
#include <random>
#include <sstream>

#include "solver/format.h"

namespace darboux {
namespace {

using Estimate = CalibrationSummary::Estimate;

// Of a normal distribution, both sides of 95 %.
constexpr double kTwoSided95 = 1.959963984540054;
// A parameter is identified where its 95 % interval is within a factor of 1.65, Poisson's ratio
// within 0.2.
constexpr double kLogLimit = 0.5 / kTwoSided95;
constexpr double kPoissonLimit = 0.2 / kTwoSided95;
// A pressure that changes no force by more than this part of it is known well enough, however small
// it is itself.
constexpr double kPressureEffect = 0.05;
// Readings below as many of their errors are no force at all.
constexpr double kSignal = 3.0;

const char* Words(StateParameter parameter) {
  switch (parameter) {
    case StateParameter::kYoungModulus:
      return "Young's modulus";
    case StateParameter::kThickness:
      return "the thickness";
    case StateParameter::kPoissonRatio:
      return "Poisson's ratio";
    default:
      return "the gas pressure";
  }
}

}  // namespace

double CalibrationEstimates::ToUnits(int column, double value) const {
  return value * (column < 2 ? 1.0 : problem_->unit(column));
}

// Changes that matter: of logarithms, of Poisson's ratio, of pressures in the problem's unit.
Eigen::VectorXd CalibrationEstimates::Scales() const {
  const std::vector<int> interest = problem_->Interest();
  Eigen::VectorXd scales = Eigen::VectorXd::Ones(interest.size());
  const ShellParameters now = problem_->Parameters();
  for (size_t k = 0; k < interest.size(); ++k) {
    if (interest[k] == 3) {
      double scale = std::abs(now.gas_pressure);
      for (const auto& model : *models_) {
        const LoadSpec* const gas = FindGas(model->scene());
        if (gas != nullptr) scale = std::max(scale, 0.1 * gas->ambient_pressure);
      }
      scales[k] = scale / problem_->unit(3);
    } else if (interest[k] == 2) {
      scales[k] = 0.3;
    }
  }
  return scales;
}

// The largest relative change of a force by this change of the pressure.
double CalibrationEstimates::PressureEffect(double pressure) const {
  double largest = 0.0;
  for (const CalibrationProblem::Force& force : problem_->forces()) {
    const StateDerivative* by = nullptr;
    std::string error;
    StateModel& model = *(*models_)[force.grasp];
    if (FindGas(model.scene()) == nullptr ||
        !model.Derivative(StateParameter::kGasPressure, &by, &error)) {
      continue;
    }
    const double whole = std::abs(problem_->BareForceOf(force));
    if (whole > 0.0) {
      largest = std::max(largest, std::abs(by->force[force.finger] * pressure) / whole);
    }
  }
  return largest;
}

bool CalibrationEstimates::IsIdentified(StateParameter parameter, double deviation) const {
  if (!std::isfinite(deviation)) return false;
  switch (parameter) {
    case StateParameter::kPoissonRatio:
      return deviation <= kPoissonLimit;
    case StateParameter::kGasPressure: {
      const double pressure = std::abs(problem_->Parameters().gas_pressure);
      return deviation <= kLogLimit * pressure ||
             (!problem_->forces().empty() && PressureEffect(deviation) <= kPressureEffect);
    }
    default:
      return deviation <= kLogLimit;
  }
}

void CalibrationEstimates::Sensitivities(const Posterior& posterior) {
  const std::vector<int> interest = problem_->Interest();
  if (interest.empty()) return;
  const auto add =
      [&](const std::string& to, double relative_unit, const Eigen::VectorXd& product) {
        const Eigen::VectorXd change = posterior.ChangeBy(product) * relative_unit;
        for (size_t k = 0; k < interest.size(); ++k) {
          const StateParameter of = static_cast<StateParameter>(interest[k]);
          double value = ToUnits(interest[k], change[k]);
          bool relative = true;
          if (of == StateParameter::kGasPressure) {
            const double pressure = problem_->Parameters().gas_pressure;
            relative = pressure != 0.0;
            if (relative) value /= pressure;
          } else if (of == StateParameter::kPoissonRatio) {
            relative = false;
          }
          summary_.sensitivities.push_back({ToString(of), to, value, relative});
        }
      };
  const Eigen::MatrixXd& h = posterior.information();
  if (!spec_.parameter(StateParameter::kThickness).asked) add("thickness", 1.0, h.col(1));
  if (!spec_.parameter(StateParameter::kPoissonRatio).asked) {
    add("poisson_ratio", problem_->Parameters().poisson_ratio, h.col(2));
  }
  bool gas = false;
  for (const auto& model : *models_) gas = gas || FindGas(model->scene()) != nullptr;
  if (gas && !spec_.parameter(StateParameter::kGasPressure).asked) {
    add("gas_pressure", problem_->Parameters().gas_pressure / problem_->unit(3), h.col(3));
  }
  if (!problem_->forces().empty()) {
    // All readings too high by one factor: minus their residuals' derivative.
    Eigen::VectorXd product = Eigen::VectorXd::Zero(problem_->num_unknowns());
    for (size_t f = 0; f < problem_->forces().size(); ++f) {
      const CalibrationProblem::Force& force = problem_->forces()[f];
      double residual, values[7];
      double* jacobians[7];
      for (int k = 0; k < 7; ++k) jacobians[k] = &values[k];
      problem_->ForceResidual(force, &residual, jacobians);
      const int columns[7] = {0,
                              1,
                              2,
                              3,
                              CalibrationProblem::kBias,
                              CalibrationProblem::kDrift,
                              problem_->TravelColumn(force.grasp)};
      for (int k = 0; k < 7; ++k) {
        product[columns[k]] += values[k] * (-force.reading / force.error);
      }
    }
    add("forces", 1.0, product);
  }
  // All loads too large by one factor: as if the modulus were too small by it.
  if (std::all_of(models_->begin(), models_->end(), [](const std::unique_ptr<StateModel>& model) {
        return IsDrivenByLoads(model->scene());
      })) {
    Eigen::VectorXd product = -h.col(0);
    const CalibrationSpec::Parameter& modulus = spec_.parameter(StateParameter::kYoungModulus);
    // A prior of it is not about loads.
    if (modulus.prior) product[0] += std::pow(*modulus.prior / *modulus.prior_error, 2);
    add("loads", 1.0, product);
  }
  // All travels too long by one factor.
  Eigen::VectorXd product = Eigen::VectorXd::Zero(problem_->num_unknowns());
  bool known_travels = false;
  for (size_t g = 0; g < spec_.grasps.size(); ++g) {
    const auto& fingers = (*models_)[g]->scene().fingers;
    if (fingers.empty() || std::isinf(spec_.grasps[g].travel_error)) continue;
    known_travels = true;
    const int column = problem_->TravelColumn(static_cast<int>(g));
    const double travel = fingers.front().travel + problem_->TravelChange(static_cast<int>(g));
    product += h.col(column) * (travel / problem_->unit(column));
    // A prior of the travel is about what the scene says, not what it is.
    if (spec_.grasps[g].travel_error > 0.0) product[column] -= travel / problem_->unit(column);
  }
  if (known_travels) add("travel", 1.0, product);
}

void CalibrationEstimates::Bootstrap(const std::vector<CalibrationProblem::Row>& rows) {
  if (spec_.bootstrap <= 0) return;
  const std::vector<int> interest = problem_->Interest();
  std::vector<int> free = interest;
  for (const int column : problem_->Nuisances()) free.push_back(column);
  std::vector<int> place(problem_->num_unknowns(), -1);
  for (size_t i = 0; i < free.size(); ++i) place[free[i]] = static_cast<int>(i);
  // One pass over the rows of a resample; steps are linear from the estimate, states are not solved
  // again.
  std::vector<std::vector<size_t>> groups;
  std::vector<size_t> single;
  for (size_t i = 0; i < rows.size(); ++i) {
    if (rows[i].scan < 0) {
      single.push_back(i);
    } else {
      groups.resize(std::max(groups.size(), static_cast<size_t>(rows[i].scan) + 1));
      groups[rows[i].scan].push_back(i);
    }
  }
  std::mt19937_64 generator(spec_.seed);
  const auto uniform = [&] { return (generator() >> 11) * 0x1.0p-53; };
  const auto normal = [&] {
    return std::sqrt(-2.0 * std::log(1.0 - uniform())) * std::cos(2.0 * M_PI * uniform());
  };
  const Eigen::Index n = static_cast<Eigen::Index>(free.size());
  std::vector<std::vector<double>> values(interest.size());
  for (int b = 0; b < spec_.bootstrap; ++b) {
    Eigen::MatrixXd h = Eigen::MatrixXd::Zero(n, n);
    Eigen::VectorXd gradient = Eigen::VectorXd::Zero(n);
    const auto add = [&](const CalibrationProblem::Row& row, double residual) {
      for (size_t i = 0; i < row.columns.size(); ++i) {
        const int pi = place[row.columns[i]];
        if (pi < 0) continue;
        gradient[pi] += row.weight * row.coefficients[i] * residual;
        for (size_t j = 0; j < row.columns.size(); ++j) {
          const int pj = place[row.columns[j]];
          if (pj >= 0) h(pi, pj) += row.weight * row.coefficients[i] * row.coefficients[j];
        }
      }
    };
    for (const std::vector<size_t>& group : groups) {
      for (size_t k = 0; k < group.size(); ++k) {
        const size_t i = group[static_cast<size_t>(uniform() * group.size())];
        add(rows[i], rows[i].residual);
      }
    }
    // There is one of each reading and prior: their errors are drawn.
    for (const size_t i : single) add(rows[i], rows[i].residual + normal());
    const Eigen::VectorXd step = -ScaledPseudoInverse(h, 1e-11) * gradient;
    for (size_t k = 0; k < interest.size(); ++k) values[k].push_back(step[k]);
  }
  for (size_t k = 0; k < interest.size(); ++k) {
    std::sort(values[k].begin(), values[k].end());
    const auto quantile = [&](double q) {
      const double at = q * (values[k].size() - 1);
      const size_t below = static_cast<size_t>(at);
      const size_t above = std::min(below + 1, values[k].size() - 1);
      return values[k][below] + (at - below) * (values[k][above] - values[k][below]);
    };
    Estimate& estimate = summary_.estimates[k];
    const auto value = [&](double step) {
      return interest[k] < 2 ? estimate.value * std::exp(step)
                             : estimate.value + ToUnits(interest[k], step);
    };
    estimate.bootstrap = {value(quantile(0.025)), value(quantile(0.975))};
  }
}

// Which more or less firm grasp would tell the parameters apart best, in words; empty where none of
// those tried does.
std::string CalibrationEstimates::SeparatingGrasp(const Posterior& posterior,
                                                  const Eigen::VectorXd& scales,
                                                  size_t which) {
  constexpr double kFactors[] = {0.25, 0.5, 1.5, 2.0};
  const std::vector<int> interest = problem_->Interest();
  double best = posterior.Find(scales).deviations[which];
  std::string words;
  for (const CalibrationProblem::Force& force : problem_->forces()) {
    StateModel& model = *(*models_)[force.grasp];
    if (model.scene().fingers.empty()) continue;
    const double travel = model.scene().fingers[force.finger].travel;
    const ShellParameters now = problem_->Parameters();
    const double present = model.travel_change();
    for (const double factor : kFactors) {
      std::string error;
      const double change = factor * (travel + present) - travel;
      if (!model.Solve(now, change, &error)) continue;
      Posterior more = posterior;
      Eigen::VectorXd row = Eigen::VectorXd::Zero(problem_->num_unknowns());
      bool known = true;
      for (size_t k = 0; k < interest.size(); ++k) {
        const StateDerivative* by = nullptr;
        known = known && model.Derivative(static_cast<StateParameter>(interest[k]), &by, &error);
        if (known) {
          row[interest[k]] = problem_->unit(interest[k]) * by->force[force.finger] / force.error;
        }
      }
      if (!known) continue;
      row[CalibrationProblem::kBias] =
          model.forces()[force.finger] * problem_->unit(CalibrationProblem::kBias) / force.error;
      more.Add(row, 0.0);
      const double deviation = more.Find(scales).deviations[which];
      if (deviation < 0.5 * best) {
        best = deviation;
        const StateParameter parameter = static_cast<StateParameter>(interest[which]);
        const double units = ToUnits(interest[which], deviation);
        words =
            "a second grasp with a travel of " + Number(factor * (travel + present)) +
            " of finger " + model.scene().fingers[force.finger].name + ", its force read to " +
            Number(force.error) + " (about " + Number(model.forces()[force.finger]) +
            "), would leave +-" +
            (parameter == StateParameter::kYoungModulus || parameter == StateParameter::kThickness
                 ? Percent(std::expm1(kTwoSided95 * units))
                 : Number(kTwoSided95 * units));
      }
    }
    std::string ignored;
    model.Solve(now, present, &ignored);
    break;  // One force tells as much about candidates as all.
  }
  return words;
}

void CalibrationEstimates::Report() {
  const std::vector<int> interest = problem_->Interest();
  Posterior data(problem_->num_unknowns(), interest);
  data.SetFree(problem_->Nuisances());
  std::vector<CalibrationProblem::Row> rows;
  if (!problem_->Linearise(&data, &rows)) {
    summary_.notes.push_back("no derivatives at the estimate: " + problem_->error());
    return;
  }
  Posterior posterior = data;
  const ShellParameters now = problem_->Parameters();
  for (const int k : interest) {
    const CalibrationSpec::Parameter& p = spec_.parameters[k];
    if (!p.prior) continue;
    const double deviation = k < 2 ? *p.prior_error / *p.prior : *p.prior_error / problem_->unit(k);
    const double value = k == 0   ? std::log(now.young_modulus / *p.prior)
                         : k == 1 ? std::log(now.thickness / *p.prior)
                         : k == 2 ? now.poisson_ratio - *p.prior
                                  : (now.gas_pressure - *p.prior) / problem_->unit(3);
    CalibrationProblem::Row row;
    row.columns = {k};
    row.coefficients = Eigen::VectorXd::Constant(1, 1.0 / deviation);
    row.residual = value / deviation;
    posterior.Add(row.columns, row.coefficients, row.residual);
    rows.push_back(row);
  }
  const Eigen::VectorXd scales = Scales();
  const Posterior::Spread spread = posterior.Find(scales), alone = data.Find(scales);

  // One load of a shell with gas: only its shape tells modulus and pressure apart, and the theory
  // does not know shapes well enough for that (pressure on the inner face, stiffening of the wall):
  // against solids the modulus is off by more than its interval.
  const bool one_load = spec_.parameter(StateParameter::kGasPressure).asked &&
                        spec_.parameter(StateParameter::kYoungModulus).asked &&
                        !spec_.parameter(StateParameter::kGasPressure).prior &&
                        !spec_.parameter(StateParameter::kYoungModulus).prior &&
                        spec_.grasps.size() == 1 && !problem_->forces().empty();
  Posterior by_forces(problem_->num_unknowns(), interest);
  by_forces.SetFree(problem_->Nuisances());
  for (const CalibrationProblem::Row& row : rows) {
    if (row.scan < 0) by_forces.Add(row.columns, row.coefficients, row.residual, row.weight);
  }
  bool no_signal = !problem_->forces().empty();
  for (const CalibrationSpec::Grasp& grasp : spec_.grasps) {
    for (const CalibrationSpec::ForceReading& force : grasp.forces) {
      no_signal = no_signal && std::abs(force.value) < kSignal * force.error;
    }
  }
  bool all_identified = true, has_fingers = false;
  for (const auto& model : *models_) has_fingers = has_fingers || !model->scene().fingers.empty();
  for (size_t k = 0; k < interest.size(); ++k) {
    Estimate estimate;
    estimate.parameter = static_cast<StateParameter>(interest[k]);
    estimate.value = interest[k] == 0   ? now.young_modulus
                     : interest[k] == 1 ? now.thickness
                     : interest[k] == 2 ? now.poisson_ratio
                                        : now.gas_pressure;
    estimate.deviation = ToUnits(interest[k], spread.deviations[k]);
    const double reach = kTwoSided95 * estimate.deviation;
    if (interest[k] < 2) {
      estimate.interval = {estimate.value * std::exp(-reach), estimate.value * std::exp(reach)};
    } else {
      estimate.interval = {estimate.value - reach, estimate.value + reach};
      if (interest[k] == 2) {
        estimate.interval[0] = std::max(estimate.interval[0], -1.0);
        estimate.interval[1] = std::min(estimate.interval[1], 0.5);
      }
    }
    const bool by_data =
        IsIdentified(estimate.parameter, ToUnits(interest[k], alone.deviations[k]));
    estimate.identifiable = IsIdentified(estimate.parameter, estimate.deviation);
    const bool is_modulus = estimate.parameter == StateParameter::kYoungModulus;
    const bool by_shape = one_load && estimate.identifiable &&
                          (is_modulus || estimate.parameter == StateParameter::kGasPressure);
    if (by_shape) {
      estimate.identifiable = false;
      estimate.verdict = std::string("not identifiable: from one grasp only the shape tells ") +
                         Words(StateParameter::kYoungModulus) + " and the gas pressure apart, " +
                         "which the theory does not know well enough for that";
      const std::string grasp = SeparatingGrasp(by_forces, scales, k);
      if (!grasp.empty()) estimate.verdict += "; " + grasp;
    } else if (is_modulus && no_signal && spec_.parameters[0].prior == std::nullopt &&
               problem_->fields().empty()) {
      estimate.identifiable = false;
      estimate.verdict =
          "not identifiable: no force reading is above " + Number(kSignal) +
          " times its error, so that any small modulus explains them; a firmer grasp is needed";
    } else if (estimate.identifiable && by_data) {
      estimate.verdict = "identified";
    } else if (estimate.identifiable) {
      estimate.verdict = "known from its prior; the measurements do not tell it";
    } else {
      std::ostringstream text;
      text << "not identifiable: the measurements leave " << Words(estimate.parameter)
           << " open by ";
      if (!std::isfinite(estimate.deviation)) {
        text << "any amount";
      } else if (interest[k] < 2) {
        text << "a factor of " << Number(std::exp(reach));
      } else {
        text << "+-" << Number(reach);
      }
      // What it trades against, along the direction that is determined least.
      size_t other = k;
      for (size_t j = 0; j < interest.size(); ++j) {
        if (j != k && std::abs(spread.weakest[j]) > 0.1 &&
            (other == k || std::abs(spread.weakest[j]) > std::abs(spread.weakest[other]))) {
          other = j;
        }
      }
      if (other != k && std::abs(spread.weakest[k]) > 0.1) {
        text << ", more of it against "
             << (spread.weakest[k] * spread.weakest[other] < 0.0 ? "less" : "more") << " of "
             << Words(static_cast<StateParameter>(interest[other]));
      }
      const std::string grasp = SeparatingGrasp(posterior, scales, k);
      if (!grasp.empty()) {
        text << "; " << grasp;
      } else if (problem_->forces().empty() && is_modulus && has_fingers) {
        text << "; a reading of a finger's force is needed";
      }
      estimate.verdict = text.str();
    }
    all_identified = all_identified && estimate.identifiable;
    summary_.estimates.push_back(estimate);
  }
  if (all_identified) summary_.correlation = spread.correlation;
  Sensitivities(posterior);
  Bootstrap(rows);
  for (size_t g = 0; g < spec_.grasps.size(); ++g) {
    const int column = problem_->TravelColumn(static_cast<int>(g));
    const double h = posterior.information()(column, column);
    if (spec_.grasps[g].travel_error > 0.0 && h > 0.0) {
      summary_.grasps[g].travel_deviation = problem_->unit(column) / std::sqrt(h);
    }
  }
}
}  // namespace darboux
