// What was solved: numbers, fields, files.

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <limits>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "geometry/shell_surface.h"
#include "solver/fields.h"
#include "solver/iteration_log.h"
#include "solver/results.h"
#include "tools/python/convert.h"
#include "tools/python/handle.h"
#include "tools/python/module.h"
#include "tools/python/report.h"

namespace py = pybind11;

namespace darboux {
namespace {

using Json = nlohmann::ordered_json;

// Gathers the values of one field at all points.
class Column {
 public:
  Column(const char* name, int components, std::size_t num_points)
      : name_(name), components_(components) {
    values_.reserve(num_points * static_cast<std::size_t>(components));
  }
  void Add(double value) { values_.push_back(value); }
  template <int n>
  void Add(const Eigen::Matrix<double, n, 1>& value) {
    values_.insert(values_.end(), value.data(), value.data() + n);
  }
  void MoveTo(py::dict* fields) const { (*fields)[name_] = ToArray(values_, components_); }

 private:
  const char* name_;
  int components_;
  std::vector<double> values_;
};

// As shell.vtu has them, with the same names.
class FieldColumns {
 public:
  explicit FieldColumns(std::size_t n)
      : columns_{{"displacement", 3, n},
                 {"normal", 3, n},
                 {"membrane_strain", 3, n},
                 {"principal_membrane_strain", 2, n},
                 {"bending_strain", 3, n},
                 {"membrane_force", 3, n},
                 {"moment", 3, n},
                 {"von_mises_top", 1, n},
                 {"von_mises_bottom", 1, n},
                 {"energy_density", 1, n},
                 {"membrane_energy_density", 1, n},
                 {"bending_energy_density", 1, n}} {}
  void Add(const ShellFields& fields) {
    Column* column = columns_.data();
    (column++)->Add(fields.displacement);
    (column++)->Add(fields.normal);
    (column++)->Add(fields.membrane_strain);
    (column++)->Add(fields.principal_membrane_strain);
    (column++)->Add(fields.bending_strain);
    (column++)->Add(fields.membrane_force);
    (column++)->Add(fields.moment);
    (column++)->Add(fields.von_mises_top);
    (column++)->Add(fields.von_mises_bottom);
    (column++)->Add(fields.membrane_energy_density + fields.bending_energy_density);
    (column++)->Add(fields.membrane_energy_density);
    (column++)->Add(fields.bending_energy_density);
  }
  py::dict ToDict() const {
    py::dict fields;
    for (const Column& column : columns_) column.MoveTo(&fields);
    return fields;
  }

