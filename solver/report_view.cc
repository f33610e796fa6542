#include "solver/report_view.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "solver/contact_pressure.h"
#include "solver/fields.h"
#include "solver/grasp.h"
#include "solver/support_conditions.h"

namespace darboux {
namespace {

using Json = nlohmann::ordered_json;
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

Json Number(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }
Json Numbers(const Eigen::Vector3d& x) { return {Number(x.x()), Number(x.y()), Number(x.z())}; }
Eigen::Vector3d Vector(const std::array<double, 3>& x) { return {x[0], x[1], x[2]}; }

const char* NameOf(FingerSpec::Shape shape) {
  switch (shape) {
    case FingerSpec::Shape::kPin:
      return "pin";
    case FingerSpec::Shape::kSphere:
      return "sphere";
    case FingerSpec::Shape::kCapsule:
      return "capsule";
    case FingerSpec::Shape::kBox:
      return "box";
    case FingerSpec::Shape::kPlane:
      return "plane";
    case FingerSpec::Shape::kMesh:
      return "mesh";
  }
  return "";
}

double DiagonalOf(const Eigen::MatrixXd& points) {
  if (points.cols() == 0) return 0.0;
  return (points.rowwise().maxCoeff() - points.rowwise().minCoeff()).norm();
}

// A field as it grows step by step.
struct Field {
  std::string name, label, dimension;
  std::vector<std::string> components;
  bool is_signed = true;
  Json steps = Json::array();

  Json ToJson() const {
    return {{"name", name},
            {"label", label},
            {"dimension", dimension},
            {"components", components},
            {"signed", is_signed},
            {"steps", steps}};
  }
};

// Fields of one shell in any state.
class FieldWriter {
 public:
  FieldWriter(const ShellProblem& problem, const OutputMesh& mesh, bool has_contact)
      : problem_(problem), mesh_(mesh), has_contact_(has_contact) {
    for (const ElementPoint& at : mesh.points) {
      sites_.push_back(MakeFieldSite(problem.surface(), at));
    }
    fields_ = {
        {"displacement", "displacement", "length", {"x", "y", "z"}, true},
        {"membrane_strain", "membrane strain", "1", {"11", "22", "12"}, true},
        {"bending_strain", "curvature change", "1/length", {"11", "22", "12"}, true},
        {"von_mises", "von Mises stress", "force/length^2", {"top", "bottom"}, false},
        {"energy_density", "energy density", "energy/length^2", {"membrane", "bending"}, false}};
    if (has_contact_) {
      fields_.push_back({"contact_pressure", "contact pressure", "force/length^2", {""}, false});
    }
  }

  Eigen::MatrixXd Rest() const {
    Eigen::MatrixXd rest(3, sites_.size());
    for (size_t i = 0; i < sites_.size(); ++i) rest.col(i) = sites_[i].point.position;
    return rest;
  }

  void AddState(const Eigen::Matrix3Xd& displacements,
                const std::vector<ContactPointReport>* contact,
                ReportArrays* arrays) {
    const Eigen::Index n = static_cast<Eigen::Index>(sites_.size());
    Eigen::MatrixXd displacement(3, n), membrane(3, n), bending(3, n), stress(2, n), energy(2, n);
    for (Eigen::Index i = 0; i < n; ++i) {
      const ShellFields at = EvaluateFields(problem_, displacements, sites_[i]);
      displacement.col(i) = at.displacement;
      membrane.col(i) = at.membrane_strain;
      bending.col(i) = at.bending_strain;
      stress.col(i) << at.von_mises_top, at.von_mises_bottom;
      energy.col(i) << at.membrane_energy_density, at.bending_energy_density;
    }
    const Eigen::MatrixXd* const values[] = {&displacement, &membrane, &bending, &stress, &energy};
    for (size_t f = 0; f < 5; ++f) fields_[f].steps.push_back(arrays->AddQuantised(*values[f]));
    if (!has_contact_) return;
    const std::vector<double> pressure =
        MakeContactPressure(problem_.surface(),
                            mesh_,
                            contact != nullptr ? *contact : std::vector<ContactPointReport>());
    fields_.back().steps.push_back(
        arrays->AddQuantised(Eigen::Map<const Eigen::RowVectorXd>(pressure.data(), n)));
  }

  size_t BytesPerState() const {
    size_t components = 0;
    for (const Field& field : fields_) components += field.components.size();
    return 2 * components * sites_.size();
  }
  const std::vector<Field>& fields() const { return fields_; }

