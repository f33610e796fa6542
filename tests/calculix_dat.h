#ifndef DARBOUX_TESTS_CALCULIX_DAT_H_
#define DARBOUX_TESTS_CALCULIX_DAT_H_

#include <Eigen/Core>
#include <algorithm>
#include <cctype>
#include <cstdio>
#include <map>
#include <sstream>
#include <string>

namespace darboux {

// What CalculiX has printed for a deck of solver/inp_export.h, of the last step; names in capitals.
struct CalculixResult {
  std::map<std::string, Eigen::Vector3d> probes;  // displacements
  std::map<std::string, Eigen::Vector3d> forces;  // totals of the fingers' nodes
  std::map<std::string, double> travels;          // of fingers that a force drives
};

inline CalculixResult ReadCalculixDat(const std::string& text) {
  CalculixResult result;
  std::istringstream lines(text);
  std::string line, set;
  bool displacements = false;
  while (std::getline(lines, line)) {
    const size_t at = line.find("for set ");
    if (at != std::string::npos) {
      std::istringstream(line.substr(at + 8)) >> set;
      displacements = line.find("displacements") != std::string::npos;
      continue;
    }
    int node = 0;
    Eigen::Vector3d x;
    const auto begins = [&set](const char* prefix) { return set.rfind(prefix, 0) == 0; };
    if (displacements &&
        std::sscanf(line.c_str(), "%d %lf %lf %lf", &node, &x[0], &x[1], &x[2]) == 4) {
      if (begins("TRAVEL_")) result.travels[set.substr(7)] = x[0];
      if (begins("PROBE_")) result.probes[set.substr(6)] = x;
    } else if (!displacements && begins("FINGER_") &&
               std::sscanf(line.c_str(), "%lf %lf %lf", &x[0], &x[1], &x[2]) == 3) {
      result.forces[set.substr(7)] = x;
    }
  }
  return result;
}

// A name as CalculiX prints it.
inline std::string Upper(std::string name) {
  std::transform(name.begin(), name.end(), name.begin(), [](unsigned char c) {
    return static_cast<char>(std::toupper(c));
  });
  return name;
}

}  // namespace darboux

#endif  // DARBOUX_TESTS_CALCULIX_DAT_H_