 private:
  std::vector<Column> columns_;
};

py::dict Fields(const Solution& self, int step) {
  const LoadStep& state = self.summary.steps[self.StepIndex(step)];
  FieldColumns columns(0);
  {
    const py::gil_scoped_release release;
    for (const FieldSite& site : self.sites()) {
      columns.Add(EvaluateFields(*self.problem, state.displacements, site));
    }
  }
  return columns.ToDict();
}

py::dict RestFields(const Solution& self) {
  Column uv("uv", 2, 0), curvatures("principal_curvatures", 2, 0);
  Column direction("principal_direction_1", 3, 0), points("points", 3, 0);
  {
    const py::gil_scoped_release release;
    for (const FieldSite& site : self.sites()) {
      points.Add(site.point.position);
      uv.Add(site.uv[0]);
      uv.Add(site.uv[1]);
      curvatures.Add(site.principal_curvatures);
      direction.Add(site.principal_direction_1);
    }
  }
  py::dict fields;
  for (const Column* column : {&points, &uv, &curvatures, &direction}) column->MoveTo(&fields);
  fields["triangles"] = ToArray(self.mesh().triangles);
  return fields;
}

// The softest mode at the points of `Fields`, or None.
py::object Mode(const Solution& self, int step) {
  const Eigen::Matrix3Xd& mode = self.summary.steps[self.StepIndex(step)].mode;
  if (mode.size() == 0) return py::none();
  std::vector<Eigen::Vector3d> moved;
  for (const FieldSite& site : self.sites()) {
    const std::vector<int>& vertices = self.problem->surface().control_vertices(site.element);
    Eigen::Vector3d& sum = moved.emplace_back(Eigen::Vector3d::Zero());
    for (std::size_t i = 0; i < vertices.size(); ++i) {
      sum += site.point.weights(kRowValue, static_cast<Eigen::Index>(i)) * mode.col(vertices[i]);
    }
  }
  return ToArray(moved);
}

py::dict FieldsAt(const Solution& self, const py::object& uv, const py::object& nearest, int step) {
  if (uv.is_none() == nearest.is_none()) {
    throw InputError(uv.is_none() ? "at: found neither uv nor nearest; allowed exactly one"
                                  : "at: found uv and nearest; allowed exactly one");
  }
  const ShellSurface& surface = self.problem->surface();
  const LoadStep& state = self.summary.steps[self.StepIndex(step)];
  std::vector<ElementPoint> points;
  if (!uv.is_none()) {
    if (!surface.is_parametric()) {
      throw InputError("uv: found a mesh, which has no parameters; allowed nearest=[[x, y, z]]");
    }
    const ParameterDomain::Options& domain = surface.domain().options();
    for (const std::array<double, 2>& pair : PairsOf(uv, "uv")) {
      for (int k = 0; k < 2; ++k) {
        const std::array<double, 2>& range = k == 0 ? domain.u_range : domain.v_range;
        // Rounding beyond the range is forgiven.
        const double slack = 1e-12 * (range[1] - range[0]);
        if (!domain.periodic[k] && !(pair[k] >= range[0] - slack && pair[k] <= range[1] + slack)) {
          throw InputError(std::string(k == 0 ? "u" : "v") + ": found " + std::to_string(pair[k]) +
                           "; allowed " + std::to_string(range[0]) + " to " +
                           std::to_string(range[1]));
        }
      }
      points.push_back(surface.domain().Locate(pair[0], pair[1]));
    }
  } else {
    const std::vector<Eigen::Vector3d> positions = PointsOf(nearest, "nearest");
    const py::gil_scoped_release release;
    for (const Eigen::Vector3d& x : positions) points.push_back(surface.ClosestPoint(x));
  }
  FieldColumns columns(points.size());
  Column position("position", 3, points.size()), parameters("uv", 2, points.size());
  Column curvatures("principal_curvatures", 2, points.size());
  {
    const py::gil_scoped_release release;
    for (const ElementPoint& at : points) {
      const FieldSite site = MakeFieldSite(surface, at);
      position.Add(site.point.position);
      parameters.Add(site.uv[0]);
      parameters.Add(site.uv[1]);
      curvatures.Add(site.principal_curvatures);
      columns.Add(EvaluateFields(*self.problem, state.displacements, site));
    }
  }
  py::dict fields = columns.ToDict();
  for (const Column* column : {&position, &parameters, &curvatures}) column->MoveTo(&fields);
  return fields;
}

py::dict Contact(const Solution& self, int step) {
  const LoadStep& state = self.summary.steps[self.StepIndex(step)];
  const std::vector<ContactPointReport>& points = state.contact_points;
  const std::size_t n = points.size();
  Column position("position", 3, n), normal("normal", 3, n), gap("gap", 1, n);
  Column pressure("pressure", 1, n), area("area", 1, n), friction("friction", 3, n);
  std::vector<char> sticks;
  py::array_t<int> finger(static_cast<py::ssize_t>(n)), element(static_cast<py::ssize_t>(n));
  for (std::size_t i = 0; i < n; ++i) {
    const ContactPointReport& point = points[i];
    finger.mutable_at(static_cast<py::ssize_t>(i)) = point.finger;
    element.mutable_at(static_cast<py::ssize_t>(i)) = point.element;
    position.Add(point.position);
    normal.Add(point.normal);
    gap.Add(point.gap);
    pressure.Add(point.pressure);
    area.Add(point.area);
    friction.Add(point.friction);
    const FingerSpec& spec = self.problem->scene().fingers[static_cast<std::size_t>(point.finger)];
    sticks.push_back(spec.friction > 0.0 && point.sticks);
  }
  py::dict fields;
  fields["finger"] = finger;
  fields["element"] = element;
  for (const Column* column : {&position, &normal, &gap, &pressure, &area, &friction}) {
    column->MoveTo(&fields);
  }
  fields["sticks"] = ToBools(sticks);
  return fields;
}

// summary.json; of an earlier load step what is known of it.
Json SummaryJson(const Solution& self) {
  const Scene& scene = self.problem->scene();
  Json json = MakeSummaryJson(scene, self.summary, self.accuracy_or_null());
  std::vector<ExpectResult> expectations;
  EvaluateExpectations(scene, json, &expectations);
  json["expect"] = MakeExpectJson(expectations);
  return json;
}

py::object StepSummary(const Solution& self, int step) {
  const std::size_t index = self.StepIndex(step);
  const Scene& scene = self.problem->scene();
  SolverSummary alone;  // As if it were the last one.
  alone.steps.push_back(self.summary.steps[index]);
  const LoadStep& state = alone.steps.back();
  const auto components = [](const Eigen::Vector3d& v) {
    return Json{{"x", v.x()}, {"y", v.y()}, {"z", v.z()}};
  };
  const Json all = MakeSummaryJson(scene, alone, nullptr);
  Json json = all["load_steps"].back();
  for (const char* key : {"fingers", "grasp", "gas", "stability"}) json[key] = all[key];
  Json& energies = json["energies"] = Json::object();
  for (int i = 0; i < kNumEffects; ++i) {
    energies[ToString(static_cast<Effect>(i))] = state.energies[static_cast<std::size_t>(i)];
  }
  Json& probes = json["probes"] = Json::object();
  for (std::size_t i = 0; i < scene.probes.size(); ++i) {
    const Eigen::Vector3d& x = self.summary.probes[i].position;
    probes[scene.probes[i].name] = {{"position", {x.x(), x.y(), x.z()}},
                                    {"displacement", components(state.probe_displacements[i])}};
  }
  json["supports"] = {{"reaction", components(state.reaction)}};
  return ToPython(json);
}

py::dict Iterations(const Solution& self) {
  const std::vector<IterationReport>& history = self.summary.iteration_history;
  const auto n = static_cast<py::ssize_t>(history.size());
  py::array_t<int> step(n), iteration(n), total(n);
  py::array_t<double> load_factor(n), energy(n), gradient(n), seconds(n);
  py::list method;
  for (py::ssize_t i = 0; i < n; ++i) {
    const IterationReport& report = history[static_cast<std::size_t>(i)];
    method.append(ToString(report.method));
    step.mutable_at(i) = report.step;
    iteration.mutable_at(i) = report.iteration;
    total.mutable_at(i) = report.total;
    load_factor.mutable_at(i) = report.load_factor;
    energy.mutable_at(i) = report.energy;
    gradient.mutable_at(i) = report.relative_gradient;
    seconds.mutable_at(i) = report.seconds;
  }
  return py::dict(py::arg("method") = method,
                  py::arg("step") = step,
                  py::arg("load_factor") = load_factor,
                  py::arg("iteration") = iteration,
                  py::arg("total") = total,
                  py::arg("energy") = energy,
                  py::arg("relative_gradient") = gradient,
                  py::arg("seconds") = seconds);
}

std::vector<std::string> Write(const Solution& self, const std::string& folder, bool report) {
  if (report) RequireReportPage();
  MoreFiles more;
  if (report) {
    more = [&self](const Json& json) {
      return std::vector<NamedFile>{
          ReportFile(MakeSceneReport("darboux_deform", *self.problem, self.summary, json))};
    };
  }
  Results results;
  std::string error;
  bool ok = false;
  {
    const py::gil_scoped_release release;
    ok = WriteResults(
        folder, *self.problem, self.summary, self.accuracy_or_null(), &results, &error, more);
  }
  if (ok) return results.files;
  PyErr_SetString(PyExc_OSError, error.c_str());
  throw py::error_already_set();
}

const char* Termination(const Solution& self) {
  switch (self.summary.termination) {
    case SolverSummary::Termination::kNotRun:
      return "not_run";
    case SolverSummary::Termination::kConverged:
      return "converged";
    case SolverSummary::Termination::kNotConverged:
      return "not_converged";
    case SolverSummary::Termination::kTimeLimit:
      return "time_limit";
    case SolverSummary::Termination::kStopped:
      return "stopped";
    case SolverSummary::Termination::kFailed:
      break;
  }
  return "failed";
}

}  // namespace

void BindSolution(py::module_* module) {
  py::class_<Solution, std::shared_ptr<Solution>>(*module, "Solution")
      .def_property_readonly("termination", &Termination)
      .def_property_readonly("message", [](const Solution& self) { return self.summary.message; })
      .def_property_readonly("report",
                             [](const Solution& self) { return self.summary.FullReport(); })
      .def_property_readonly("num_steps",
                             [](const Solution& self) { return self.summary.steps.size(); })
      .def("summary", [](const Solution& self) { return ToPython(SummaryJson(self)); })
      .def("step_summary", &StepSummary, py::arg("step"))
      .def("history_csv",
           [](const Solution& self) { return MakeHistoryCsv(self.problem->scene(), self.summary); })
      .def("iterations", &Iterations)
      .def("fields", &Fields, py::arg("step"))
      .def("rest_fields", &RestFields)
      .def("mode", &Mode, py::arg("step"))
      .def(
          "control_displacements",
          [](const Solution& self, int step) {
            return ToArray(self.summary.steps[self.StepIndex(step)].displacements);
          },
          py::arg("step"))
      .def("at", &FieldsAt, py::arg("uv"), py::arg("nearest"), py::arg("step"))
      .def("contact", &Contact, py::arg("step"))
      .def("write", &Write, py::arg("folder"), py::arg("report"));
}

}  // namespace darboux