 private:
  const ShellProblem& problem_;
  const OutputMesh& mesh_;
  bool has_contact_;
  std::vector<FieldSite> sites_;
  std::vector<Field> fields_;
};

// Indices of at most `most` >= 1 of `count` states, evenly spread, with the last one.
std::vector<size_t> Spread(size_t count, size_t most) {
  std::vector<size_t> chosen;
  const size_t number = std::min(count, most);
  for (size_t i = 1; i <= number; ++i) chosen.push_back((i * count + number / 2) / number - 1);
  return chosen;
}

Json CloudsToJson(const std::vector<ReportCloud>& clouds, ReportArrays* arrays) {
  Json list = Json::array();
  for (const ReportCloud& cloud : clouds) {
    Eigen::MatrixXd points(3, cloud.points.size());
    for (size_t i = 0; i < cloud.points.size(); ++i) points.col(i) = cloud.points[i];
    const Eigen::Map<const Eigen::RowVectorXd> values(cloud.values.data(), cloud.values.size());
    list.push_back({{"title", cloud.title},
                    {"label", cloud.label},
                    {"points", arrays->AddQuantised(points)},
                    {"values", arrays->AddQuantised(values)}});
  }
  return list;
}

// A finger at first touch, and its travel in each of the steps drawn. Null where it has no shape.
Json FingerToJson(const FingerSpec& spec, double shift, Json travel, ReportArrays* arrays) {
  FingerPose pose;
  std::string ignored;
  if (MakeFinger(spec, &pose, &ignored) == nullptr) return nullptr;
  const Eigen::Vector3d direction = Vector(spec.direction);
  const Eigen::Matrix<double, 3, 3, Eigen::RowMajor> rotation = pose.rotation;
  Json entry = {{"name", spec.name},
                {"shape", NameOf(spec.shape)},
                {"radius", spec.radius},
                {"length", spec.length},
                {"half_sizes", spec.half_sizes},
                {"rounding", spec.rounding},
                {"rotation", std::vector<double>(rotation.data(), rotation.data() + 9)},
                {"position", Numbers(pose.position + shift * direction)},
                {"direction", Numbers(direction)},
                {"travel", std::move(travel)}};
  if (spec.shape == FingerSpec::Shape::kMesh) {
    Eigen::MatrixXd vertices(3, spec.mesh->vertices.size());
    for (size_t i = 0; i < spec.mesh->vertices.size(); ++i) {
      vertices.col(i) = spec.mesh->vertices[i];
    }
    entry["points"] = arrays->AddFloats(vertices);
    entry["indices"] = arrays->AddIndices(spec.mesh->triangles);
  }
  return entry;
}

// Where a state says nothing of the fingers they stay where the one before has them; where none
// says anything there are no fingers.
Json FingersToJson(const Scene& scene,
                   const std::vector<const ReportState*>& states,
                   ReportArrays* arrays) {
  Json list = Json::array();
  for (size_t f = 0; f < scene.fingers.size(); ++f) {
    double shift = 0.0;
    Json travel = {0.0};
    bool known = false;
    for (const ReportState* state : states) {
      if (state->fingers != nullptr && f < state->fingers->size()) {
        const FingerReport& finger = (*state->fingers)[f];
        shift = finger.shift;
        travel.push_back(Number(finger.travel));
        known = true;
      } else {
        travel.push_back(travel.back());
      }
    }
    if (!known) continue;
    Json entry = FingerToJson(scene.fingers[f], shift, std::move(travel), arrays);
    if (!entry.is_null()) list.push_back(std::move(entry));
  }
  return list;
}

}  // namespace

Report MakeReport(const std::string& tool, const std::string& name) {
  Report report;
  report.header = {{"format", 1},
                   {"tool", tool},
                   {"name", name},
                   {"views", Json::array()},
                   {"documents", Json::object()}};
  return report;
}

ReportCloud MakeCloud(const std::string& title,
                      const std::string& label,
                      const std::vector<Eigen::Vector3d>& points,
                      const std::vector<double>& values) {
  ReportCloud cloud;
  cloud.label = label;
  for (const size_t i : Spread(points.size(), kCloudPoints)) {
    cloud.points.push_back(points[i]);
    cloud.values.push_back(values[i]);
  }
  cloud.title = title;
  if (cloud.points.size() < points.size()) {
    cloud.title += ", " + std::to_string(cloud.points.size()) + " of " +
                   std::to_string(points.size()) + " points";
  }
  return cloud;
}

ExtraField CoveredDistance(const std::vector<ExtraField>& scan_fields) {
  ExtraField distance = scan_fields[0];
  for (size_t i = 0; i < distance.values.size(); ++i) {
    if (!(scan_fields[1].values[i] > 0.0)) distance.values[i] = kNaN;
  }
  return distance;
}

std::vector<ReportState> StatesOf(const SolverSummary& summary) {
  std::vector<ReportState> states;
  for (size_t i = 0; i < summary.steps.size(); ++i) {
    const LoadStep& step = summary.steps[i];
    if (!step.displacements.allFinite()) continue;
    ReportState state;
    state.factor = step.factor;
    state.label = "step " + std::to_string(i + 1);
    if (!step.converged) state.label += ", not converged";
    if (step.limit_point) state.label += ", limit point";
    state.displacements = &step.displacements;
    state.fingers = &step.fingers;
    state.contact = &step.contact_points;
    states.push_back(std::move(state));
  }
  return states;
}

void AddShellView(const ReportShape& shape, Report* report) {
  const ShellProblem& problem = *shape.problem;
  const Scene& scene = shape.scene != nullptr ? *shape.scene : problem.scene();
  const OutputMesh mesh = MakeOutputMesh(problem.surface());
  const bool has_contact =
      std::any_of(shape.states.begin(), shape.states.end(), [](const ReportState& state) {
        return state.contact != nullptr && !state.contact->empty();
      });
  FieldWriter writer(problem, mesh, has_contact);
  const Eigen::MatrixXd rest = writer.Rest();
  ReportArrays* const arrays = &report->arrays;

  Json view = {{"title", shape.title},
               {"points", mesh.points.size()},
               {"triangles", mesh.triangles.size()},
               {"size", DiagonalOf(rest)},
               {"thickness", problem.material().thickness},
               {"rest", arrays->AddFloats(rest)},
               {"indices", arrays->AddIndices(mesh.triangles)}};
  std::vector<int> sizes;
  for (size_t i = 0; i < mesh.elements.size(); ++i) {
    if (i == 0 || mesh.elements[i] != mesh.elements[i - 1]) sizes.push_back(0);
    ++sizes.back();
  }
  if (std::any_of(sizes.begin(), sizes.end(), [](int size) { return size != 4; })) {
    view["elements"] = sizes;
  }

  const size_t most = std::max<size_t>(1, kViewBytes / writer.BytesPerState());
  std::vector<const ReportState*> states;
  for (const size_t i : Spread(shape.states.size(), most)) states.push_back(&shape.states[i]);
  view["drawn"] = states.size();
  view["states"] = shape.states.size();
  Json steps = {{{"number", 0}, {"label", "at rest"}, {"factor", 0.0}}};
  writer.AddState(
      Eigen::Matrix3Xd::Zero(3, problem.surface().mesh().num_vertices), nullptr, arrays);
  for (const ReportState* state : states) {
    steps.push_back({{"number", state - shape.states.data() + 1},
                     {"label", state->label},
                     {"factor", Number(state->factor)}});
    writer.AddState(*state->displacements, state->contact, arrays);
  }
  const size_t num_steps = steps.size();
  view["steps"] = std::move(steps);
  Json& fields = view["fields"] = Json::array();
  for (const Field& field : writer.fields()) fields.push_back(field.ToJson());
  for (const ExtraField& extra : shape.distances) {
    std::string label = extra.name;
    std::replace(label.begin(), label.end(), '_', ' ');
    Field field{extra.name, label, "length", {""}, true};
    for (size_t i = 0; i + 1 < num_steps; ++i) field.steps.push_back(nullptr);
    field.steps.push_back(arrays->AddQuantised(
        Eigen::Map<const Eigen::RowVectorXd>(extra.values.data(), extra.values.size())));
    fields.push_back(field.ToJson());
  }
  view["fingers"] = FingersToJson(scene, states, arrays);
  Json& probes = view["probes"] = Json::array();
  for (size_t p = 0; p < scene.probes.size(); ++p) {
    const ElementPoint at = Resolve(scene.probes[p].at, problem.surface());
    // Not in braces, which are a copy of their one element to some compilers and a list to others.
    Json displacement = Json::array();
    displacement.push_back(Numbers(Eigen::Vector3d::Zero()));
    const std::vector<int>& vertices = problem.surface().control_vertices(at.element);
    const Eigen::VectorXd weights = problem.surface().ValueWeights(at);
    for (const ReportState* state : states) {
      Eigen::Vector3d moved = Eigen::Vector3d::Zero();
      for (size_t i = 0; i < vertices.size(); ++i) {
        moved += weights[i] * state->displacements->col(vertices[i]);
      }
      displacement.push_back(Numbers(moved));
    }
    probes.push_back({{"name", scene.probes[p].name},
                      {"position", Numbers(problem.surface().Position(at))},
                      {"displacement", std::move(displacement)}});
  }
  view["clouds"] = CloudsToJson(shape.clouds, arrays);
  report->header["views"].push_back(std::move(view));
}

void AddMeshView(const std::string& title,
                 const TriangleMesh& mesh,
                 const std::vector<PlacedFinger>& fingers,
                 const std::vector<ReportCloud>& clouds,
                 Report* report) {
  ReportArrays* const arrays = &report->arrays;
  Eigen::MatrixXd rest(3, mesh.vertices.size());
  for (size_t i = 0; i < mesh.vertices.size(); ++i) rest.col(i) = mesh.vertices[i];
  double size = DiagonalOf(rest);
  if (mesh.vertices.empty()) {
    for (const ReportCloud& cloud : clouds) {
      Eigen::MatrixXd points(3, cloud.points.size());
      for (size_t i = 0; i < cloud.points.size(); ++i) points.col(i) = cloud.points[i];
      size = std::max(size, DiagonalOf(points));
    }
  }
  Json list = Json::array();
  for (const PlacedFinger& finger : fingers) {
    Json entry = FingerToJson(*finger.spec, finger.shift, {0.0}, arrays);
    if (!entry.is_null()) list.push_back(std::move(entry));
  }
  report->header["views"].push_back(
      {{"title", title},
       {"points", mesh.vertices.size()},
       {"triangles", mesh.triangles.size()},
       {"size", size},
       {"thickness", 0.0},
       {"rest", arrays->AddFloats(rest)},
       {"indices", arrays->AddIndices(mesh.triangles)},
       {"elements", std::vector<int>(mesh.triangles.size(), 1)},
       {"drawn", 0},
       {"states", 0},
       {"steps", {{{"number", 0}, {"label", "as given"}, {"factor", 0.0}}}},
       {"fields", Json::array()},
       {"fingers", std::move(list)},
       {"probes", Json::array()},
       {"clouds", CloudsToJson(clouds, arrays)}});
}

void AddHistory(const Scene& scene, const SolverSummary& summary, Report* report) {
  Json history = Json::array();
  for (size_t i = 0; i < summary.steps.size(); ++i) {
    const LoadStep& step = summary.steps[i];
    Json entry = {{"step", i + 1},
                  {"factor", Number(step.factor)},
                  {"iterations", step.iterations},
                  {"converged", step.converged},
                  {"energy", Number(step.energy)},
                  {"relative_gradient", Number(step.relative_gradient)},
                  {"max_displacement", Number(step.max_displacement)},
                  {"limit_point", step.limit_point}};
    Json& energies = entry["energies"] = Json::object();
    for (int e = 0; e < kNumEffects; ++e) {
      energies[ToString(static_cast<Effect>(e))] = Number(step.energies[e]);
    }
    Json& fingers = entry["fingers"] = Json::object();
    for (const FingerReport& finger : step.fingers) {
      fingers[finger.name] = {{"travel", Number(finger.travel)},
                              {"normal_force", Number(finger.normal_force)},
                              {"contact_area", Number(finger.contact_area)},
                              {"penetration", Number(finger.penetration)}};
    }
    Json& probes = entry["probes"] = Json::object();
    for (size_t p = 0; p < step.probe_displacements.size(); ++p) {
      probes[scene.probes[p].name] = Numbers(step.probe_displacements[p]);
    }
    entry["gas"] = nullptr;
    if (step.gas) {
      entry["gas"] = {{"gauge_pressure", Number(step.gas->gauge_pressure)},
                      {"volume_ratio", Number(step.gas->volume_ratio)}};
    }
    history.push_back(std::move(entry));
  }
  Json& view = report->header["views"].back();
  view["history"] = std::move(history);
  // Columns: paths have thousands of iterations.
  Json& iterations = view["iterations"];
  for (const char* name :
       {"method", "step", "factor", "iteration", "energy", "relative_gradient", "seconds"}) {
    iterations[name] = Json::array();
  }
  for (const IterationReport& iteration : summary.iteration_history) {
    iterations["method"].push_back(ToString(iteration.method));
    iterations["step"].push_back(iteration.step);
    iterations["factor"].push_back(Number(iteration.load_factor));
    iterations["iteration"].push_back(iteration.iteration);
    iterations["energy"].push_back(Number(iteration.energy));
    iterations["relative_gradient"].push_back(Number(iteration.relative_gradient));
    iterations["seconds"].push_back(Number(iteration.seconds));
  }
}

Report MakeSceneReport(const std::string& tool,
                       const ShellProblem& problem,
                       const SolverSummary& solver_summary,
                       const Json& summary) {
  const Scene& scene = problem.scene();
  Report report = MakeReport(tool, scene.name);
  ReportShape shape;
  shape.title = scene.name;
  shape.problem = &problem;
  shape.states = StatesOf(solver_summary);
  AddShellView(shape, &report);
  AddHistory(scene, solver_summary, &report);
  report.header["documents"]["summary"] = summary;
  return report;
}

}  // namespace darboux
