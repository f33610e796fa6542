#include "solver/accuracy_plan.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>

#include "geometry/icosphere.h"
#include "geometry/loop_mesh.h"
#include "geometry/nearest_name.h"
#include "solver/format.h"

namespace darboux {
namespace {

constexpr StudyAxis kAllAxes[kNumStudyAxes] = {StudyAxis::kResolution,
                                               StudyAxis::kGrading,
                                               StudyAxis::kQuadrature,
                                               StudyAxis::kBoundaryRule,
                                               StudyAxis::kStrains,
                                               StudyAxis::kTheory,
                                               StudyAxis::kSolver};
constexpr double kCoarsest = 0.25;
constexpr int kLevels = 5, kMeshLevels = 3;
constexpr double kGradings[] = {0.0, 0.5, 0.85};
constexpr int kQuadratures[] = {1, 3, 6, 12};

// An icosphere keeps no frequency, but its number of vertices tells: 10 n^2 + 2.
int Frequency(const SurfaceSpec& surface, double refinement) {
  const double own = std::round(std::sqrt((surface.mesh->vertices.size() - 2.0) / 10.0));
  return std::max(1, static_cast<int>(std::lround(own * refinement)));
}

std::array<int, 2> Divisions(const SurfaceSpec& surface, double refinement) {
  std::array<int, 2> result;
  for (int i = 0; i < 2; ++i) {
    const double wanted = std::round(refinement * surface.divisions[i]);
    result[i] = static_cast<int>(std::clamp(wanted, surface.periodic[i] ? 4.0 : 1.0, 1e6));
  }
  return result;
}

// Parameters of the point of the surface nearest to x, on a lattice fine enough to tell thirds.
std::array<double, 2> NearestParameters(const SurfaceSpec& surface, const Eigen::Vector3d& x) {
  constexpr int kSteps = 32;
  std::array<double, 2> best{};
  double least = std::numeric_limits<double>::infinity();
  for (int i = 0; i <= kSteps; ++i) {
    for (int j = 0; j <= kSteps; ++j) {
      const double s = static_cast<double>(i) / kSteps, t = static_cast<double>(j) / kSteps;
      const double u = surface.u_range[0] + s * (surface.u_range[1] - surface.u_range[0]);
      const double v = surface.v_range[0] + t * (surface.v_range[1] - surface.v_range[0]);
      const double distance = (surface.surface->Evaluate(u, v).x - x).norm();
      if (distance < least) {
        least = distance;
        best = {s, t};
      }
    }
  }
  return best;
}

// What varying one axis gives, the scene's own value included where it is one of these.
std::vector<StudySettings> Vary(const Scene& scene,
                                StudyAxis axis,
                                const StudySettings& own,
                                std::vector<std::string>* notes) {
  std::vector<StudySettings> list{own};
  const auto add = [&](const StudySettings& settings) {
    if (std::find(list.begin(), list.end(), settings) == list.end()) list.push_back(settings);
  };
  const bool parametric = scene.surface.mesh == nullptr;
  StudySettings varied = own;
  switch (axis) {
    case StudyAxis::kResolution:
      break;
    case StudyAxis::kGrading: {
      const std::array<int, 2> ends = FavouredEnds(scene);
      if (ends[0] == 0 && ends[1] == 0) {
        notes->push_back(parametric ? "grading is not varied: no end of u or v stands out"
                                    : "grading is not varied: meshes have none");
        break;
      }
      for (const double g : kGradings) {
        for (int i = 0; i < 2; ++i) varied.grading[i] = g == 0.0 ? 0.0 : g * ends[i];
        add(varied);
      }
      break;
    }
    case StudyAxis::kQuadrature:
      for (const int points : kQuadratures) {
        varied.quadrature = points;
        add(varied);
      }
      break;
    case StudyAxis::kBoundaryRule:
      if (!parametric || (scene.surface.periodic[0] && scene.surface.periodic[1])) {
        notes->push_back("the boundary rule is not varied: the surface has no ghost ring");
      } else if (own.theory == Theory::kNonlinear) {
        notes->push_back("the boundary rule is not varied: seed_ghosts is for the linear theory");
      } else {
        for (const BoundaryRule rule : {BoundaryRule::kIndependent, BoundaryRule::kSeedGhosts}) {
          varied.boundary_rule = rule;
          add(varied);
        }
      }
      break;
    case StudyAxis::kStrains:
      for (const Strains strains : {Strains::kKoiter, Strains::kSeed}) {
        varied.strains = strains;
        add(varied);
      }
      break;
    case StudyAxis::kTheory:
      for (const Theory theory : {Theory::kLinear, Theory::kNonlinear}) {
        varied.theory = theory;
        add(varied);
      }
      break;
    case StudyAxis::kSolver: {
      const bool suite_sparse = own.backend == SparseBackend::kSuiteSparse ||
                                (own.backend == SparseBackend::kAuto && HasCholmod());
      varied.backend = suite_sparse ? SparseBackend::kEigen : SparseBackend::kSuiteSparse;
      if (suite_sparse || HasCholmod()) add(varied);
      varied = own;
      // mip is what auto does unless it fails.
      varied.minimizer = own.minimizer == Minimizer::kCeres ? Minimizer::kAuto : Minimizer::kCeres;
      add(varied);
      break;
    }
  }
  return list;
}

std::string GradingText(const std::array<double, 2>& grading) {
  if (std::abs(grading[0]) == std::abs(grading[1])) {
    return "grading " + Format("%g", std::abs(grading[0]));
  }
  return "grading " + Format("%g", grading[0]) + "/" + Format("%g", grading[1]);
}

std::string Points(int quadrature) {
  return std::to_string(quadrature) + (quadrature == 1 ? " point" : " points");
}

std::string Difference(const StudySettings& settings, const StudySettings& own) {
  std::vector<std::string> words;
  if (settings.grading != own.grading) words.push_back(GradingText(settings.grading));
  if (settings.quadrature != own.quadrature) words.push_back(Points(settings.quadrature));
  if (settings.boundary_rule != own.boundary_rule) {
    words.push_back(ToString(settings.boundary_rule));
  }
  if (settings.strains != own.strains) words.push_back(ToString(settings.strains));
  if (settings.theory != own.theory) words.push_back(ToString(settings.theory));
  if (settings.minimizer != own.minimizer) {
    words.push_back(std::string("minimizer ") + ToString(settings.minimizer));
  }
  if (settings.backend != own.backend) words.push_back(ToString(settings.backend));
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : ", ") + word;
  return text;
}

}  // namespace

