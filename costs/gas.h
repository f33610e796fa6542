#ifndef DARBOUX_COSTS_GAS_H_
#define DARBOUX_COSTS_GAS_H_

namespace darboux {

// An ideal gas shut in by a closed shell, a fixed amount of it (Moran, Shapiro, Fundamentals of
// Engineering Thermodynamics, polytropic processes): of the absolute pressure p and the volume V,
//
//   p V^gamma = p_0 V_0^gamma      gamma = 1: isothermal, 1.4: adiabatic (diatomic, air)
//
// against an ambient pressure A that stays. p_0 = A + P, P the gauge pressure at the rest volume
// V_0. What it does to the shell has the energy
//
//   U = - integral from V_0 to V of (p - A) dV
//     = - p_0 V_0 ln(V / V_0) + A (V - V_0)                                     gamma = 1
//     = p_0 V_0 ((V / V_0)^(1 - gamma) - 1) / (gamma - 1) + A (V - V_0)         otherwise   [J]
//
// so that dU/dV = -(p - A), the gauge pressure, and d^2U/dV^2 = -dp/dV = gamma p / V > 0: the gas
// stiffens what changes the volume, and nothing else. gamma = 0 is a pressure that stays.
// Everything here is a function of the change of the volume, V - V_0, m^3, which loses no digits
// where it is small. Pressures in Pa.
//
// The linear theory knows the gas to first order in that change,
//
//   p - A = P - gamma p_0 / V_0 (V - V_0),   U = -P (V - V_0) + gamma p_0 / V_0 (V - V_0)^2 / 2
class Gas {
 public:
  // Precondition: ambient + gauge > 0, rest_volume > 0, gamma = 0 or gamma >= 1.
  Gas(double gauge, double ambient, double gamma, double rest_volume, bool linear = false);

  double rest_volume() const { return rest_volume_; }
  double ambient() const { return ambient_; }
  // Amount of gas: gauge pressure at the rest volume. Precondition: ambient + gauge > 0.
  void SetCharge(double gauge) { gauge_ = gauge; }
  double charge() const { return gauge_; }

  // False where the volume is not positive: no gas is compressed that far.
  bool IsDefined(double change) const { return rest_volume_ + change > 0.0; }
  double GaugePressure(double change) const;       // p - A
  double PressureDerivative(double change) const;  // dp/dV, Pa/m^3, negative
  double Energy(double change) const;
  // U(change + more) - U(change) + GaugePressure(change) * more >= 0, what U has beyond its tangent
  // at `change`, and its derivative by `more`, >= 0 where more is. All digits however small `more`.
  // Precondition: IsDefined(change) and IsDefined(change + more).
  double Divergence(double change, double more) const;
  double DivergenceSlope(double change, double more) const;

 private:
  double gauge_;
  double ambient_;
  double gamma_;
  double rest_volume_;
  bool linear_;
};

}  // namespace darboux

#endif  // DARBOUX_COSTS_GAS_H_
