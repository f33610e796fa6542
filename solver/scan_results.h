#ifndef DARBOUX_SOLVER_SCAN_RESULTS_H_
#define DARBOUX_SOLVER_SCAN_RESULTS_H_

#include <Eigen/Core>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "geometry/rigid_pose.h"
#include "geometry/shell_face.h"
#include "geometry/shell_surface.h"
#include "solver/registration.h"
#include "solver/results.h"

namespace darboux {

// What is written of a scan beside a shape. Numbers that are not finite become null in JSON.

// percent_of: a length, e.g. the largest displacement, that mean absolute, rms and max are also
// given of in percent; 0: none.
nlohmann::ordered_json ToJson(const DistanceStatistics& statistics, double percent_of);
nlohmann::ordered_json ToJson(const RigidPose& pose);
nlohmann::ordered_json ToJson(const RegistrationSummary& summary);

// The error map, at the points of MakeOutputMesh: scan_distance, the mean signed distance of the
// nearest few scan points (by their feet), and scan_coverage, 1 where such are within twice
// the distance of a scan point to its fourth neighbour (median) and 0 where the map only repeats
// the nearest there are. counts: of each point whether it has a part in the map (no outliers);
// empty: all.
std::vector<ExtraField> MakeScanFields(const ShellFace& face,
                                       const std::vector<ShellFace::Foot>& feet,
                                       const std::vector<double>& distances,
                                       const std::vector<char>& counts);

// The scan in the shell's frame as text PLY, with the scalars distance and inlier.
std::string MakeRegisteredPly(const std::vector<Eigen::Vector3d>& scan,
                              const RigidPose& pose,
                              const std::vector<double>& distances,
                              const std::vector<char>& counts);

}  // namespace darboux

#endif  // DARBOUX_SOLVER_SCAN_RESULTS_H_
