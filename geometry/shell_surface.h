#ifndef DARBOUX_GEOMETRY_SHELL_SURFACE_H_
#define DARBOUX_GEOMETRY_SHELL_SURFACE_H_

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "geometry/loop_basis.h"
#include "geometry/loop_mesh.h"
#include "geometry/parameter_domain.h"
#include "geometry/parametric_surface.h"
#include "geometry/quadrature.h"
#include "geometry/strain_point.h"

namespace darboux {

// The rest state of a shell under a Loop space of displacements delta. The middle surface is
//
//   parametric: the exact sigma, so that curved rest shapes carry no discretisation error of their
//     own; finite rotations of a curved shape are only approximated by delta;
//   a mesh: the Loop limit of control points, of any topology; isoparametric, so that finite rigid
//     motions are exact.
class ShellSurface {
 public:
  // How the control vertices of the ghost ring are treated.
  enum class Ghosts {
    kIndependent,  // unknowns of their own: the full Loop space on the shell
    kFolded        // x4 = x2 + x3 - x1 (the paper's Sec. VII-C): no ghost vertex is left
  };

  ShellSurface(std::shared_ptr<const ParametricSurface> surface,
               const ParameterDomain::Options& domain,
               Ghosts ghosts = Ghosts::kIndependent);
  explicit ShellSurface(LoopMesh mesh);

  bool is_parametric() const { return domain_.has_value(); }
  // Parametric surfaces only.
  const ParameterDomain& domain() const { return *domain_; }
  const ControlMesh& mesh() const { return domain_ ? domain_->mesh() : loop_.mesh; }
  // A column per control vertex of a mesh, whose limit surface is the rest shape; empty for a
  // parametric surface. A mesh refined locally has vertices that are no unknowns (folds() says what
  // they are made of): the limit is that of LoopBasis with all of them.
  const Eigen::Matrix3Xd& control_points() const { return loop_.points; }
  const LoopBasis& basis() const { return basis_; }
  int num_elements() const { return mesh().num_elements; }
  // Control vertices that the displacement on an element depends on; the columns of
  // StrainPoint::weights are in this order.
  const std::vector<int>& control_vertices(int element) const {
    return IsFolded(element) ? folds_[element].vertices : basis_.control_vertices(element);
  }
  // What the control vertices that LoopBasis knows stand for, as sums of (unknown, factor); empty
  // where each is an unknown itself.
  const std::vector<std::vector<std::pair<int, double>>>& folds() const { return folded_; }
  // Whether some element depends on the control vertex: false for what is folded.
  bool IsActive(int vertex) const { return active_[vertex]; }
  int num_active_vertices() const { return num_active_; }

  // (0, 0) on a mesh.
  std::array<double, 2> Parameters(const ElementPoint& point) const;
  Eigen::Vector3d Position(const ElementPoint& point) const;
  // With the derivatives in the coordinates (s, t) of its element.
  RestJet Rest(const ElementPoint& point) const;
  // Derivatives through third order in (u, v): principal curvatures and their derivatives.
  // Parametric surfaces only.
  SurfaceJet ParametricJet(const ElementPoint& point) const;
  // The places where elements have corners, numbered: that of corner k of an element; that in the
  // middle of its edge from corner k to corner k + 1, where two elements of half the size meet it
  // (meshes refined locally), else -1.
  int num_corners() const { return static_cast<int>(vertex_points_.size()); }
  int Corner(int element, int k) const { return corners_[mesh().triangles[element][k]]; }
  int HangingCorner(int element, int k) const {
    return loop_.hanging.empty() || loop_.hanging[element][k] < 0
               ? -1
               : corners_[loop_.hanging[element][k]];
  }
  // An element point at each of these places.
  const std::vector<ElementPoint>& vertex_points() const { return vertex_points_; }

  // One point with its weights; area = quadrature_weight * |x_s x x_t|.
  StrainPoint MakePoint(const ElementPoint& point, double quadrature_weight = 0.0) const;

  // Limit values of the basis alone, one per control vertex: row kRowValue of MakePoint's weights.
  Eigen::VectorXd ValueWeights(const ElementPoint& point) const;

