#ifndef DARBOUX_TESTS_PEER_PROBLEMS_H_
#define DARBOUX_TESTS_PEER_PROBLEMS_H_

#include <array>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "tests/calculix_deck.h"

namespace darboux {

// The shells on which Darboux and CalculiX are compared (tests/peer_benchmark.cc): the same part of
// the same shell for both.

// A displacement, with what it should be.
struct PeerQuantity {
  std::string probe;
  int component;
  int corner_s, corner_t;  // where it is on the patch
  double kirchhoff_love, shearing;
  std::optional<double> published;
};

struct PeerProblem {
  std::string name;
  std::string note;   // where the limits come from
  std::string scene;  // text of a scene, or the name of a file in data/
  std::vector<std::array<int, 2>> divisions;
  std::vector<PeerQuantity> quantities;
  std::vector<std::pair<CalculixElement, std::array<int, 2>>> peers;
  std::function<CalculixMesh(CalculixElement, std::array<int, 2>)> mesh;
  std::function<CalculixDeck(const CalculixMesh&)> deck;
};

std::vector<PeerProblem> MakePeerProblems();

}  // namespace darboux

#endif  // DARBOUX_TESTS_PEER_PROBLEMS_H_