const char* ToString(StudyAxis axis) {
  switch (axis) {
    case StudyAxis::kResolution:
      return "resolution";
    case StudyAxis::kGrading:
      return "grading";
    case StudyAxis::kQuadrature:
      return "quadrature";
    case StudyAxis::kBoundaryRule:
      return "boundary_rule";
    case StudyAxis::kStrains:
      return "strains";
    case StudyAxis::kTheory:
      return "theory";
    case StudyAxis::kSolver:
      return "solver";
  }
  return "";
}

const char* ToString(SparseBackend backend) {
  switch (backend) {
    case SparseBackend::kAuto:
      return "auto";
    case SparseBackend::kSuiteSparse:
      return "suite_sparse";
    case SparseBackend::kEigen:
      return "eigen";
  }
  return "";
}

bool ParseStudyAxes(const std::string& text, std::vector<StudyAxis>* axes, std::string* error) {
  std::vector<std::string> names;
  std::string allowed;
  for (const StudyAxis axis : kAllAxes) {
    names.push_back(ToString(axis));
    allowed += (allowed.empty() ? "" : ", ") + names.back();
  }
  axes->clear();
  for (size_t begin = 0; begin <= text.size();) {
    const size_t end = std::min(text.find(',', begin), text.size());
    const std::string name = text.substr(begin, end - begin);
    const auto found = std::find(names.begin(), names.end(), name);
    if (found == names.end()) {
      const std::string nearest = NearestName(name, names);
      *error = "found '" + name + "'; allowed some of " + allowed + ", joined by commas" +
               (nearest.empty() ? "" : "; did you mean '" + nearest + "'?");
      return false;
    }
    const StudyAxis axis = kAllAxes[found - names.begin()];
    if (std::find(axes->begin(), axes->end(), axis) == axes->end()) axes->push_back(axis);
    begin = end + 1;
  }
  return true;
}

bool operator==(const StudySettings& a, const StudySettings& b) {
  return a.refinement == b.refinement && a.grading == b.grading && a.quadrature == b.quadrature &&
         a.boundary_rule == b.boundary_rule && a.strains == b.strains && a.theory == b.theory &&
         a.minimizer == b.minimizer && a.backend == b.backend;
}

