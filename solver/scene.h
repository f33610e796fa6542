#ifndef DARBOUX_SOLVER_SCENE_H_
#define DARBOUX_SOLVER_SCENE_H_

#include <array>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "geometry/expression.h"
#include "geometry/grading_map.h"
#include "geometry/hierarchical_mesh.h"
#include "geometry/parametric_surface.h"
#include "geometry/triangle_mesh.h"

namespace darboux {

// What a scene file says (data/README.md lists the keys), checked and with defaults filled in.
// Any consistent unit system. Plain data; ReadScene (solver/scene_reader.h) makes one from YAML.

// Where in a scene file a statement stands, for messages that come up after reading (a probe off
// the surface, a rigid motion that no support removes).
struct SceneLocation {
  std::string file;
  int line = 0;     // 1-based; 0 where the scene was not read from a file.
  std::string key;  // e.g. "loads[2].at.uv"
};

// A number, or a formula of u, v (parametric kinds) and of the rest coordinates x, y, z. The
// variables of `expression` are always u, v, x, y, z in this order.
struct SceneValue {
  Expression expression = Expression::Constant(0.0);
};
// Three of them.
struct SceneVector {
  std::array<SceneValue, 3> component;
};

// surface.refine_near: what lies within `radius` of `center` is refined `levels` times.
struct RefineNearSpec {
  std::array<double, 3> center{};
  double radius = 0.0;
  int levels = 1;
  SceneLocation location;
};

// surface: the middle surface at rest.
struct SurfaceSpec {
  std::string kind;                                  // plane, cylinder, ...
  std::shared_ptr<const ParametricSurface> surface;  // null for kinds that are meshes
  // mesh, icosphere, implicit: control points of a Loop surface, or points that it passes through.
  std::shared_ptr<const TriangleMesh> mesh;
  bool interpolate = false;
  // Where > 0 the mesh stands for a sphere about the origin: the control points, of all levels of
  // local refinement, are those nearest to it (geometry/sphere_fit.h).
  double sphere_radius = 0.0;
  bool is_open = true;  // has a boundary; meshes only
  // Refined locally (geometry/hierarchical_mesh.h), which leaves the rest surface as it is:
  // triangles of `mesh` and their children by their numbers, null: none; and those near points.
  std::shared_ptr<const MeshRefinement> refinement;
  std::vector<RefineNearSpec> refine_near;
  std::vector<std::string> mended;  // what ReadOptions::repair did to the mesh, one line each
  // The others are for parametric kinds only.
  std::array<double, 2> u_range{0.0, 1.0};
  std::array<double, 2> v_range{0.0, 1.0};
  std::array<int, 2> divisions{16, 16};  // cells; each cell is two triangles
  std::array<bool, 2> periodic{false, false};
  std::array<double, 2> grading{0.0, 0.0};  // -1 < g < 1, see data/README.md
  // Instead of `grading` where not the identity: what model.accuracy has chosen.
  std::array<GradingMap, 2> grading_maps;
  bool divisions_given = false, grading_given = false;  // by the scene; else defaults
  SceneLocation location;
};

// shell: what is made of it.
struct ShellSpec {
  double thickness = 0.0;
  double young_modulus = 0.0;
  double poisson_ratio = 0.0;
  double density = 0.0;  // mass per volume; gravity only
  SceneLocation location;
};

// model.minimizer: the mixed iteration, Ceres, conjugate gradients.
enum class Minimizer { kAuto, kMip, kCeres, kCg };
// model.theory: strains linear in the displacements or not.
enum class Theory { kAuto, kLinear, kNonlinear };
// model.strains: frame-indifferent, or the paper's (costs/strain_measures.h).
enum class Strains { kKoiter, kSeed };
// model.boundary_rule: ghost vertices are unknowns, or folded as in the paper.
enum class BoundaryRule { kIndependent, kSeedGhosts };
// What happens to an equilibrium that is no minimum of the energy.
enum class Unstable {
  kReport,  // it is the answer, and said to be unstable
  kLeave    // pushed along its lowest mode, either way, it goes down to a stable one
};

// model: how it is solved.
struct ModelSpec {
  Minimizer minimizer = Minimizer::kAuto;
  Theory theory = Theory::kAuto;
  Strains strains = Strains::kKoiter;
  int quadrature = 3;             // points per triangle: 1, 3, 6, 12
  bool quadrature_given = false;  // by the scene; else the default
  // Points of contact lie this part of a finger's radius apart, where it comes.
  double contact_spacing = 0.3;
  bool contact_spacing_given = false;
  BoundaryRule boundary_rule = BoundaryRule::kIndependent;
  Unstable unstable = Unstable::kReport;
  std::optional<double> accuracy;  // target relative error of the probes
};

// A set of surface points: a side of the parameter rectangle, the whole rim, or a neighbourhood.
struct Region {
  enum class Kind { kUMin, kUMax, kVMin, kVMax, kRim, kNear };
  Kind kind = Kind::kRim;
  std::array<double, 3> center{};  // kNear
  double radius = 0.0;             // kNear; 0 = the one nearest surface point
};

// An entry of supports: what holds the shell.
struct SupportSpec {
  enum class Kind { kFix, kClamped, kSimplySupported, kSymmetry };
  Region on;
  Kind kind = Kind::kFix;
  std::array<bool, 3> fix{false, false, false};  // kFix: components x, y, z
  SceneVector displacement;                      // prescribed values (kFix, kClamped, ...)
  std::array<double, 3> normal{};                // kSymmetry: unit normal of the mirror plane
  SceneLocation location;
};

// A point of the surface, by its parameters or as the one nearest to a point in space.
struct SurfacePoint {
  enum class Kind { kUv, kNearest };
  Kind kind = Kind::kUv;
  std::array<double, 2> uv{};       // kUv
  std::array<double, 3> nearest{};  // kNearest: the surface point nearest to this one
  SceneLocation location;
};

// How the pressure of a gas follows its volume.
enum class GasLaw {
  kIsothermal,  // p V = const
  kAdiabatic,   // p V^1.4 = const
  kIsobaric     // p = const; no scene asks for it, the solver does
};

// An entry of loads; members are for the kinds that are named beside them.
struct LoadSpec {
  enum class Kind {
    kPoint,           // force at a point
    kPressure,        // value per area along n; follows the surface in the nonlinear theory
    kTraction,        // dead force per area
    kNormalTraction,  // dead force per area along the rest normal
    kEdge,            // dead force and moment per length along `on`
    kLine,            // dead force per length along a parameter line
    kGravity,         // acceleration; needs a density
    kGas              // shut in by a closed mesh; the pressure depends on the volume
  };
  Kind kind = Kind::kPoint;
  SurfacePoint at;                       // kPoint
  SceneVector force;                     // kPoint (constant), kTraction, kEdge, kLine
  SceneVector moment;                    // kEdge
  SceneValue value;                      // kPressure, kNormalTraction
  bool follower = true;                  // kPressure
  Region on;                             // kEdge: a side or the rim
  int line_parameter = 0;                // kLine: 0 for u = line_value, 1 for v = line_value
  double line_value = 0.0;               // kLine
  std::array<double, 3> acceleration{};  // kGravity
  double gauge_pressure = 0.0;           // kGas: at the rest volume
  double ambient_pressure = 0.0;         // kGas
  GasLaw law = GasLaw::kIsothermal;      // kGas
  bool prestressed = false;              // kGas: the rest shape bears the gauge pressure
  SceneLocation location;
};

// A rigid finger that closes on the shell.
struct FingerSpec {
  enum class Shape { kPin, kSphere, kCapsule, kBox, kPlane, kMesh };
  std::string name;
  Shape shape = Shape::kSphere;
  double radius = 0.0;                        // kSphere, kCapsule
  double length = 0.0;                        // kCapsule: of its straight part
  std::array<double, 3> half_sizes{};         // kBox
  double rounding = 0.0;                      // kBox: radius of edges and corners
  std::shared_ptr<const TriangleMesh> mesh;   // kMesh
  std::array<double, 3> position{};           // of the shape's centre
  std::array<double, 3> direction{0, 0, -1};  // unit; the way it closes
  std::array<double, 3> axis{};               // unit; kCapsule: of the cylinder, kBox: its local x
  double travel = 0.0;                        // from first touch, at full load
  std::optional<double> force;                // drives it along its direction instead of a travel
  double friction = 0.0;                      // Coulomb's coefficient
  SceneLocation location;
};

// An entry of probes: a point whose displacement is reported.
struct ProbeSpec {
  std::string name;
  SurfacePoint at;
};

// Which quantity leads along the equilibrium path.
enum class PathControl {
  kLoad,          // the load factor, in `steps` equal parts
  kDisplacement,  // a component of a probe, in `steps` equal parts; the load factor follows
  kArcLength      // the path's own length: through limit points and snap-backs to the full load
};

// path: how the loads grow.
struct PathSpec {
  PathControl control = PathControl::kLoad;
  int probe = -1;       // kDisplacement: index in Scene::probes
  int component = 2;    // kDisplacement: 0, 1, 2
  double to = 0.0;      // kDisplacement: its last value
  int max_steps = 500;  // kArcLength
  SceneLocation location;
};

// A statement about the results; the tool's exit status says whether all hold.
struct ExpectSpec {
  std::string quantity;  // path into summary.json, e.g. probes.under_load.displacement.z
  double value = 0.0;
  std::optional<double> relative_tolerance;  // one of the two is given
  std::optional<double> absolute_tolerance;
  std::string source;
  SceneLocation location;
};

// All that a scene says.
struct Scene {
  std::string name;
  SurfaceSpec surface;
  ShellSpec shell;
  ModelSpec model;
  std::vector<SupportSpec> supports;
  std::vector<LoadSpec> loads;
  std::vector<FingerSpec> fingers;
  int steps = 1;
  PathSpec path;
  std::vector<ProbeSpec> probes;
  std::vector<ExpectSpec> expect;
};

const char* ToString(Minimizer minimizer);
const char* ToString(PathControl control);
const char* ToString(Theory theory);
const char* ToString(Strains strains);
const char* ToString(BoundaryRule rule);
const char* ToString(Unstable unstable);
const char* ToString(GasLaw law);
// Null where the scene has none.
const LoadSpec* FindGas(const Scene& scene);

}  // namespace darboux

#endif  // DARBOUX_SOLVER_SCENE_H_
