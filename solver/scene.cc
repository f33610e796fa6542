#include "solver/scene.h"

namespace darboux {

const char* ToString(Minimizer minimizer) {
  switch (minimizer) {
    case Minimizer::kAuto:
      return "auto";
    case Minimizer::kMip:
      return "mip";
    case Minimizer::kCeres:
      return "ceres";
    case Minimizer::kCg:
      return "cg";
  }
  return "unknown";
}

const char* ToString(PathControl control) {
  switch (control) {
    case PathControl::kLoad:
      return "load";
    case PathControl::kDisplacement:
      return "displacement";
    case PathControl::kArcLength:
      return "arc_length";
  }
  return "";
}

const char* ToString(Theory theory) {
  switch (theory) {
    case Theory::kAuto:
      return "auto";
    case Theory::kLinear:
      return "linear";
    case Theory::kNonlinear:
      return "nonlinear";
  }
  return "unknown";
}

const char* ToString(Strains strains) {
  switch (strains) {
    case Strains::kKoiter:
      return "koiter";
    case Strains::kSeed:
      return "seed";
  }
  return "unknown";
}

const char* ToString(BoundaryRule rule) {
  switch (rule) {
    case BoundaryRule::kIndependent:
      return "independent";
    case BoundaryRule::kSeedGhosts:
      return "seed_ghosts";
  }
  return "unknown";
}

const char* ToString(Unstable unstable) {
  return unstable == Unstable::kReport ? "report" : "leave";
}

const char* ToString(GasLaw law) {
  switch (law) {
    case GasLaw::kIsothermal:
      return "isothermal";
    case GasLaw::kAdiabatic:
      return "adiabatic";
    case GasLaw::kIsobaric:
      return "isobaric";
  }
  return "";
}

const LoadSpec* FindGas(const Scene& scene) {
  for (const LoadSpec& load : scene.loads) {
    if (load.kind == LoadSpec::Kind::kGas) return &load;
  }
  return nullptr;
}

}  // namespace darboux