std::array<int, 2> FavouredEnds(const Scene& scene) {
  const SurfaceSpec& surface = scene.surface;
  std::array<int, 2> ends{0, 0};
  if (surface.mesh != nullptr) return ends;
  // Places, from 0 to 1 along u and v; what is uniform along a parameter says nothing about it.
  std::array<std::vector<double>, 2> places;
  const auto add_point = [&](const SurfacePoint& point) {
    std::array<double, 2> at;
    if (point.kind == SurfacePoint::Kind::kUv) {
      at = {(point.uv[0] - surface.u_range[0]) / (surface.u_range[1] - surface.u_range[0]),
            (point.uv[1] - surface.v_range[0]) / (surface.v_range[1] - surface.v_range[0])};
    } else {
      at = NearestParameters(surface, Eigen::Vector3d(point.nearest.data()));
    }
    for (int i = 0; i < 2; ++i) places[i].push_back(at[i]);
  };
  const auto add_nearest = [&](const std::array<double, 3>& x) {
    SurfacePoint point;
    point.kind = SurfacePoint::Kind::kNearest;
    point.nearest = x;
    add_point(point);
  };
  for (const LoadSpec& load : scene.loads) {
    if (load.kind == LoadSpec::Kind::kPoint) add_point(load.at);
  }
  for (const FingerSpec& finger : scene.fingers) add_nearest(finger.position);
  // Held points matter where nothing else does: what they bear is usually little.
  if (places[0].empty()) {
    for (const SupportSpec& support : scene.supports) {
      if (support.on.kind == Region::Kind::kNear) add_nearest(support.on.center);
      if (support.kind != SupportSpec::Kind::kClamped) continue;
      switch (support.on.kind) {
        case Region::Kind::kUMin:
          places[0].push_back(0.0);
          break;
        case Region::Kind::kUMax:
          places[0].push_back(1.0);
          break;
        case Region::Kind::kVMin:
          places[1].push_back(0.0);
          break;
        case Region::Kind::kVMax:
          places[1].push_back(1.0);
          break;
        case Region::Kind::kRim:
          for (std::vector<double>& list : places) list.insert(list.end(), {0.0, 1.0});
          break;
        case Region::Kind::kNear:
          break;
      }
    }
  }
  for (int i = 0; i < 2; ++i) {
    if (surface.periodic[i]) continue;
    if (surface.grading[i] != 0.0) {
      ends[i] = surface.grading[i] > 0.0 ? 1 : -1;
    } else if (!places[i].empty()) {
      const auto [low, high] = std::minmax_element(places[i].begin(), places[i].end());
      if (*high < 1.0 / 3.0) ends[i] = -1;
      if (*low > 2.0 / 3.0) ends[i] = 1;
    }
  }
  return ends;
}

bool CanBeCoarsened(const SurfaceSpec& surface) {
  return surface.mesh == nullptr || (surface.kind == "icosphere" && surface.interpolate);
}

StudyPlan MakeStudyPlan(const Scene& scene, const PlanOptions& options) {
  StudyPlan plan;
  std::vector<StudyAxis> axes = options.axes;
  if (axes.empty()) axes.assign(std::begin(kAllAxes), std::end(kAllAxes));

  StudySettings own;
  own.grading = scene.surface.grading;
  own.quadrature = scene.model.quadrature;
  own.boundary_rule = scene.model.boundary_rule;
  own.strains = scene.model.strains;
  own.theory = scene.model.theory;
  own.minimizer = scene.model.minimizer;
  own.backend = options.backend;

  std::vector<double> refinements{1.0};
  if (std::find(axes.begin(), axes.end(), StudyAxis::kResolution) != axes.end()) {
    const bool coarsens = CanBeCoarsened(scene.surface);
    const int levels = options.levels > 0 ? options.levels : coarsens ? kLevels : kMeshLevels;
    refinements.clear();
    for (int k = 0; k < levels; ++k) {
      refinements.push_back(std::ldexp(coarsens ? kCoarsest : 1.0, k));
    }
  }

  std::vector<StudySettings> families{own};
  for (const StudyAxis axis : axes) {
    const std::vector<StudySettings> from =
        options.product ? families : std::vector<StudySettings>{own};
    for (size_t k = 0; k < from.size(); ++k) {
      std::vector<std::string> notes;
      for (const StudySettings& varied : Vary(scene, axis, from[k], &notes)) {
        if (std::find(families.begin(), families.end(), varied) == families.end()) {
          families.push_back(varied);
        }
      }
      if (k == 0) plan.notes.insert(plan.notes.end(), notes.begin(), notes.end());
    }
  }
  for (const StudySettings& family : families) plan.families.push_back(Difference(family, own));
  plan.families[0] = "the scene's own";

  const int num_families = static_cast<int>(families.size());
  const auto add = [&](int level, int family) {
    PlannedRun run{families[family], level, family};
    run.settings.refinement = refinements[level];
    plan.runs.push_back(run);
  };
  const int num_levels = static_cast<int>(refinements.size());
  for (int level = 0; level < num_levels; ++level) add(level, 0);
  for (int level = 0; level < num_levels; ++level) {
    for (int family = 1; family < num_families; ++family) add(level, family);
  }
  return plan;
}

