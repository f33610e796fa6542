#include "solver/exports.h"

#include <cstdint>
#include <memory>
#include <utility>

#include "geometry/text_file.h"
#include "solver/field_table.h"
#include "solver/inp_export.h"
#include "solver/npz_writer.h"

namespace darboux {
namespace {

constexpr char kElements[] = "auto | S3 | S4 | S6 | S8R | C3D15 | C3D20R";

std::string Csv(const FieldTable& table, const std::vector<const Field*>& fields) {
  std::string text = "point";
  for (const Field* field : fields) {
    const std::string name = field == &table.points() ? "rest" : field->name;
    if (field->components.empty()) text += "," + name;
    for (const std::string& component : field->components) text += "," + name + "." + component;
  }
  text += "\n";
  for (size_t i = 0; i < table.num_points(); ++i) {
    text += std::to_string(i);
    for (const Field* field : fields) {
      for (size_t k = 0; k < field->width(); ++k) {
        text += ',';
        AppendNumber(field->values[i * field->width() + k], &text);
      }
    }
    text += "\n";
  }
  return text;
}

std::vector<Field> Extra(const FieldTable& table, const std::vector<ExtraField>& extra) {
  std::vector<Field> fields;
  for (const ExtraField& field : extra) {
    fields.emplace_back(field.name, std::vector<std::string>(), table.num_points());
    for (const double value : field.values) fields.back().Add(value);
  }
  return fields;
}

}  // namespace

bool ParseExports(const std::string& list,
                  bool inp_allowed,
                  ExportOptions* options,
                  std::string* error) {
  if (list.empty()) return true;
  for (size_t begin = 0; begin <= list.size();) {
    const size_t end = std::min(list.find(',', begin), list.size());
    const std::string name = list.substr(begin, end - begin);
    bool* const wanted = name == "inp" && inp_allowed ? &options->inp
                         : name == "csv"              ? &options->csv
                         : name == "npz"              ? &options->npz
                                                      : nullptr;
    if (wanted == nullptr || *wanted) {
      *error = "found '" + list + "'; allowed csv | npz" + (inp_allowed ? " | inp" : "") +
               ", joined by commas, each once";
      return false;
    }
    *wanted = true;
    begin = end + 1;
  }
  return true;
}

bool ParseInpElement(const std::string& name, ExportOptions* options, std::string* error) {
  options->inp_element.reset();
  if (name == "auto") return true;
  InpElement element;
  if (!ParseInpElement(name, &element)) {
    *error = "found '" + name + "'; allowed " + kElements;
    return false;
  }
  options->inp_element = element;
  return true;
}

bool CheckExports(const ExportOptions& options, const Scene& scene, std::string* error) {
  if (!options.inp || !options.inp_element || scene.surface.surface != nullptr ||
      !IsQuadrilateral(*options.inp_element)) {
    return true;
  }
  *error = "found " + std::string(ToString(*options.inp_element)) +
           ", which has four corners; allowed on a mesh auto | S3 | S6 | C3D15";
  return false;
}

std::vector<ExportState> ExportStatesOf(const SolverSummary& summary) {
  std::vector<ExportState> states;
  for (const LoadStep& step : summary.steps) {
    states.push_back({step.factor, step.converged, &step.displacements});
  }
  return states;
}

bool MakeFieldExports(const ShellProblem& problem,
                      const ExportOptions& options,
                      const std::vector<ExportState>& states,
                      const std::vector<ExtraField>& extra,
                      std::vector<NamedFile>* files,
                      std::string* error) {
  if (!options.csv && !options.npz) return true;
  const FieldTable table(problem);
  const std::vector<Field> extra_fields = Extra(table, extra);
  const size_t n = table.num_points(), k = states.size();
  std::vector<Field> stacked;  // states one after the other
  std::string last;
  for (size_t i = 0; i < k; ++i) {
    std::vector<Field> fields = table.StateFields(*states[i].displacements);
    if (options.csv) {
      std::vector<const Field*> columns = {&table.points()};
      for (const Field& field : fields) columns.push_back(&field);
      for (const Field& field : table.rest_fields()) columns.push_back(&field);
      if (i + 1 == k) {
        for (const Field& field : extra_fields) columns.push_back(&field);
      }
      std::string number = std::to_string(i + 1);
      if (number.size() < 4) number.insert(0, 4 - number.size(), '0');
      last = Csv(table, columns);
      if (options.numbered) files->push_back({"fields_" + number + ".csv", last});
    }
    if (!options.npz) continue;
    if (i == 0) {
      stacked = std::move(fields);
    } else {
      for (size_t f = 0; f < fields.size(); ++f) {
        stacked[f].values.insert(
            stacked[f].values.end(), fields[f].values.begin(), fields[f].values.end());
      }
    }
  }
  if (options.csv && k > 0) files->push_back({"fields.csv", std::move(last)});
  if (!options.npz) return true;

  NpzWriter npz;
  npz.Add("points", {n, 3}, table.points().values);
  std::vector<std::int32_t> triangles, converged;
  for (const std::array<int, 3>& triangle : table.mesh().triangles) {
    triangles.insert(triangles.end(), triangle.begin(), triangle.end());
  }
  npz.Add("triangles", {triangles.size() / 3, 3}, triangles);
  std::vector<double> factors;
  for (const ExportState& state : states) {
    factors.push_back(state.factor);
    converged.push_back(state.converged ? 1 : 0);
  }
  npz.Add("load_factor", {k}, factors);
  npz.Add("converged", {k}, converged);
  for (const Field& field : stacked) {
    if (field.components.empty()) {
      npz.Add(field.name, {k, n}, field.values);
    } else {
      npz.Add(field.name, {k, n, field.width()}, field.values);
    }
  }
  for (const Field& field : table.rest_fields()) {
    npz.Add(field.name, {n, field.width()}, field.values);
  }
  for (const Field& field : extra_fields) npz.Add(field.name, {n}, field.values);
  std::string archive;
  if (!npz.Finish(&archive, error)) return false;
  files->push_back({"fields.npz", std::move(archive)});
  return true;
}

bool MakeInpExport(const ShellProblem& problem,
                   const ExportOptions& options,
                   const SolverSummary* summary,
                   std::vector<NamedFile>* files,
                   std::vector<std::string>* remarks,
                   std::string* error) {
  if (!options.inp) return true;
  InpOptions inp;
  inp.element = options.inp_element;
  const Scene& scene = problem.scene();
  inp.factors.clear();
  if (scene.path.control == PathControl::kLoad) {
    for (int step = 1; step <= scene.steps; ++step) {
      inp.factors.push_back(static_cast<double>(step) / scene.steps);
    }
  } else if (scene.path.control == PathControl::kDisplacement && summary != nullptr &&
             !summary->steps.empty()) {
    for (const LoadStep& step : summary->steps) inp.factors.push_back(step.factor);
  } else {
    inp.factors = {1.0};
  }
  inp.solved = summary != nullptr && summary->IsConverged();
  InpDeck deck;
  if (!MakeInpDeck(problem, inp, &deck, error)) return false;
  remarks->insert(remarks->end(), deck.remarks.begin(), deck.remarks.end());
  files->push_back({"shell.inp", std::move(deck.text)});
  return true;
}

bool ExportScene(const Scene& scene,
                 const ExportOptions& options,
                 int num_threads,
                 std::vector<NamedFile>* files,
                 std::vector<std::string>* remarks,
                 std::string* error) {
  ShellProblem::Options problem_options;
  problem_options.nonlinear = scene.model.theory != Theory::kLinear;
  problem_options.num_threads = num_threads;
  const std::unique_ptr<ShellProblem> problem = ShellProblem::Create(scene, problem_options, error);
  if (problem == nullptr) return false;
  if (scene.model.theory == Theory::kAuto) {
    remarks->push_back(
        "model.theory: auto: the deck is nonlinear, as nothing was solved that would "
        "tell whether that is needed");
  }
  if (scene.model.accuracy) {
    remarks->push_back(
        "model.accuracy: the deck has the scene's own resolution, as nothing was "
        "solved that would choose one");
  }
  return MakeInpExport(*problem, options, nullptr, files, remarks, error);
}

}  // namespace darboux
