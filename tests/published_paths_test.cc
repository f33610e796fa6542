// Whole equilibrium paths against the tables of Sze, Liu & Lo (2004), data/reference_paths. Label
// slow.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <limits>
#include <sstream>
#include <string>
#include <vector>

#include "tests/solve_util.h"

namespace darboux {
namespace {

struct Table {
  std::vector<std::string> columns;  // PROBE.COMPONENT
  std::vector<double> factors;
  std::vector<std::vector<double>> values;  // by column
};

Table ReadTable(const std::string& name) {
  Table table;
  std::ifstream file(std::string(DARBOUX_DATA_DIR) + "/reference_paths/" + name + ".csv");
  EXPECT_TRUE(file.good()) << name;
  for (std::string line; std::getline(file, line);) {
    if (line.empty() || line[0] == '#') continue;
    std::vector<std::string> cells;
    std::stringstream stream(line);
    for (std::string cell; std::getline(stream, cell, ',');) cells.push_back(cell);
    if (table.columns.empty()) {
      table.columns.assign(cells.begin() + 1, cells.end());
      table.values.resize(table.columns.size());
      continue;
    }
    if (std::stod(cells[0]) > 1.0) continue;  // Beyond the end of the scene's path.
    table.factors.push_back(std::stod(cells[0]));
    for (size_t i = 1; i < cells.size(); ++i) table.values[i - 1].push_back(std::stod(cells[i]));
  }
  return table;
}

struct Path {
  const char* scene;
  int steps;
  // Of the load at the same displacement or of the displacement at the same load, whichever is
  // nearer, relative to the full load and the largest displacement.
  double tolerance;
  const char* looser_column;  // a column with a tolerance of its own, and why: see below
  double looser_tolerance;
};

class PublishedPathTest : public ::testing::TestWithParam<Path> {};

TEST_P(PublishedPathTest, IsFollowed) {
  const Table table = ReadTable(GetParam().scene);
  Scene scene = SceneFromData(std::string(GetParam().scene) + ".yaml");
  scene.steps = GetParam().steps;
  const Solution solution = SolveScene(scene);
  for (size_t column = 0; column < table.columns.size(); ++column) {
    const std::string& name = table.columns[column];
    const std::string probe = name.substr(0, name.find('.'));
    const int component = name.back() - 'x';
    const auto spec =
        std::find_if(scene.probes.begin(), scene.probes.end(), [&](const ProbeSpec& candidate) {
          return candidate.name == probe;
        });
    ASSERT_NE(spec, scene.probes.end()) << name;
    std::vector<std::pair<double, double>> path = {{0.0, 0.0}};
    for (const LoadStep& step : solution.summary.steps) {
      path.push_back(
          {step.factor, step.probe_displacements[spec - scene.probes.begin()][component]});
    }
    double size = 0.0;
    for (const double value : table.values[column]) size = std::max(size, std::abs(value));
    double worst = 0.0;
    for (size_t row = 0; row < table.factors.size(); ++row) {
      const double factor = table.factors[row], value = table.values[column][row];
      double nearest = std::numeric_limits<double>::infinity();
      for (size_t i = 1; i < path.size(); ++i) {
        const auto [f0, u0] = path[i - 1];
        const auto [f1, u1] = path[i];
        if (u0 != u1 && (u0 - value) * (u1 - value) <= 0.0) {
          nearest = std::min(nearest, std::abs(f0 + (f1 - f0) * (value - u0) / (u1 - u0) - factor));
        }
        if (f0 != f1 && (f0 - factor) * (f1 - factor) <= 0.0) {
          nearest = std::min(nearest,
                             std::abs(u0 + (u1 - u0) * (factor - f0) / (f1 - f0) - value) / size);
        }
      }
      worst = std::max(worst, nearest);
    }
    std::printf("  %-22s %-14s %3zu points, %4d iterations, worst %.4f\n",
                GetParam().scene,
                name.c_str(),
                path.size() - 1,
                solution.summary.iterations,
                worst);
    EXPECT_LE(
        worst,
        name == GetParam().looser_column ? GetParam().looser_tolerance : GetParam().tolerance);
  }
}

INSTANTIATE_TEST_SUITE_P(
    Sze,
    PublishedPathTest,
    ::testing::Values(
        Path{"cantilever_shear", 20, 0.005, "", 0.0},
        Path{"cantilever_moment", 20, 0.005, "", 0.0},
        Path{"slit_annulus", 20, 0.005, "", 0.0},
        Path{"pinched_hemisphere", 20, 0.005, "", 0.0},
        // Under the point force itself the published elements shear, Kirchhoff-Love shells do not.
        Path{"open_cylinder_pullout", 40, 0.01, "under_load.z", 0.02},
        Path{"pinched_semi_cylinder", 20, 0.01, "", 0.0},
        Path{"hinged_roof_h12_7", 40, 0.01, "", 0.0},
        Path{"hinged_roof_h6_35", 40, 0.01, "", 0.0}),
    [](const auto& info) { return std::string(info.param.scene); });

}  // namespace
}  // namespace darboux
