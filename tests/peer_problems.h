#ifndef DARBOUX_TESTS_PEER_PROBLEMS_H_
#define DARBOUX_TESTS_PEER_PROBLEMS_H_

#include <array>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "solver/inp_mesh.h"

namespace darboux {

// The shells on which Darboux and CalculiX are compared (tests/peer_benchmark.cc): the same part of
// the same shell for both.

// A displacement, with what it should be.
struct PeerQuantity {
  std::string probe;
  int component;
  double kirchhoff_love, shearing;
  std::optional<double> published;
};

struct PeerProblem {
  std::string name;
  std::string note;   // where the limits come from
  std::string scene;  // text of a scene, or the name of a file in data/
  std::vector<std::array<int, 2>> divisions;
  std::vector<PeerQuantity> quantities;
  std::vector<std::pair<InpElement, std::array<int, 2>>> peers;
  // CalculiX' own: cells graded otherwise than the scene's; the first and the largest increment.
  std::optional<std::array<double, 2>> peer_grading, increments;
};

std::vector<PeerProblem> MakePeerProblems();

}  // namespace darboux

#endif  // DARBOUX_TESTS_PEER_PROBLEMS_H_
