#include "solver/accuracy_results.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <set>
#include <vector>

#include "solver/format.h"
#include "solver/svg_plot.h"

namespace darboux {
namespace {

using Json = nlohmann::ordered_json;

const char* ToString(StudyReference::Kind kind) {
  switch (kind) {
    case StudyReference::Kind::kNone:
      return "none";
    case StudyReference::Kind::kExpect:
      return "expect";
    case StudyReference::Kind::kRichardson:
      return "richardson";
  }
  return "";
}

std::string Quoted(const std::string& text) {
  if (text.find_first_of(",\"\n\r") == std::string::npos) return text;
  std::string result = "\"";
  for (const char c : text) result += c == '"' ? std::string("\"\"") : std::string(1, c);
  return result + "\"";
}

// Components of a displacement below this part of it are zeros, rounded.
constexpr double kNothing = 1e-9;

std::string Full(double value) { return Format("%.17g", value); }
std::string Short(double value) { return Format("%.6g", value); }
// Counts, seconds and megabytes that are not known are -1.
std::string Known(double value) { return value >= 0.0 ? Short(value) : ""; }
Json KnownJson(double value) { return value >= 0.0 ? Json(value) : Json(nullptr); }
Json CountJson(int value) { return value >= 0 ? Json(value) : Json(nullptr); }

// Paths of all values, in the order of the reference and then of the alphabet.
std::vector<std::string> Paths(const Study& study) {
  std::vector<std::string> paths;
  std::set<std::string> seen;
  for (const StudyQuantity& quantity : study.reference.quantities) {
    if (seen.insert(quantity.path).second) paths.push_back(quantity.path);
  }
  std::set<std::string> others;
  for (const StudyRun& run : study.runs) {
    for (const auto& value : run.outcome.values) others.insert(value.first);
  }
  for (const std::string& path : others) {
    if (seen.insert(path).second) paths.push_back(path);
  }
  return paths;
}

std::string ErrorText(const StudyRun& run) {
  if (!run.error) return "-";
  return run.error->IsBelowUncertainty() ? "< " + Format("%.1e", run.error->uncertainty)
                                         : Format("%.2e", run.error->error);
}

Json ToJson(const std::vector<StudyQuantity>& quantities) {
  Json list = Json::array();
  for (const StudyQuantity& quantity : quantities) {
    list.push_back({{"quantity", quantity.path},
                    {"value", quantity.reference},
                    {"scale", quantity.scale},
                    {"uncertainty", quantity.uncertainty},
                    {"source", quantity.source}});
  }
  return list;
}

Json ToJson(const StudyRun& run) {
  const RunOutcome& outcome = run.outcome;
  const StudySettings& settings = run.plan.settings;
  Json json = {{"label", run.label},
               {"status", ToString(outcome.status)},
               {"reason", outcome.reason},
               {"family", run.plan.family},
               {"level", run.plan.level},
               {"refinement", settings.refinement}};
  const bool parametric = run.divisions[0] > 0;
  json["divisions"] = parametric ? Json(run.divisions) : Json(nullptr);
  json["grading"] = parametric ? Json(settings.grading) : Json(nullptr);
  json["quadrature"] = settings.quadrature;
  json["boundary_rule"] = ToString(settings.boundary_rule);
  json["strains"] = ToString(settings.strains);
  json["theory"] = ToString(settings.theory);
  json["theory_used"] = ToString(outcome.theory);
  json["minimizer"] = ToString(settings.minimizer);
  json["backend"] = outcome.backend.empty() ? ToString(settings.backend) : outcome.backend;
  json["other_model"] = run.other_model;
  json["dof"] = CountJson(outcome.dof);
  json["elements"] = CountJson(outcome.elements);
  json["quadrature_points"] = CountJson(outcome.quadrature_points);
  json["iterations"] = CountJson(outcome.iterations);
  json["error"] = run.error ? Json(run.error->error) : Json(nullptr);
  json["below_uncertainty"] = run.error && run.error->IsBelowUncertainty();
  json["values"] = outcome.values;
  json["time_s"] = {{"setup", KnownJson(outcome.setup_s)},
                    {"solve", KnownJson(outcome.solve_s)},
                    {"total", KnownJson(outcome.total_s)},
                    {"cpu", KnownJson(outcome.cpu_s)}};
  json["memory_mb"] = KnownJson(outcome.memory_mb);
  return json;
}

// A front's points by rising x.
SvgSeries FrontOf(const Study& study, bool by_dof) {
  SvgSeries series;
  series.name = "Pareto front";
  series.style = SvgSeries::Style::kBackground;
  std::vector<std::pair<double, double>> points;
  for (const StudyRun& run : study.runs) {
    if (!(by_dof ? run.on_dof_front : run.on_front)) continue;
    points.emplace_back(by_dof ? run.outcome.dof : run.cost_s, run.CountedError());
  }
  std::sort(points.begin(), points.end());
  for (const auto& [x, y] : points) {
    series.x.push_back(x);
    series.y.push_back(100.0 * y);
  }
  return series;
}

}  // namespace

std::string MakeAccuracyCsv(const Study& study) {
  const std::vector<std::string> paths = Paths(study);
  std::string csv =
      "label,status,reason,family,level,refinement,divisions_u,divisions_v,grading_u,grading_v,"
      "quadrature,boundary_rule,strains,theory,theory_used,minimizer,backend,other_model,dof,"
      "elements,quadrature_points,iterations,error,below_uncertainty,uncertainty";
  for (const std::string& path : paths) csv += "," + Quoted(path);
  csv += ",setup_s,solve_s,total_s,cpu_s,memory_mb,on_front\n";
  for (const StudyRun& run : study.runs) {
    const RunOutcome& outcome = run.outcome;
    const StudySettings& settings = run.plan.settings;
    const bool parametric = run.divisions[0] > 0;
    std::vector<std::string> row = {Quoted(run.label),
                                    ToString(outcome.status),
                                    Quoted(outcome.reason),
                                    Quoted(study.families[run.plan.family]),
                                    std::to_string(run.plan.level),
                                    Short(settings.refinement)};
    for (int i = 0; i < 2; ++i) row.push_back(parametric ? std::to_string(run.divisions[i]) : "");
    for (int i = 0; i < 2; ++i) row.push_back(parametric ? Short(settings.grading[i]) : "");
    row.push_back(std::to_string(settings.quadrature));
    row.push_back(ToString(settings.boundary_rule));
    row.push_back(ToString(settings.strains));
    row.push_back(ToString(settings.theory));
    row.push_back(ToString(outcome.theory));
    row.push_back(ToString(settings.minimizer));
    row.push_back(outcome.backend.empty() ? ToString(settings.backend) : Quoted(outcome.backend));
    row.push_back(run.other_model ? "1" : "0");
    for (const int count :
         {outcome.dof, outcome.elements, outcome.quadrature_points, outcome.iterations}) {
      row.push_back(Known(count));
    }
    row.push_back(run.error ? Short(run.error->error) : "");
    row.push_back(run.error ? (run.error->IsBelowUncertainty() ? "1" : "0") : "");
    row.push_back(run.error ? Short(run.error->uncertainty) : "");
    for (const std::string& path : paths) {
      const auto value = outcome.values.find(path);
      row.push_back(value == outcome.values.end() ? "" : Full(value->second));
    }
    for (const double number :
         {outcome.setup_s, outcome.solve_s, outcome.total_s, outcome.cpu_s, outcome.memory_mb}) {
      row.push_back(Known(number));
    }
    row.push_back(run.on_front ? "1" : "0");
    for (size_t i = 0; i < row.size(); ++i) csv += (i == 0 ? "" : ",") + row[i];
    csv += "\n";
  }
  return csv;
}

Json MakeAccuracyJson(const Study& study) {
  Json json = {{"tool", "darboux_accuracy"},
               {"scene", study.name},
               {"established", study.established},
               {"stopped", study.stopped},
               {"clock", study.count_cpu ? "cpu" : "wall"}};
  const StudyReference& reference = study.reference;
  json["reference"] = {{"kind", ToString(reference.kind)},
                       {"method", reference.method},
                       {"uncertainty", reference.uncertainty},
                       {"quantities", ToJson(reference.quantities)}};
  json["richardson"] = nullptr;
  if (study.richardson) {
    Json orders = Json::array();
    for (const std::optional<double>& order : study.richardson->orders) {
      orders.push_back(order ? Json(*order) : Json(nullptr));
    }
    json["richardson"] = {{"family", study.richardson->family},
                          {"uncertainty", study.richardson->uncertainty},
                          {"orders", orders},
                          {"quantities", ToJson(study.richardson->quantities)}};
  }
  json["families"] = study.families;
  Json& runs = json["runs"] = Json::array();
  Json front = Json::array(), dof_front = Json::array();
  for (size_t i = 0; i < study.runs.size(); ++i) {
    runs.push_back(ToJson(study.runs[i]));
    if (study.runs[i].on_front) front.push_back(i);
    if (study.runs[i].on_dof_front) dof_front.push_back(i);
  }
  json["pareto_front"] = {{"seconds", front}, {"dof", dof_front}};
  Json& cheapest = json["cheapest"] = Json::array();
  for (const CheapestRun& entry : study.cheapest) {
    cheapest.push_back({{"target", entry.target},
                        {"run", entry.run >= 0 ? Json(entry.run) : Json(nullptr)},
                        {"text", entry.text}});
  }
  json["notes"] = study.notes;
  return json;
}

std::string MakeAccuracySvg(const Study& study) {
  std::vector<SvgPanel> panels(2);
  panels[0].title = "error against unknowns";
  panels[0].x_label = "degrees of freedom";
  panels[1].title = "error against time";
  panels[1].x_label =
      study.count_cpu ? "seconds of all processors" : "seconds, set-up and solution";
  for (int k = 0; k < 2; ++k) {
    SvgPanel& panel = panels[k];
    panel.y_label = "relative error, %";
    for (size_t family = 0; family < study.families.size(); ++family) {
      SvgSeries series;
      series.name = study.families[family];
      for (const StudyRun& run : study.runs) {
        if (run.plan.family != static_cast<int>(family) || !run.error) continue;
        if (run.other_model && series.name.back() != '*') series.name += " *";
        series.x.push_back(k == 0 ? run.outcome.dof : run.cost_s);
        series.y.push_back(100.0 * run.CountedError());
        series.open.push_back(run.error->IsBelowUncertainty());
      }
      if (!series.x.empty()) panel.series.push_back(std::move(series));
    }
    panel.series.push_back(FrontOf(study, k == 0));
    for (const CheapestRun& entry : study.cheapest) {
      panel.levels.push_back({100.0 * entry.target, Percent(entry.target)});
    }
    if (study.reference.uncertainty > 0.0) {
      panel.levels.push_back({100.0 * study.reference.uncertainty, "reference known to"});
    }
  }
  return MakeSvg("What accuracy costs: " + study.name, panels);
}

std::string RunLine(const StudyRun& run) {
  const RunOutcome& outcome = run.outcome;
  std::string text = run.label;
  text.resize(std::max<size_t>(text.size(), 62), ' ');
  if (outcome.dof >= 0) {
    char numbers[160];
    std::snprintf(numbers,
                  sizeof(numbers),
                  " %7d dof %7d el. %8d pt. %4d it. %10s  %8.3f s + %8.3f s = %8.3f s, cpu %8.3f s",
                  outcome.dof,
                  outcome.elements,
                  outcome.quadrature_points,
                  outcome.iterations,
                  ErrorText(run).c_str(),
                  outcome.setup_s,
                  outcome.solve_s,
                  outcome.total_s,
                  outcome.cpu_s);
    text += numbers;
    if (outcome.memory_mb >= 0.0) text += Format(", %4.0f MB", outcome.memory_mb);
  }
  if (run.other_model) text += " *";
  if (run.on_front) text += " P";
  if (outcome.status != RunOutcome::Status::kConverged) {
    text += std::string("  ") + ToString(outcome.status) + ": " + outcome.reason;
  }
  return text;
}

std::string StudyReport(const Study& study) {
  std::string text = study.name + ": settings; dof, elements, quadrature points, iterations, " +
                     "error, seconds: set-up + solution = total, all threads'; memory\n";
  bool any_other = false;
  std::map<std::string, int> skipped;
  for (const StudyRun& run : study.runs) {
    if (run.outcome.status == RunOutcome::Status::kSkipped) {
      ++skipped[run.outcome.reason];
      continue;
    }
    text += "  " + RunLine(run) + "\n";
    any_other = any_other || (run.other_model && run.error);
  }
  for (const auto& [reason, count] : skipped) {
    text += "  " + std::to_string(count) + (count == 1 ? " run" : " runs") +
            " left out: " + reason + "\n";
  }
  text += "P: on the Pareto front of error and seconds\n";
  if (any_other) {
    text += "*: not the scene's own theory or strains; the error has that of the model in it\n";
  }
  text += "reference: " + study.reference.method + "\n";
  for (const StudyQuantity& quantity : study.reference.quantities) {
    if (std::abs(quantity.reference) <= kNothing * quantity.scale) continue;
    text += "  " + quantity.path + " = " + Format("%.10g", quantity.reference) + ", known to " +
            Percent(quantity.uncertainty) +
            (quantity.source.empty() ? "" : ": " + quantity.source) + "\n";
  }
  for (const std::string& note : study.notes) text += "note: " + note + "\n";
  for (const CheapestRun& entry : study.cheapest) {
    text += "cheapest for " + Percent(entry.target) + ": " + entry.text + "\n";
  }
  return text;
}

bool WriteStudy(const std::string& folder,
                const Study& study,
                std::string* error,
                const std::vector<NamedFile>& more) {
  std::vector<NamedFile> files = {
      {"accuracy.csv", MakeAccuracyCsv(study)},
      {"accuracy.json",
       MakeAccuracyJson(study).dump(2, ' ', false, Json::error_handler_t::replace) + "\n"},
      {"accuracy.svg", MakeAccuracySvg(study)}};
  files.insert(files.end(), more.begin(), more.end());
  return WriteFiles(folder, files, error);
}

}  // namespace darboux
