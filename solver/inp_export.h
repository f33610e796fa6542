#ifndef DARBOUX_SOLVER_INP_EXPORT_H_
#define DARBOUX_SOLVER_INP_EXPORT_H_

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "solver/inp_mesh.h"
#include "solver/shell_problem.h"

namespace darboux {

// A scene as an input deck (.inp) of CalculiX CrunchiX 2.20, in the keywords that it shares with
// Abaqus; what differs there is said in the deck's header. Facts about CalculiX are from its user's
// manual: shells are expanded to solid elements of the same order (S8R to C3D20R, S6 to C3D15), a
// held rotation becomes a mean rotation of the fibre, a shell's pressure P > 0 acts along the
// normal, on the face below.
struct InpOptions {
  // None: as InpElementFor.
  std::optional<InpElement> element;
  // Load factors at the end of the deck's steps, ascending in magnitude or not; at least one.
  std::vector<double> factors{1.0};
  // First and largest increment of a nonlinear step, parts of it; CalculiX cuts them as it needs.
  std::optional<std::array<double, 2>> increments;
  // Whether the problem is in the state that a solution has found: gas then has its pressure there,
  // which the deck applies as a constant one.
  bool solved = false;
};

// A deck, and what it has.
struct InpDeck {
  std::string text;
  InpElement element = InpElement::kS6;
  int num_nodes = 0, num_elements = 0;
  // What the deck says otherwise than the scene, a sentence each; all are in its header as well.
  std::vector<std::string> remarks;
};

// Solid elements: C3D20R on parametric surfaces, C3D15 on meshes. CalculiX makes solids of shells
// anyhow, and as solids supports hold the whole thickness, fingers touch the faces, and pressure
// acts on both (README.md has what each element gives). Shell elements, S8R or S6, where edges have
// moments in the nonlinear theory, which no dead forces of solids are.
InpElement InpElementFor(const Scene& scene, bool nonlinear);

// False and *error where a mesh is asked for quadrilaterals.
bool MakeInpDeck(const ShellProblem& problem,
                 const InpOptions& options,
                 InpDeck* deck,
                 std::string* error);

}  // namespace darboux

#endif  // DARBOUX_SOLVER_INP_EXPORT_H_
