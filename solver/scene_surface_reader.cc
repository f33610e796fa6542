#include "solver/scene_surface_reader.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <filesystem>
#include <memory>
#include <optional>
#include <utility>

#include "geometry/icosphere.h"
#include "geometry/implicit_mesh.h"
#include "geometry/loop_mesh.h"
#include "geometry/mesh_doctor.h"
#include "geometry/mesh_io.h"
#include "geometry/mesh_repair.h"
#include "geometry/mesh_topology.h"
#include "geometry/nearest_name.h"

namespace darboux {
namespace {

constexpr int kMaxVertices = 10000000;
// Points this far outside a range, relative to its length, are rounding and moved to its end.
constexpr double kRangeRounding = 1e-9;

const NumberRule kGrading{"a number in (-1, 1)", [](double x) { return x > -1.0 && x < 1.0; }};

// In the order of messages; the last ones are meshes.
const KindKeys& SurfaceKeys() {
  static const KindKeys& keys =
      *new KindKeys{{"plane", {}},
                    {"cylinder", {"radius"}},
                    {"sphere", {"radius"}},
                    {"ellipsoid", {"semi_axes"}},
                    {"torus", {"radii"}},
                    {"monkey_saddle", {"scale"}},
                    {"expression", {"position"}},
                    {"implicit", {"function", "bounds", "edge_length", "open"}},
                    {"mesh", {"file"}},
                    {"icosphere", {"radius", "frequency"}}};
  return keys;
}

// Kinds that are meshes have no parameters.
bool IsMeshKind(const std::string& kind) {
  return kind == "implicit" || kind == "mesh" || kind == "icosphere";
}

// "x = 0.5, y = 1, z = 0"
std::string FormatPoint(const Eigen::Vector3d& x) {
  return "x = " + FormatShort(x[0]) + ", y = " + FormatShort(x[1]) + ", z = " + FormatShort(x[2]);
}

constexpr int kMaxFrequency = 400;
constexpr int kMaxRefine = 6;
constexpr int kMaxRefineNear = 10;
constexpr std::size_t kMaxMessage = 1000;

const char* const kSideNames[] = {"u_min", "u_max", "v_min", "v_max", "rim"};
const char* const kParameterNames[] = {"u", "v"};

}  // namespace

std::string DivisionsAllowed(const std::array<int, 2>& divisions,
                             const std::array<bool, 2>& periodic) {
  for (int i = 0; i < 2; ++i) {
    const int least = periodic[i] ? 4 : 1;
    if (divisions[i] < least) {
      return "an integer >= " + std::to_string(least) + " for " + (i == 0 ? "u" : "v") +
             (periodic[i] ? ", which is periodic" : "");
    }
  }
  const double vertices = (divisions[0] + 1.0) * (divisions[1] + 1.0);
  if (vertices > kMaxVertices) return "at most " + std::to_string(kMaxVertices) + " vertices";
  return "";
}

bool SurfaceReader::ReadSurface(const YamlField& field) {
  const Names kinds = Kinds(SurfaceKeys());
  YamlMap map;
  YamlField kind;
  surface_.location = Location(field);
  if (!OpenMap(field, "a map with the key kind", &map) ||
      !Require(map, "kind", Join(kinds), &kind) || !ReadChoice(kind, kinds, {}, &surface_.kind)) {
    return false;
  }
  if (IsMeshKind(surface_.kind)) {
    return CheckKindKeys(
               map, SurfaceKeys(), {"kind", "fit", "refine", "refine_near"}, surface_.kind) &&
           ReadMeshSurface(map);
  }
  return CheckKindKeys(map,
                       SurfaceKeys(),
                       {"kind", "u", "v", "divisions", "periodic", "grading"},
                       surface_.kind) &&
         ReadShape(map) && ReadGrid(map) && CheckSurface(map);
}

bool SurfaceReader::ReadShape(const YamlMap& map) {
  const std::string& kind = surface_.kind;
  std::shared_ptr<const ParametricSurface>& surface = surface_.surface;
  if (kind == "plane") {
    surface = MakePlane();
  } else if (kind == "cylinder" || kind == "sphere") {
    double radius;
    if (!RequireNumber(map, "radius", kPositiveNumber, &radius)) return false;
    surface = kind == "cylinder" ? MakeCylinder(radius) : MakeSphere(radius);
  } else if (kind == "ellipsoid") {
    constexpr char kAllowed[] = "a list of three numbers > 0, [a, b, c]";
    YamlField field;
    double axes[3];
    if (!Require(map, "semi_axes", kAllowed, &field) ||
        !ReadNumbers(field, 3, kAllowed, kPositiveNumber, axes)) {
      return false;
    }
    surface = MakeEllipsoid(axes[0], axes[1], axes[2]);
  } else if (kind == "torus") {
    constexpr char kAllowed[] = "a list of two numbers, [R, r] with R > r > 0";
    YamlField field;
    double radii[2];
    if (!Require(map, "radii", kAllowed, &field) ||
        !ReadNumbers(field, 2, kAllowed, kPositiveNumber, radii)) {
      return false;
    }
    if (radii[1] >= radii[0]) {
      return Fail(
          field, "R = " + FormatNumber(radii[0]) + ", r = " + FormatNumber(radii[1]), kAllowed);
    }
    surface = MakeTorus(radii[0], radii[1]);
  } else if (kind == "monkey_saddle") {
    double scale;
    if (!RequireNumber(map, "scale", kAnyNumber, &scale)) return false;
    surface = MakeMonkeySaddle(scale);
  } else {
    constexpr char kAllowed[] = "a list of three expressions of u and v, [x, y, z]";
    YamlField field;
    std::vector<YamlField> items;
    if (!Require(map, "position", kAllowed, &field) || !OpenList(field, 3, kAllowed, &items)) {
      return false;
    }
    std::array<std::string, 3> position;
    std::string mistake;
    for (int i = 0; i < 3; ++i) {
      // Parsed once more below; here each mistake has its own line and key.
      if (!ReadScalar(items[i], "an expression of u and v", &position[i])) return false;
      if (!Expression::Parse(position[i], {"u", "v"}, &mistake)) {
        return Fail(items[i],
                    Describe(items[i]) + " (" + Clean(mistake, 300) + ")",
                    "an expression of u and v");
      }
    }
    surface = MakeExpressionSurface(position, &mistake);
    if (surface == nullptr) return Fail(field, Clean(mistake, 300), kAllowed);
  }
  return true;
}

bool SurfaceReader::ReadMeshSurface(const YamlMap& map) {
  const std::string& kind = surface_.kind;
  surface_.interpolate = kind != "mesh";
  if (const YamlField* fit = map.Find("fit")) {
    std::string text;
    if (!ReadChoice(*fit, {"control", "interpolate"}, {}, &text)) return false;
    surface_.interpolate = text == "interpolate";
  }
  int levels = 0;
  const YamlField* const refine = map.Find("refine");
  if (refine != nullptr) {
    const std::string allowed = "an integer from 0 to " + std::to_string(kMaxRefine);
    if (!ReadInteger(*refine, allowed, &levels)) return false;
    if (levels < 0 || levels > kMaxRefine) return Fail(*refine, Describe(*refine), allowed);
  }
  const YamlField* const near = map.Find("refine_near");
  if (near != nullptr && !ReadRefineNear(*near)) return false;
  auto mesh = std::make_shared<TriangleMesh>();
  const bool is_read = kind == "mesh"       ? ReadMeshFile(map, mesh.get())
                       : kind == "implicit" ? ReadImplicit(map, mesh.get())
                                            : ReadIcosphere(map, mesh.get());
  if (!is_read || (levels > 0 && !Refine(*refine, levels, mesh.get()))) return false;
  surface_.is_open = !BoundaryLoops(*mesh).empty();
  for (const Eigen::Vector3d& x : mesh->vertices) samples_.push_back({0.0, 0.0, x});
  surface_.mesh = std::move(mesh);
  return true;
}

std::string SurfaceReader::Resolve(const std::string& file) const {
  return (std::filesystem::path(folder_) / file).string();
}

std::string SurfaceReader::NameOf(const std::string& file) const {
  return FindNamed(options_.data, &NamedData::meshes, file) != nullptr ? file : Resolve(file);
}

bool SurfaceReader::ReadNamedMesh(const std::string& name,
                                  TriangleMesh* mesh,
                                  std::string* error) const {
  const TriangleMesh* const found = FindNamed(options_.data, &NamedData::meshes, name);
  if (found == nullptr) return ReadMesh(Resolve(name), mesh, error);
  *mesh = *found;
  return true;
}

bool SurfaceReader::ReadMeshFile(const YamlMap& map, TriangleMesh* mesh) {
  constexpr char kAllowed[] = "the name of an .obj, .ply, .stl or .off file";
  YamlField field;
  std::string name, error;
  if (!Require(map, "file", kAllowed, &field) || !ReadText(field, kAllowed, &name)) return false;
  const std::string file = NameOf(name);
  if (!ReadNamedMesh(name, mesh, &error)) return FailWith(field, Clean(error, kMaxMessage));
  const auto fail = [&](const std::string& found, const std::string& allowed) {
    return FailWith(field,
                    "found " + Clean(file, kMaxMessage) + ": " + found + "; allowed is " + allowed);
  };
  if (mesh->vertices.size() > static_cast<std::size_t>(kMaxVertices)) {
    return fail(std::to_string(mesh->vertices.size()) + " vertices",
                "a mesh of at most " + std::to_string(kMaxVertices) + " vertices");
  }
  const MeshDoctorOptions doctor_options;  // One piece, open or closed.
  std::vector<MeshDefect> defects;
  if (options_.repair) {
    MeshReport report = RepairMesh(mesh, doctor_options);
    for (const std::string& line : report.mended) {
      surface_.mended.push_back("mended " + Clean(file, kMaxMessage) + ": " + line);
    }
    defects = std::move(report.defects);
  } else {
    defects = FindMeshDefects(*mesh, doctor_options);
  }
  if (defects.empty()) return true;
  std::string found = defects[0].text;
  if (defects.size() > 1) {
    found += "; and " + std::to_string(defects.size() - 1) + " more " +
             (defects.size() == 2 ? "defect" : "defects");
  }
  return fail(found,
              std::string("a mesh without defects; ") +
                  (options_.repair ? "--repair mends no more" : "--repair mends some of them"));
}

bool SurfaceReader::ReadImplicit(const YamlMap& map, TriangleMesh* mesh) {
  constexpr char kFunctionAllowed[] = "an expression of x, y and z";
  constexpr char kBoundsAllowed[] = "a list of three ranges, [[x0, x1], [y0, y1], [z0, z1]]";
  constexpr char kRangeAllowed[] = "a list of two ascending numbers, [lower, upper]";
  YamlField function_field, bounds_field, edge_field;
  std::string text, mistake;
  if (!Require(map, "function", kFunctionAllowed, &function_field) ||
      !ReadScalar(function_field, kFunctionAllowed, &text)) {
    return false;
  }
  const std::optional<Expression> function = Expression::Parse(text, {"x", "y", "z"}, &mistake);
  if (!function) {
    return Fail(function_field,
                Describe(function_field) + " (" + Clean(mistake, 300) + ")",
                kFunctionAllowed);
  }
  std::vector<YamlField> ranges;
  if (!Require(map, "bounds", kBoundsAllowed, &bounds_field) ||
      !OpenList(bounds_field, 3, kBoundsAllowed, &ranges)) {
    return false;
  }
  Eigen::AlignedBox3d bounds;
  for (int i = 0; i < 3; ++i) {
    std::array<double, 2> range;
    if (!ReadNumbers(ranges[i], 2, kRangeAllowed, kAnyNumber, range.data())) return false;
    if (range[0] >= range[1]) return Fail(ranges[i], FormatRange(range), kRangeAllowed);
    bounds.min()[i] = range[0];
    bounds.max()[i] = range[1];
  }
  double edge_length;
  if (!Require(map, "edge_length", kPositiveNumber.allowed, &edge_field) ||
      !ReadNumber(edge_field, kPositiveNumber, &edge_length)) {
    return false;
  }
  ImplicitMeshOptions options;
  const YamlField* const open = map.Find("open");
  if (open != nullptr && !ReadBool(*open, &options.allow_boundary)) return false;

  if (!MeshImplicitSurface(*function, bounds, edge_length, options, mesh, &mistake)) {
    // The key that the message is about.
    const bool leaves_bounds = mistake.find("the surface leaves the bounds") == 0;
    const YamlField& at = mistake.find("edge length") == 0                   ? edge_field
                          : mistake.find("the bounds") == 0 || leaves_bounds ? bounds_field
                                                                             : function_field;
    return FailWith(
        at, Clean(mistake, kMaxMessage) + (leaves_bounds ? ", or open: true to cut it there" : ""));
  }
  const std::vector<MeshDefect> defects = FindMeshDefects(*mesh, MeshDoctorOptions());
  if (defects.empty()) return true;
  return Fail(edge_field,
              "a mesh with " + defects[0].text,
              "a smaller edge length, or other bounds where they cut the surface");
}

bool SurfaceReader::ReadIcosphere(const YamlMap& map, TriangleMesh* mesh) {
  const std::string allowed = "an integer from 1 to " + std::to_string(kMaxFrequency);
  double radius;
  int frequency;
  YamlField field;
  if (!RequireNumber(map, "radius", kPositiveNumber, &radius) ||
      !Require(map, "frequency", allowed, &field) || !ReadInteger(field, allowed, &frequency)) {
    return false;
  }
  if (frequency < 1 || frequency > kMaxFrequency) return Fail(field, Describe(field), allowed);
  *mesh = MakeSmoothIcosphere(radius, frequency);
  return true;
}

// The same limit surface, but for boundaries (see SubdivideLoop), with more control points.
bool SurfaceReader::Refine(const YamlField& field, int levels, TriangleMesh* mesh) {
  double vertices = static_cast<double>(mesh->vertices.size());
  double edges = static_cast<double>(EdgeTable(mesh->triangles).edges().size());
  double triangles = static_cast<double>(mesh->triangles.size());
  for (int i = 0; i < levels; ++i) {
    vertices += edges;
    edges = 2.0 * edges + 3.0 * triangles;
    triangles *= 4.0;
  }
  if (vertices > kMaxVertices) {
    return Fail(field,
                std::to_string(levels) + ", which makes " + FormatNumber(vertices) + " vertices",
                "at most " + std::to_string(kMaxVertices) + " vertices");
  }
  if (surface_.interpolate) {
    LoopMesh loop = MakeLoopMesh(*mesh);
    if (!InterpolatePoints(&loop)) {
      return Fail(field, "points that no Loop surface passes through", "fit: control");
    }
    for (std::size_t i = 0; i < mesh->vertices.size(); ++i) mesh->vertices[i] = loop.points.col(i);
    surface_.interpolate = false;
  }
  for (int i = 0; i < levels; ++i) *mesh = SubdivideLoop(*mesh);
  return true;
}

bool SurfaceReader::ReadRefineNear(const YamlField& field) {
  constexpr char kAllowed[] = "a list of {near: [x, y, z], radius: r, levels: n}";
  const std::string levels_allowed = "an integer from 1 to " + std::to_string(kMaxRefineNear);
  std::vector<YamlField> items;
  if (!OpenList(field, -1, kAllowed, &items)) return false;
  for (const YamlField& item : items) {
    RefineNearSpec spec;
    YamlMap map;
    YamlField near, levels;
    spec.location = Location(item);
    if (!OpenMap(item, "{near: [x, y, z], radius: r, levels: n}", &map) ||
        !CheckKeys(map, {"near", "radius", "levels"}) ||
        !Require(map, "near", kVectorAllowed, &near) ||
        !ReadNumbers(near, 3, kVectorAllowed, kAnyNumber, spec.center.data()) ||
        !RequireNumber(map, "radius", kNotNegativeNumber, &spec.radius) ||
        !Require(map, "levels", levels_allowed, &levels) ||
        !ReadInteger(levels, levels_allowed, &spec.levels)) {
      return false;
    }
    if (spec.levels < 1 || spec.levels > kMaxRefineNear) {
      return Fail(levels, Describe(levels), levels_allowed);
    }
    surface_.refine_near.push_back(std::move(spec));
  }
  return true;
}

bool SurfaceReader::ReadGrid(const YamlMap& map) {
  SurfaceSpec& spec = surface_;
  for (int i = 0; i < 2; ++i) {
    constexpr char kAllowed[] = "a list of two ascending numbers, [lower, upper]";
    std::array<double, 2>& range = i == 0 ? spec.u_range : spec.v_range;
    YamlField field;
    if (!Require(map, kParameterNames[i], kAllowed, &field) ||
        !ReadNumbers(field, 2, kAllowed, kAnyNumber, range.data())) {
      return false;
    }
    const double length = range[1] - range[0];
    const double rounding = 1e-12 * std::max(std::abs(range[0]), std::abs(range[1]));
    if (!(length > rounding) || !std::isfinite(length)) {
      return Fail(field, FormatRange(range), kAllowed);
    }
  }

  YamlField divisions;
  std::vector<YamlField> items;
  constexpr char kDivisionsAllowed[] = "a list of two integers > 0, [cells along u, along v]";
  if (!Require(map, "divisions", kDivisionsAllowed, &divisions) ||
      !OpenList(divisions, 2, kDivisionsAllowed, &items) ||
      !ReadInteger(items[0], "an integer > 0", &spec.divisions[0]) ||
      !ReadInteger(items[1], "an integer > 0", &spec.divisions[1])) {
    return false;
  }

  if (const YamlField* periodic = map.Find("periodic")) {
    if (!OpenList(*periodic, 2, "a list of two of true | false, [u, v]", &items) ||
        !ReadBool(items[0], &spec.periodic[0]) || !ReadBool(items[1], &spec.periodic[1])) {
      return false;
    }
  }
  const std::string allowed = DivisionsAllowed(spec.divisions, spec.periodic);
  if (!allowed.empty()) {
    return Fail(
        divisions,
        "[" + std::to_string(spec.divisions[0]) + ", " + std::to_string(spec.divisions[1]) + "]",
        allowed);
  }

  spec.divisions_given = true;
  if (const YamlField* grading = map.Find("grading")) {
    spec.grading_given = true;
    if (!ReadNumbers(*grading,
                     2,
                     "a list of two numbers in (-1, 1), [u, v]",
                     kGrading,
                     spec.grading.data()) ||
        !OpenList(*grading, 2, "", &items)) {
      return false;
    }
    for (int i = 0; i < 2; ++i) {
      if (spec.periodic[i] && spec.grading[i] != 0.0) {
        return Fail(items[i],
                    Describe(items[i]),
                    std::string("0, because ") + kParameterNames[i] + " is periodic");
      }
    }
  }
  return true;
}

bool SurfaceReader::CheckSurface(const YamlMap& map) {
  const SurfaceSpec& spec = surface_;
  SurfaceCheck check(spec);
  const YamlField& shape = *map.Find(spec.kind == "expression" ? "position" : "kind");
  double u, v;
  if (!check.IsFinite(&u, &v)) {
    return Fail(
        shape,
        "a surface that is not finite or not twice differentiable at " + FormatParameters(u, v),
        "a smooth surface over the whole range of u and v");
  }
  if (spec.kind == "expression" && !check.IsSmooth(&u, &v)) {
    return Fail(shape,
                "a jump or a kink at " + FormatParameters(u, v),
                "a smooth surface over the whole range of u and v");
  }
  if (!check.IsRegular(&u, &v)) {
    const std::string where = "sigma_u x sigma_v = 0 at " + FormatParameters(u, v);
    for (int i = 1; i >= 0; --i) {
      const std::string name = kParameterNames[i];
      const std::array<double, 2>& range = Range(i);
      const bool pole[2] = {check.IsPole(i, 0), check.IsPole(i, 1)};
      if (!pole[0] && !pole[1]) continue;
      const double margin = 0.05 * (range[1] - range[0]);
      return Fail(*map.Find(name),
                  FormatRange(range) + ", which ends in a pole (" + where + ")",
                  "a smaller range that leaves a hole around the pole, e.g. [" +
                      FormatShort(range[0] + (pole[0] ? margin : 0.0)) + ", " +
                      FormatShort(range[1] - (pole[1] ? margin : 0.0)) + "]");
    }
    // Among the named kinds only those with poles in v come here.
    return Fail(spec.kind == "expression" ? shape : *map.Find("v"),
                "a point without tangent plane (" + where + ")",
                "a surface and ranges of u and v with sigma_u x sigma_v != 0 at every point");
  }
  for (int i = 0; i < 2; ++i) {
    std::string difference;
    if (!spec.periodic[i] || check.IsPeriodic(i, &difference)) continue;
    std::vector<YamlField> items;
    OpenList(*map.Find("periodic"), 2, "", &items);
    return Fail(items[i],
                "true, but " + difference,
                "true only where position and first derivatives agree at both ends, i.e. a range "
                "of one whole period");
  }
  samples_ = check.samples();
  return true;
}

bool SurfaceReader::ReadValue(const YamlField& field,
                              const std::vector<SurfaceSample>& where,
                              SceneValue* value) {
  std::string text;
  if (!ReadScalar(field, kValueAllowed, &text)) return false;
  double number;
  const NumberSyntax syntax = ParseNumber(text, &number);
  if (syntax == NumberSyntax::kNonFinite) {
    return Fail(field, Describe(field) + ", which is not finite", kValueAllowed);
  }
  if (syntax == NumberSyntax::kNumber) {
    value->expression = Expression::Constant(number);
    return true;
  }
  std::string mistake;
  const std::optional<Expression> expression =
      Expression::Parse(text, {"u", "v", "x", "y", "z"}, &mistake);
  if (!expression) {
    return Fail(field, Describe(field) + " (" + Clean(mistake, 300) + ")", kValueAllowed);
  }
  if (surface_.mesh != nullptr && (expression->DependsOn(0) || expression->DependsOn(1))) {
    return Fail(field,
                Describe(field) + ", which names u or v",
                "a number or an expression of x, y, z, as surfaces of kind " + surface_.kind +
                    " have no parameters");
  }
  value->expression = *expression;
  if (expression->IsConstant()) {
    const double zeros[5] = {};
    if (std::isfinite(expression->Evaluate(zeros))) return true;
    return Fail(field, Describe(field) + ", which is not finite", kValueAllowed);
  }
  if (const SurfaceSample* at = FirstNonFinite(*expression, where)) {
    return Fail(
        field,
        Describe(field) + ", which is not finite at " +
            (surface_.mesh != nullptr ? FormatPoint(at->x) : FormatParameters(at->u, at->v)),
        "an expression that is finite wherever it acts");
  }
  return true;
}

bool SurfaceReader::ReadVector(const YamlField& field,
                               const std::vector<SurfaceSample>& where,
                               SceneVector* value) {
  std::vector<YamlField> items;
  if (!OpenList(field, 3, "a list of three numbers or expressions, [x, y, z]", &items)) {
    return false;
  }
  for (int i = 0; i < 3; ++i) {
    if (!ReadValue(items[i], where, &value->component[i])) return false;
  }
  return true;
}

bool SurfaceReader::ReadParameter(const YamlField& field, int parameter, double* value) {
  if (!ReadNumber(field, kAnyNumber, value)) return false;
  if (surface_.mesh != nullptr) {
    return Fail(field,
                std::string("the parameter ") + kParameterNames[parameter],
                "{nearest: [x, y, z]}, as surfaces of kind " + surface_.kind +
                    " have no parameters u and v");
  }
  const std::array<double, 2>& range = Range(parameter);
  const double rounding = kRangeRounding * (range[1] - range[0]);
  if (*value < range[0] - rounding || *value > range[1] + rounding) {
    return Fail(field,
                Describe(field),
                std::string(kParameterNames[parameter]) + " in " + FormatRange(range));
  }
  *value = std::clamp(*value, range[0], range[1]);
  return true;
}

bool SurfaceReader::ReadRegion(const YamlField& field, bool near_allowed, Region* region) {
  Names sides;
  for (int i = 0; i < 5; ++i) {
    if (HasSide(surface_, i)) sides.push_back(kSideNames[i]);
  }
  Names allowed = sides;
  if (near_allowed) allowed.push_back("{near: [x, y, z], radius: r}");
  if (near_allowed && field.node.IsMap()) {
    YamlMap map;
    YamlField near;
    region->kind = Region::Kind::kNear;
    return OpenMap(field, Join(allowed), &map) && CheckKeys(map, {"near", "radius"}) &&
           Require(map, "near", kVectorAllowed, &near) &&
           ReadNumbers(near, 3, kVectorAllowed, kAnyNumber, region->center.data()) &&
           RequireNumber(map, "radius", kNotNegativeNumber, &region->radius);
  }
  const std::string allowed_text =
      allowed.empty() ? "no edge, as the surface is closed" : Join(allowed);
  std::string text;
  if (!ReadScalar(field, allowed_text, &text)) return false;
  for (int i = 0; i < 5; ++i) {
    if (text != kSideNames[i]) continue;
    region->kind = static_cast<Region::Kind>(i);
    if (HasSide(surface_, i)) return true;
    if (surface_.mesh != nullptr) {
      return Fail(field,
                  Quote(text) + ", which " +
                      (i == 4 ? "a closed surface does not have"
                              : "surfaces of kind " + surface_.kind + " do not have"),
                  allowed_text);
    }
    const std::string why = i == 4 ? "u and v are" : std::string(kParameterNames[i / 2]) + " is";
    return Fail(
        field, Quote(text) + ", which does not exist because " + why + " periodic", allowed_text);
  }
  return Fail(field, Describe(field), allowed_text, NearestName(text, sides));
}

bool SurfaceReader::ReadPoint(const YamlField& field, SurfacePoint* point) {
  constexpr char kAllowed[] = "{uv: [u, v]} | {nearest: [x, y, z]}";
  YamlMap map;
  if (!OpenMap(field, kAllowed, &map) || !CheckKeys(map, {"uv", "nearest"})) return false;
  const YamlField* const uv = map.Find("uv");
  const YamlField* const nearest = map.Find("nearest");
  if ((uv != nullptr) == (nearest != nullptr)) {
    return Fail(field, uv != nullptr ? "uv and nearest" : "an empty map", kAllowed);
  }
  point->location = Location(uv != nullptr ? *uv : *nearest);
  if (nearest != nullptr) {
    point->kind = SurfacePoint::Kind::kNearest;
    return ReadNumbers(*nearest, 3, kVectorAllowed, kAnyNumber, point->nearest.data());
  }
  point->kind = SurfacePoint::Kind::kUv;
  std::vector<YamlField> items;
  return OpenList(*uv, 2, "a list of two numbers, [u, v]", &items) &&
         ReadParameter(items[0], 0, &point->uv[0]) && ReadParameter(items[1], 1, &point->uv[1]);
}

}  // namespace darboux
