#ifndef DARBOUX_TESTS_CALCULIX_DECK_H_
#define DARBOUX_TESTS_CALCULIX_DECK_H_

#include <Eigen/Core>
#include <array>
#include <functional>
#include <map>
#include <string>
#include <vector>

namespace darboux {

// Shells as input decks of CalculiX CrunchiX (ccx 2.20), for comparison (tests/peer_benchmark.cc).
// After its user's manual: keywords, node orders, and that shells are expanded to bricks within.

enum class CalculixElement { kS4, kS6, kS8R, kC3D20R };
const char* ToString(CalculixElement element);

// A point of the middle surface and the unit normal there, at (s, t) in [0, 1]^2.
struct PatchPoint {
  Eigen::Vector3d position, normal;
};

// n x m cells of a patch. S6: two triangles each, diagonals in turn. C3D20R: one layer of bricks.
// Nodes between others lie on the surface, at the middle of the cell's parameters.
class CalculixMesh {
 public:
  // Sides of the patch: s = 0, s = 1, t = 0, t = 1.
  enum Side { kSMin, kSMax, kTMin, kTMax };
  using Forces = std::map<int, Eigen::Vector3d>;  // by node

  CalculixMesh(CalculixElement element,
               std::array<int, 2> cells,
               double thickness,
               const std::function<PatchPoint(double s, double t)>& patch);

  CalculixElement element() const { return element_; }
  const std::vector<Eigen::Vector3d>& nodes() const { return nodes_; }  // numbered from 1
  const std::vector<std::vector<int>>& elements() const { return elements_; }
  double thickness() const { return thickness_; }
  bool IsSolid() const { return element_ == CalculixElement::kC3D20R; }

  // Through the whole thickness.
  std::vector<int> SideNodes(Side side) const;
  // On the middle surface; s, t in {0, 1}.
  int CornerNode(int s, int t) const;

  // Nodal forces that do the work of the load in every displacement of the elements: of a dead
  // force per area of the middle surface (half of it on each face of bricks); of a dead force per
  // length of a side; of a force at a corner (bricks: along the normal's fibre there, 1 : 4 : 1).
  Forces AreaForces(
      const std::function<Eigen::Vector3d(const Eigen::Vector3d& position)>& per_area) const;
  Forces SideForces(Side side, const Eigen::Vector3d& per_length) const;
  Forces CornerForces(int s, int t, const Eigen::Vector3d& force) const;

 private:
  int& At(int i, int j, int k) { return lattice_[(k * size_[1] + j) * size_[0] + i]; }
  int At(int i, int j, int k) const { return lattice_[(k * size_[1] + j) * size_[0] + i]; }
  int layers() const { return IsSolid() ? 3 : 1; }
  int middle() const { return IsSolid() ? 1 : 0; }
  void AddFaceForces(
      const std::vector<int>& face,
      double share,
      const std::function<Eigen::Vector3d(const Eigen::Vector3d& position)>& per_area,
      Forces* forces) const;

  CalculixElement element_;
  double thickness_;
  int step_;                  // lattice points per cell: 2 for quadratic elements
  std::array<int, 2> size_;   // lattice points along s and t
  std::vector<int> lattice_;  // node numbers, 0 = none
  std::vector<Eigen::Vector3d> nodes_;
  std::vector<std::vector<int>> elements_;
};

struct CalculixFix {
  std::vector<int> nodes;
  int first = 1, last = 3;  // 1-3 displacements, 4-6 rotations, in the nodes' axes
};

struct CalculixDeck {
  double young_modulus = 0.0, poisson_ratio = 0.0;
  std::vector<CalculixFix> fixed;
  CalculixMesh::Forces forces;  // dead, in global axes
  // Nodes have cylindrical axes about x (1 radial, 2 tangential, 3 axial), not global ones: on the
  // mirror planes of a tube only the rotation about the edge may be held, none about the normal,
  // which the expansion to bricks does not know.
  bool cylindrical = false;
  bool nonlinear = false;
  double first_increment = 0.1, largest_increment = 0.1;
  std::vector<int> printed;
};

std::string MakeDeck(const CalculixMesh& mesh, const CalculixDeck& deck);

// Displacements of the last increment in a .dat file's text, by node. False where there are none.
bool ReadDat(const std::string& text, std::map<int, Eigen::Vector3d>* displacements);

}  // namespace darboux

#endif  // DARBOUX_TESTS_CALCULIX_DECK_H_