double EstimatedDof(const Scene& scene, const StudySettings& settings) {
  const SurfaceSpec& surface = scene.surface;
  if (surface.mesh != nullptr) {
    return 3.0 * surface.mesh->vertices.size() * settings.refinement * settings.refinement;
  }
  const std::array<int, 2> divisions = Divisions(surface, settings.refinement);
  double vertices = 1.0;
  for (int i = 0; i < 2; ++i) vertices *= divisions[i] + (surface.periodic[i] ? 0.0 : 3.0);
  return 3.0 * vertices;
}

bool ApplySettings(const StudySettings& settings, Scene* scene, std::string* reason) {
  SurfaceSpec& surface = scene->surface;
  if (surface.mesh == nullptr) {
    const std::array<int, 2> divisions = Divisions(surface, settings.refinement);
    if (settings.refinement < 1.0 && divisions == Divisions(surface, 2.0 * settings.refinement)) {
      *reason = "the scene's divisions cannot be halved that often";
      return false;
    }
    surface.divisions = divisions;
    surface.grading = settings.grading;
  } else if (settings.refinement != 1.0) {
    auto mesh = std::make_shared<TriangleMesh>(*surface.mesh);
    if (CanBeCoarsened(surface)) {
      const int frequency = Frequency(surface, settings.refinement);
      if (settings.refinement < 1.0 && frequency == Frequency(surface, 2.0 * settings.refinement)) {
        *reason = "the scene's frequency cannot be halved that often";
        return false;
      }
      *mesh = MakeSmoothIcosphere(surface.mesh->vertices[0].norm(), frequency);
    } else {
      int exponent = 0;
      if (settings.refinement < 1.0 || std::frexp(settings.refinement, &exponent) != 0.5) {
        *reason = "a mesh is refined by powers of two only";
        return false;
      }
      if (surface.interpolate) {
        LoopMesh loop = MakeLoopMesh(*mesh);
        if (!InterpolatePoints(&loop)) {
          *reason = "no Loop surface passes through the points of the mesh";
          return false;
        }
        for (size_t i = 0; i < mesh->vertices.size(); ++i) mesh->vertices[i] = loop.points.col(i);
        surface.interpolate = false;
      }
      for (int level = 1; level < exponent; ++level) *mesh = SubdivideLoop(*mesh);
    }
    surface.mesh = std::move(mesh);
  }
  scene->model.quadrature = settings.quadrature;
  scene->model.boundary_rule = settings.boundary_rule;
  scene->model.strains = settings.strains;
  scene->model.theory = settings.theory;
  scene->model.minimizer = settings.minimizer;
  return true;
}

std::array<int, 2> DivisionsOf(const Scene& scene, const StudySettings& settings) {
  if (scene.surface.mesh != nullptr) return {0, 0};
  return Divisions(scene.surface, settings.refinement);
}

std::string DescribeRun(const Scene& scene, const StudySettings& settings, Theory theory_used) {
  const SurfaceSpec& surface = scene.surface;
  std::string text;
  if (surface.mesh == nullptr) {
    const std::array<int, 2> divisions = DivisionsOf(scene, settings);
    text = "divisions " + std::to_string(divisions[0]) + " x " + std::to_string(divisions[1]) +
           ", " + GradingText(settings.grading);
  } else if (CanBeCoarsened(surface)) {
    text = "frequency " + std::to_string(Frequency(surface, settings.refinement));
  } else {
    text = "refine +" + Format("%.0f", std::log2(settings.refinement));
  }
  text += ", " + Points(settings.quadrature) + ", " + ToString(settings.strains) + ", " +
          ToString(theory_used);
  if (settings.boundary_rule == BoundaryRule::kSeedGhosts) text += ", seed_ghosts";
  if (settings.minimizer != Minimizer::kAuto) {
    text += std::string(", minimizer ") + ToString(settings.minimizer);
  }
  if (settings.backend != SparseBackend::kAuto)
    text += std::string(", ") + ToString(settings.backend);
  return text;
}

}  // namespace darboux
