#include "solver/scanned_state.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include "solver/fields.h"
#include "solver/grasp.h"

namespace darboux {

ScanSurface ScannedFace(const ShellProblem& problem, const LoadStep& step, ScanSampling sampling) {
  const ShellSurface& surface = problem.surface();
  const double offset = 0.5 * problem.scene().shell.thickness;
  if (sampling == ScanSampling::kArea) {
    // Fine elements need not be cut as finely.
    constexpr double kTriangles = 1e5;
    const int parts = std::clamp(
        static_cast<int>(std::lround(std::sqrt(kTriangles / surface.num_elements()))), 1, 4);
    return ScanSurfaceOf(surface, step.displacements, offset, parts);
  }
  ScanSurface face;
  OutputMesh mesh = MakeOutputMesh(surface);
  for (const ElementPoint& at : mesh.points) {
    face.points.push_back(EvaluateFace(surface, step.displacements, offset, at));
    face.mesh.vertices.push_back(face.points.back().position);
  }
  face.mesh.triangles = std::move(mesh.triangles);
  return face;
}

bool FingersOf(const Scene& scene,
               const LoadStep& step,
               std::vector<Occluder>* fingers,
               std::string* error) {
  for (std::size_t f = 0; f < scene.fingers.size(); ++f) {
    const FingerSpec& spec = scene.fingers[f];
    if (spec.shape == FingerSpec::Shape::kPin) continue;
    Occluder body;
    body.shape = MakeFinger(spec, &body.pose, error);
    if (body.shape == nullptr) return false;
    const Eigen::Vector3d direction(spec.direction[0], spec.direction[1], spec.direction[2]);
    body.pose.position += (step.fingers[f].shift + step.fingers[f].travel) * direction;
    fingers->push_back(std::move(body));
  }
  return true;
}

}  // namespace darboux
