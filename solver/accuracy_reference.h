#ifndef DARBOUX_SOLVER_ACCURACY_REFERENCE_H_
#define DARBOUX_SOLVER_ACCURACY_REFERENCE_H_

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "solver/scene.h"

namespace darboux {

// What the runs of a study of accuracy are measured against. Nothing is solved here.

// A number of the results and what it should be.
struct StudyQuantity {
  std::string path;   // into summary.json
  std::string group;  // quantities of a group have one scale; the displacement of a probe, say
  double reference = 0.0;
  double scale = 0.0;        // errors are relative to it: |reference|, or the group's norm
  double uncertainty = 0.0;  // of the reference, relative to `scale`
  std::string source;
};

// Half a unit in the last digit of a number as it is written shortest, over the number: what its
// rounding leaves open. 4.067 -> 1.2e-4. Zeros at the end of a printed number do not count, so that
// the true one may be less. 0 for 0.
double RoundingUncertainty(double value);

// The entries of scene.expect that say something about accuracy: displacements, forces, travels,
// energies, gas, load factors. Not counts, flags, residuals or zeros, of which *notes tells.
std::vector<StudyQuantity> ExpectedQuantities(const Scene& scene, std::vector<std::string>* notes);

// Where nothing is expected: components of the displacements of all probes, each probe a group;
// normal force, or travel where it is driven by a force, of every finger; the pressure of a gas;
// the last load factor where something else leads the path. A scene without any of these has the
// largest displacement and the total energy. Only paths and groups are set.
std::vector<StudyQuantity> DefaultQuantities(const Scene& scene);

// The limit of values over mesh sizes h, from those of the three finest,
//
//   q(h) = q_0 + c h^p,  (q_1 - q_2) / (q_2 - q_3) = (h_1^p - h_2^p) / (h_2^p - h_3^p)
//
// (Richardson 1911; for steps of 2 p is the binary logarithm of the left side), p at least 1/2.
// The uncertainty is the larger of |q_0 - q_3| / 3 and, where there are four levels, the distance
// to the limit that the three coarsest of the finest four have; with three levels only it is all of
// |q_0 - q_3|.
//
// Nothing is extrapolated, and the limit is q_3, where the three do not approach a limit from one
// side with shrinking steps (uncertainty: the larger step), or where they seem to do so with more
// than the fifth order, which is above what the elements have: the coarsest is then no guide
// (uncertainty: the last step).
struct Extrapolation {
  double value = 0.0;
  double uncertainty = 0.0;
  std::optional<double> order;  // none: not extrapolated
};
// h descends strictly, the same number of values; none for fewer than three or values that are not
// finite.
std::optional<Extrapolation> Extrapolate(const std::vector<double>& h,
                                         const std::vector<double>& values);

// Values of all quantities at the levels of one family that converged, coarse to fine.
struct FamilyValues {
  std::string name;
  std::vector<double> h;                    // descending; elements^-1/2
  std::vector<std::vector<double>> values;  // [level][quantity]
};

// Values extrapolated from runs, which errors may be measured against.
struct RichardsonReference {
  std::vector<StudyQuantity> quantities;
  std::vector<std::optional<double>> orders;  // of each quantity
  double uncertainty = 0.0;                   // the largest of the quantities
  std::string family;                         // which was taken
};

// Extrapolates each family and takes the one whose largest relative uncertainty is least. All have
// the same limit: where another one contradicts it by more than both uncertainties, that much is
// the uncertainty. A quantity whose scale is below 1e-4 of the largest of its kind is measured
// against that: a held point has no relative error. None where no family has three levels.
std::optional<RichardsonReference> ExtrapolateFamilies(const std::vector<StudyQuantity>& quantities,
                                                       const std::vector<FamilyValues>& families);

// The largest |value - reference| / scale, and the uncertainty of that quantity's reference.
struct StudyError {
  double error = 0.0;
  double uncertainty = 0.0;
  int quantity = -1;
  bool IsBelowUncertainty() const { return error < uncertainty; }
};
// None where a value is missing or not finite. `values` by path.
std::optional<StudyError> ErrorOf(const std::vector<StudyQuantity>& quantities,
                                  const std::map<std::string, double>& values);

}  // namespace darboux

#endif  // DARBOUX_SOLVER_ACCURACY_REFERENCE_H_
