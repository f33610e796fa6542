#include "solver/magnitudes.h"

#include <sstream>

namespace darboux {
namespace {

// False for what is not finite as well.
bool IsWithin(double value, double limit) { return value >= 1.0 / limit && value <= limit; }

bool Fail(const SceneLocation& where,
          const std::string& key,
          const std::string& problem,
          std::string* error) {
  *error = where.file + ":" + std::to_string(where.line) + ": " + key + ": " + problem;
  return false;
}

}  // namespace

bool CheckMagnitudes(const Scene& scene, const Magnitudes& magnitudes, std::string* error) {
  constexpr double kLength = 1e60, kForce = 1e120, kRelativeLoad = 1e100;
  std::ostringstream text;
  text.precision(3);
  if (!IsWithin(magnitudes.size, kLength)) {
    text << "found a size of " << magnitudes.size
         << "; allowed 1e-60 to 1e60: another unit of length";
    return Fail(scene.surface.location, "surface", text.str(), error);
  }
  const ShellSpec& shell = scene.shell;
  if (!IsWithin(shell.thickness, kLength)) {
    text << "found " << shell.thickness << "; allowed 1e-60 to 1e60: another unit of length";
    return Fail(shell.location, "shell.thickness", text.str(), error);
  }
  if (!IsWithin(magnitudes.bending_force, kForce)) {
    text << "found " << shell.young_modulus << ", with which E h^3 / (12 (1 - nu^2) size^2) is "
         << magnitudes.bending_force << "; allowed 1e-120 to 1e120: another unit of force";
    return Fail(shell.location, "shell.young_modulus", text.str(), error);
  }
  const double load = magnitudes.loads / magnitudes.bending_force;
  if (load != 0.0 && !IsWithin(load, kRelativeLoad)) {
    text << "found loads of " << magnitudes.loads << " in all, " << load
         << " of the force that bends the shell by its size; allowed 1e-100 to 1e100 of it";
    return Fail(scene.loads.front().location, "loads", text.str(), error);
  }
  return true;
}

}  // namespace darboux