  // The triangle rule of `num_points` on an element. At extraordinary vertices second derivatives
  // are unbounded (but square-integrable): there the element is cut into kRings nested rings, each
  // a quarter of the last, and every piece has the rule.
  const std::vector<TrianglePoint>& Rule(int element, int num_points) const;
  static constexpr int kRings = 6;
  // Its points.
  std::vector<StrainPoint> QuadraturePoints(int element, int num_points) const;

  // The part of a StrainPoint that a load needs: no derivative of the basis.
  struct AreaPoint {
    ElementPoint at;
    Eigen::Vector3d position, n;
    double area = 0.0;
    Eigen::RowVectorXd values;  // row kRowValue of the weights
  };
  // Calls use(AreaPoint) for the points of the triangle rule of `num_points` on one element.
  template <typename Use>
  void ForEachAreaPoint(int element, int num_points, const Use& use) const {
    AreaPoint point;
    const int count = static_cast<int>(Rule(element, num_points).size());
    for (int k = 0; k < count; ++k) {
      EvaluateAreaPoint(element, num_points, k, &point);
      use(const_cast<const AreaPoint&>(point));
    }
  }

  // A point of a curve on the surface (side of the domain or parameter line): its StrainPoint has
  // area = quadrature weight times LENGTH element. In the frame's components: unit tangent of the
  // curve and conormal, the unit tangent vector normal to the curve; on a side it points outward.
  struct CurvePoint {
    ElementPoint at;
    StrainPoint point;
    Eigen::Vector2d tangent, conormal;
  };
  // Boundary loops of a mesh are sides as well: Loop(0), Loop(1), ...; those of a parametric
  // surface have the names of Side.
  static Side Loop(int k) { return static_cast<Side>(4 + k); }
  int num_loops() const { return static_cast<int>(loop_.loops.size()); }
  bool HasSide(Side side) const;
  bool IsClosed(Side side) const;
  std::vector<ParameterDomain::BoundaryEdge> BoundaryEdges(Side side) const;
  // `points_per_edge` Gauss points on every element edge of a side (1..5).
  std::vector<CurvePoint> SidePoints(Side side, int points_per_edge) const;
  // The same on the line u = value (parameter 0) or v = value (parameter 1).
  std::vector<CurvePoint> ParameterLinePoints(int parameter,
                                              double value,
                                              int points_per_edge) const;

  // The surface point nearest to x (global: search over the lattice or the elements, then Newton's
  // method with bounds from the best candidates).
  ElementPoint ClosestPoint(const Eigen::Vector3d& x) const;

  // Diameter of the bounding box of the element corners: the length scale of the problem.
  double size() const { return size_; }
  double area() const { return area_; }

 private:
  void FindSizes();
  bool IsFolded(int element) const { return !folds_.empty() && folds_[element].matrix.size() > 0; }
  RestJet Rest(int element, const BasisMatrix& basis) const;
  ElementPoint ClosestPointOnMesh(const Eigen::Vector3d& x) const;
  void EvaluateAreaPoint(int element, int num_points, int k, AreaPoint* point) const;
  StrainPoint MakePoint(const ElementPoint& point,
                        const BasisMatrix& basis,
                        double quadrature_weight) const;
  // The direction is in lattice coordinates, of a mesh in those of the element.
  CurvePoint MakeCurvePoint(const ElementPoint& at,
                            const Eigen::Vector2d& direction,
                            double weight) const;

  // Columns of the Loop basis of an element -> columns of its control_vertices; none where they are
  // the same.
  struct Fold {
    std::vector<int> vertices;
    Eigen::MatrixXd matrix;
  };
  void MakeFolds();

  std::shared_ptr<const ParametricSurface> surface_;
  std::optional<ParameterDomain> domain_;
  LoopMesh loop_;  // where there is no domain_
  LoopBasis basis_;
  std::vector<ElementPoint> vertex_points_;
  std::vector<unsigned char> extraordinary_;  // per element: bit k = corner k; empty: none at all
  std::vector<std::vector<std::pair<int, double>>> folded_;
  std::vector<Fold> folds_;   // per element; empty where folded_ is
  std::vector<int> corners_;  // of vertices
  std::vector<char> active_;
  int num_active_ = 0;
  double size_ = 0.0;
  double area_ = 0.0;
};

}  // namespace darboux

#endif  // DARBOUX_GEOMETRY_SHELL_SURFACE_H_
