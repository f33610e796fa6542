#include "solver/inp_export.h"

#include <Eigen/Dense>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <memory>

#include "solver/inp_finger.h"
#include "solver/inp_loads.h"
#include "solver/inp_supports.h"
#include "solver/inp_text.h"
#include "solver/support_conditions.h"

namespace darboux {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// Contact's penalty relative to E/h: pressures of a tenth of E are let in by 5e-4 of the thickness.
constexpr double kContactStiffness = 200.0;
// Springs of a shell that fingers alone hold, relative to E h^2 / size.
constexpr double kSoftSpring = 1e-5;
// Divisions of a finger's rounding to 45 degrees.
constexpr int kLeastArc = 6, kMostArc = 24;

// One finger as elements.
struct Finger {
  const FingerSpec* spec = nullptr;
  Vector3d direction = Vector3d::Zero();
  bool touches_top = true;
  int pin_node = 0;  // kPin: the node that is pushed
  int first_node = 0, num_nodes = 0;
  int first_element = 0, num_elements = 0;
  int guide_node = 0;  // by force: its first degree of freedom is the travel
};

class Writer {
 public:
  Writer(const ShellProblem& problem, const InpOptions& options, InpElement element)
      : problem_(problem),
        scene_(problem.scene()),
        surface_(problem.surface()),
        options_(options),
        mesh_(surface_, element, scene_.shell.thickness) {}

  void Write(InpDeck* deck) {
    frame_.length = surface_.size();
    frame_.center = Vector3d::Zero();
    for (const InpMesh::Column& column : mesh_.columns()) frame_.center += column.position;
    frame_.center /= static_cast<double>(mesh_.columns().size());
    next_node_ = static_cast<int>(mesh_.nodes().size()) + 1;
    next_element_ = static_cast<int>(mesh_.elements().size()) + 1;

    supports_ = MakeInpSupports(scene_, mesh_, frame_);
    loads_ = MakeInpLoads(scene_, mesh_, problem_.nonlinear());
    remarks_.insert(remarks_.end(), supports_.remarks.begin(), supports_.remarks.end());
    remarks_.insert(remarks_.end(), loads_.remarks.begin(), loads_.remarks.end());
    FindGasPressure();
    WriteShell();
    WriteFingers();
    HoldFreeShell();
    WriteConditions();
    WriteContact();
    WriteSteps();
    Remark();

    deck->element = mesh_.element();
    deck->num_nodes = next_node_ - 1;
    deck->num_elements = next_element_ - 1;
    deck->remarks = remarks_;
    deck->text = InpHeader(scene_.name, mesh_, remarks_) + model_ + steps_;
  }

 private:
  void WriteShell() {
    model_ += "*NODE, NSET=SHELL\n";
    for (size_t i = 0; i < mesh_.nodes().size(); ++i) {
      model_ += std::to_string(i + 1) + ", " + InpTriple(mesh_.nodes()[i].position) + "\n";
    }
    model_ += "*ELEMENT, TYPE=" + std::string(ToString(mesh_.element())) + ", ELSET=SHELL\n";
    for (size_t e = 0; e < mesh_.elements().size(); ++e) {
      std::vector<int> numbers = mesh_.ElementNodes(static_cast<int>(e));
      numbers.insert(numbers.begin(), static_cast<int>(e) + 1);
      model_ += InpList(numbers);
    }
    std::vector<int> middle;
    for (const InpMesh::Column& column : mesh_.columns()) {
      if (column.nodes[1] > 0) middle.push_back(column.nodes[1]);
    }
    model_ += "** nodes of the middle surface\n" + InpSet("NSET", "MIDDLE", middle);
    for (const ProbeSpec& probe : scene_.probes) {
      const Vector3d x = surface_.Position(Resolve(probe.at, surface_));
      const InpMesh::Column& column = mesh_.columns()[mesh_.Nearest(x, mesh_.is_solid())];
      model_ += InpSet("NSET", "PROBE_" + probe.name, {column.nodes[1]});
      const double off = (column.position - x).norm();
      if (off > 1e-6 * surface_.size()) {
        remarks_.push_back("probe " + probe.name + ": node " + std::to_string(column.nodes[1]) +
                           ", the nearest one, is " + InpNumber(off) + " away from it");
      }
    }
    const ShellSpec& shell = scene_.shell;
    model_ += "*MATERIAL, NAME=SHELL\n*ELASTIC\n" + InpNumber(shell.young_modulus) + ", " +
              InpNumber(PoissonRatio()) + "\n";
    if (shell.density > 0.0) model_ += "*DENSITY\n" + InpNumber(shell.density) + "\n";
    model_ += mesh_.is_solid() ? "*SOLID SECTION, ELSET=SHELL, MATERIAL=SHELL\n"
                               : "*SHELL SECTION, ELSET=SHELL, MATERIAL=SHELL\n" +
                                     InpNumber(shell.thickness) + "\n";
  }

  // Solids have no modulus of compression at 1/2; a shell's stress is plane, so that the last part
  // of a thousand does not matter.
  double PoissonRatio() const { return std::min(scene_.shell.poisson_ratio, 0.4995); }

  void FindGasPressure() {
    const LoadSpec* const gas = FindGas(scene_);
    if (gas == nullptr) return;
    gas_pressure_ = options_.solved && problem_.has_gas() ? problem_.ReportGas().gauge_pressure
                                                          : gas->gauge_pressure;
    const std::string pressure = InpNumber(gas_pressure_);
    remarks_.push_back(
        "gas: there is no keyword for gas whose pressure depends on its volume; the deck has a "
        "constant pressure of " +
        pressure + " instead, " +
        (options_.solved ? "that of the state that Darboux has found"
                         : "that at rest: export after a solution, without --export_only, for the "
                           "one that it ends with"));
    if (gas->prestressed) {
      gas_pressure_ = options_.solved ? gas_pressure_ - gas->gauge_pressure : 0.0;
      remarks_.push_back(
          "gas, rest: prestressed: the initial stress is not exported, nor the pressure that it "
          "bears; the deck has the change of the pressure alone, on a shell without stress");
    }
  }

  // ---- Fingers ------------------------------------------------------------------------------

  void WriteFingers() {
    if (scene_.fingers.empty()) return;
    const std::vector<FingerReport> reports = problem_.grasp()->Report(problem_.force_unit());
    for (size_t f = 0; f < scene_.fingers.size(); ++f) {
      const FingerSpec& spec = scene_.fingers[f];
      Finger finger;
      finger.spec = &spec;
      finger.direction = Vector3d(spec.direction[0], spec.direction[1], spec.direction[2]);
      const Vector3d normal = surface_.MakePoint(reports[f].touched).n;
      finger.touches_top = normal.dot(finger.direction) < 0.0;
      if (spec.force) {
        finger.guide_node = next_node_++;
        model_ += "** the travel of finger " + spec.name + "\n*NODE, NSET=TRAVEL_" + spec.name +
                  "\n" + std::to_string(finger.guide_node) + ", " + InpTriple(Vector3d::Zero()) +
                  "\n";
        WriteSprings("TRAVEL_" + spec.name, {finger.guide_node}, 1);
        remarks_.push_back("finger " + spec.name + ": a soft spring of " + InpNumber(SoftSpring()) +
                           " holds its travel where nothing touches it");
      }
      if (spec.shape == FingerSpec::Shape::kPin) {
        finger.pin_node =
            mesh_.columns()[mesh_.Nearest(surface_.Position(reports[f].touched), true)].nodes[1];
        model_ += InpSet("NSET", "FINGER_" + spec.name, {finger.pin_node});
        remarks_.push_back(
            "finger " + spec.name +
            ": a pin pushes its node along its direction, and would pull it as well");
        fingers_.push_back(finger);
        continue;
      }
      WriteFingerMesh(reports[f].shift, &finger);
      if (spec.friction > 0.0) {
        remarks_.push_back("finger " + spec.name +
                           ": friction is a penalty in CalculiX; what sticks creeps a little");
      }
      fingers_.push_back(finger);
    }
    remarks_.push_back(
        "fingers: meshed surfaces with contact by penalty, " + InpNumber(ContactStiffness()) +
        " of pressure per penetration; facets lie within the round shapes by up to 1 - cos(half an "
        "angle) of the radius, and a wall of solid elements is squeezed, which no shell is");
  }

  void WriteFingerMesh(double shift, Finger* finger) {
    const FingerSpec& spec = *finger->spec;
    FingerPose pose;
    std::string error;
    if (MakeFinger(spec, &pose, &error) == nullptr) return;  // It was made before.
    const Vector3d position = pose.position + shift * finger->direction;
    const double radius = spec.shape == FingerSpec::Shape::kBox ? spec.rounding : spec.radius;
    const double pi = std::acos(-1.0);
    // Facets of half an element.
    const int arc =
        std::clamp(static_cast<int>(std::ceil(0.25 * pi * radius / (0.5 * mesh_.element_size()))),
                   kLeastArc,
                   kMostArc);
    const TriangleMesh surface =
        MakeFingerSurface(spec, position, pose.rotation, frame_.center, 1.2 * surface_.size(), arc);
    const std::vector<Vector3d> inner = InnerPoints(surface, scene_.shell.thickness);
    finger->first_node = next_node_;
    finger->num_nodes = static_cast<int>(2 * inner.size());
    model_ += "** finger " + spec.name + ", " +
              (spec.force ? "driven by a force" : "driven by a travel") +
              "; inner nodes, then those of its surface\n*NODE, NSET=FINGER_" + spec.name + "\n";
    for (const std::vector<Vector3d>* points : {&inner, &surface.vertices}) {
      for (const Vector3d& x : *points) {
        model_ += std::to_string(next_node_++) + ", " + InpTriple(x) + "\n";
      }
    }
    finger->first_element = next_element_;
    finger->num_elements = static_cast<int>(surface.triangles.size());
    model_ += "*ELEMENT, TYPE=C3D6, ELSET=FINGER_" + spec.name + "\n";
    for (const std::array<int, 3>& t : surface.triangles) {
      const int below = finger->first_node, above = below + static_cast<int>(inner.size());
      model_ += InpList({next_element_++,
                         below + t[0],
                         below + t[1],
                         below + t[2],
                         above + t[0],
                         above + t[1],
                         above + t[2]});
    }
    model_ += "*SOLID SECTION, ELSET=FINGER_" + spec.name + ", MATERIAL=SHELL\n";
    // What can touch: the part of the surface that looks along the way it closes.
    model_ += "*SURFACE, NAME=FACE_" + spec.name + ", TYPE=ELEMENT\n";
    for (int i = 0; i < finger->num_elements; ++i) {
      model_ += std::to_string(finger->first_element + i) + ", S2\n";
    }
    model_ += "*SURFACE, NAME=SHELL_" + spec.name + ", TYPE=ELEMENT\n";
    for (size_t e = 0; e < mesh_.elements().size(); ++e) {
      double along = -1.0;  // the corner that looks at the finger least
      for (const int c : mesh_.elements()[e]) {
        const double towards = mesh_.columns()[c].normal.dot(finger->direction);
        along = std::max(along, finger->touches_top ? towards : -towards);
      }
      if (along > 0.3) continue;
      model_ += std::to_string(e + 1) + (finger->touches_top ? ", " : ", ") +
                FaceName(finger->touches_top) + "\n";
    }
  }

  std::string FaceName(bool top) const { return top ? "S2" : "S1"; }

  double ContactStiffness() const {
    return kContactStiffness * scene_.shell.young_modulus / scene_.shell.thickness;
  }

  void WriteContact() {
    for (const Finger& finger : fingers_) {
      if (finger.spec->shape == FingerSpec::Shape::kPin) continue;
      const std::string& name = finger.spec->name;
      model_ += "*SURFACE INTERACTION, NAME=TOUCH_" + name +
                "\n*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=LINEAR\n" +
                InpNumber(ContactStiffness()) + "\n";
      if (finger.spec->friction > 0.0) {
        model_ += "*FRICTION\n" + InpNumber(finger.spec->friction) + ", " +
                  InpNumber(0.5 * ContactStiffness()) + "\n";
      }
      model_ += "*CONTACT PAIR, INTERACTION=TOUCH_" + name + ", TYPE=SURFACE TO SURFACE\nSHELL_" +
                name + ", FACE_" + name + "\n";
    }
  }

  double SoftSpring() const {
    const double h = scene_.shell.thickness;
    return kSoftSpring * scene_.shell.young_modulus * h * h / surface_.size();
  }

  // From nodes to the ground.
  void WriteSprings(const std::string& set, const std::vector<int>& nodes, int dof) {
    model_ += "*ELEMENT, TYPE=SPRING1, ELSET=" + set + "\n";
    for (const int node : nodes) model_ += InpList({next_element_++, node});
    model_ += "*SPRING, ELSET=" + set + "\n" + std::to_string(dof) + "\n" +
              InpNumber(SoftSpring()) + "\n";
  }

  // ---- What holds the shell -----------------------------------------------------------------

  void HoldFreeShell() {
    const auto free_motions = [this] {
      Eigen::MatrixXd rows(supports_.rigid_rows.size(), 6);
      for (size_t i = 0; i < supports_.rigid_rows.size(); ++i)
        rows.row(i) = supports_.rigid_rows[i];
      return FreeMotions(rows, Eigen::MatrixXd::Identity(6, 6));
    };
    Eigen::MatrixXd motions = free_motions();
    if (motions.cols() == 0) return;
    const std::vector<std::string> names = NameMotions(motions, frame_);
    std::string list;
    for (const std::string& name : names) list += (list.empty() ? "" : ", ") + name;
    const std::vector<int> far = mesh_.FarCorners(frame_.center, 3);
    if (!scene_.fingers.empty()) {
      std::vector<int> nodes;
      for (const int c : far) nodes.push_back(mesh_.columns()[c].nodes[1]);
      for (int k = 1; k <= 3; ++k) WriteSprings("SPRING" + std::to_string(k), nodes, k);
      remarks_.push_back("no support holds the shell against " + list +
                         "; beside the fingers, soft springs of " + InpNumber(SoftSpring()) +
                         " at three nodes do");
      return;
    }
    // Statically determinate: loads that balance leave no force there. Across the way to the centre
    // first, so that a shell that grows evenly does not turn.
    std::array<Matrix3d, 3> directions;
    std::array<std::vector<Vector3d>, 3> held;
    for (int i = 0; i < 3; ++i) {
      const Vector3d out = mesh_.columns()[far[i]].position - frame_.center;
      directions[i].col(2) = out.stableNormalized();
      directions[i].col(0) = directions[i].col(2).unitOrthogonal();
      directions[i].col(1) = directions[i].col(2).cross(directions[i].col(0));
    }
    for (const int k : {0, 1, 2}) {
      for (int i = 0; i < 3 && motions.cols() > 0; ++i) {
        const Vector3d direction = directions[i].col(k);
        const auto row = frame_.DisplacementRow(mesh_.columns()[far[i]].position, direction);
        if ((row * motions).norm() < 0.05 * row.norm()) continue;
        supports_.rigid_rows.push_back(row);
        held[i].push_back(direction);
        motions = free_motions();
      }
    }
    for (int i = 0; i < 3; ++i) HoldNode(mesh_.columns()[far[i]].nodes[1], held[i], &supports_);
    remarks_.push_back("no support holds the shell against " + list +
                       "; the deck holds that many displacements at nodes, without a force where "
                       "the loads balance. Darboux keeps the mean motion at zero instead: compare "
                       "up to a rigid motion");
  }

  void WriteConditions() {
    // Nodes with axes of their own, those with the same axes together.
    std::vector<std::pair<Matrix3d, std::vector<int>>> groups;
    for (const auto& [node, axes] : supports_.axes) {
      const auto same = std::find_if(groups.begin(), groups.end(), [&a = axes](const auto& group) {
        return (group.first - a).cwiseAbs().maxCoeff() == 0.0;
      });
      if (same == groups.end()) {
        groups.push_back({axes, {node}});
      } else {
        same->second.push_back(node);
      }
    }
    for (size_t i = 0; i < groups.size(); ++i) {
      const std::string set = "AXES" + std::to_string(i + 1);
      model_ += InpSet("NSET", set, groups[i].second) + "*TRANSFORM, NSET=" + set + ", TYPE=R\n" +
                InpTriple(groups[i].first.row(0)) + ", " + InpTriple(groups[i].first.row(1)) + "\n";
    }
    std::string equations, zeros;
    for (const InpCondition& condition : supports_.conditions) {
      if (condition.terms.size() == 1) {
        const InpDof& dof = condition.terms[0].first;
        if (condition.target == 0.0) {
          zeros += InpDofText(dof);
        } else {
          prescribed_.push_back({dof, condition.target});
        }
        continue;
      }
      std::vector<std::pair<InpDof, double>> terms = condition.terms;
      if (condition.target != 0.0) {
        // An equation has no right-hand side: a node of its own has the value.
        const InpDof value{next_node_++, 1};
        model_ +=
            "*NODE\n" + std::to_string(value.node) + ", " + InpTriple(Vector3d::Zero()) + "\n";
        terms.push_back({value, -1.0});
        prescribed_.push_back({value, condition.target});
      }
      equations += InpEquation(terms);
    }
    for (const Finger& finger : fingers_) AddFingerConditions(finger, &equations, &zeros);
    if (!equations.empty()) model_ += "*EQUATION\n" + equations;
    if (!zeros.empty()) model_ += "*BOUNDARY\n" + zeros;
  }

  // All nodes of a finger move alike: along its direction, by its travel.
  void AddFingerConditions(const Finger& finger, std::string* equations, std::string* zeros) {
    const bool pin = finger.pin_node > 0;
    if (pin) {
      // Only along its direction; free across.
      int pivot;
      finger.direction.cwiseAbs().maxCoeff(&pivot);
      InpDof guide{finger.guide_node, 1};
      if (guide.node == 0) {
        guide.node = next_node_++;
        model_ +=
            "*NODE\n" + std::to_string(guide.node) + ", " + InpTriple(Vector3d::Zero()) + "\n";
        prescribed_.push_back({guide, finger.spec->travel});
      }
      const double scale = 1.0 / finger.direction[pivot];
      std::vector<std::pair<InpDof, double>> terms = {{{finger.pin_node, pivot + 1}, 1.0}};
      for (int k = 0; k < 3; ++k) {
        if (k != pivot && finger.direction[k] != 0.0) {
          terms.push_back({{finger.pin_node, k + 1}, scale * finger.direction[k]});
        }
      }
      terms.push_back({guide, -scale});
      *equations += InpEquation(terms);
      return;
    }
    if (!finger.spec->force) return;  // The steps have the displacements of its nodes.
    for (int node = finger.first_node; node < finger.first_node + finger.num_nodes; ++node) {
      for (int k = 0; k < 3; ++k) {
        if (finger.direction[k] == 0.0) {
          *zeros += InpDofText({node, k + 1});
        } else {
          *equations +=
              InpEquation({{{node, k + 1}, 1.0}, {{finger.guide_node, 1}, -finger.direction[k]}});
        }
      }
    }
  }

  // ---- Steps --------------------------------------------------------------------------------

  void WriteSteps() {
    const bool inflates = gas_pressure_ != 0.0 && !scene_.fingers.empty();
    if (inflates) WriteStep(0.0, "gas alone");
    for (const double factor : options_.factors) {
      WriteStep(factor, "load factor " + InpNumber(factor));
    }
  }

  void WriteStep(double factor, const std::string& title) {
    const bool touches = std::any_of(fingers_.begin(), fingers_.end(), [](const Finger& finger) {
      return finger.pin_node == 0;
    });
    steps_ += "** " + title + "\n";
    if (problem_.nonlinear() || touches) {
      const std::array<double, 2> usual =
          touches ? std::array<double, 2>{0.05, 0.125} : std::array<double, 2>{0.1, 0.25};
      const std::array<double, 2> increments = options_.increments.value_or(usual);
      steps_ += std::string("*STEP") + (problem_.nonlinear() ? ", NLGEOM" : "") +
                ", INC=2000\n*STATIC\n" + InpNumber(increments[0]) + ", 1.0, 1e-6, " +
                InpNumber(increments[1]) + "\n";
    } else {
      steps_ += "*STEP\n*STATIC\n";
    }
    WriteStepBoundary(factor);
    WriteStepForces(factor);
    WriteStepPressures(factor);
    WriteOutput();
    steps_ += "*END STEP\n";
  }

  void WriteStepBoundary(double factor) {
    std::string text;
    for (const auto& [dof, target] : prescribed_) {
      const std::string number = std::to_string(dof.dof);
      text += std::to_string(dof.node) + ", " + number + ", " + number + ", " +
              InpNumber(factor * target) + "\n";
    }
    for (const Finger& finger : fingers_) {
      if (finger.pin_node > 0 || finger.spec->force) continue;
      for (int k = 0; k < 3; ++k) {
        const std::string number = std::to_string(k + 1);
        text += "FINGER_" + finger.spec->name + ", " + number + ", " + number + ", " +
                InpNumber(factor * finger.spec->travel * finger.direction[k]) + "\n";
      }
    }
    if (!text.empty()) steps_ += "*BOUNDARY\n" + text;
  }

  void WriteStepForces(double factor) {
    std::string text;
    const auto add = [&](const std::map<int, Vector3d>& forces, int first_dof) {
      double largest = 0.0;
      for (const auto& [node, force] : forces)
        largest = std::max(largest, force.cwiseAbs().maxCoeff());
      for (const auto& [node, force] : forces) {
        const auto axes = supports_.axes.find(node);
        const Vector3d local =
            axes == supports_.axes.end() ? force : Vector3d(axes->second * force);
        for (int k = 0; k < 3; ++k) {
          // What rounding leaves of nothing is no line.
          if (std::abs(local[k]) <= 1e-14 * largest) continue;
          text += std::to_string(node) + ", " + std::to_string(first_dof + k) + ", " +
                  InpNumber(factor * local[k]) + "\n";
        }
      }
    };
    add(loads_.forces, 1);
    add(loads_.moments, 4);
    for (const Finger& finger : fingers_) {
      if (!finger.spec->force) continue;
      text += std::to_string(finger.guide_node) + ", 1, " +
              InpNumber(factor * *finger.spec->force) + "\n";
    }
    if (!text.empty()) steps_ += "*CLOAD\n" + text;
  }

  void WriteStepPressures(double factor) {
    std::string text;
    for (const Vector3d& acceleration : loads_.gravity) {
      const double size = acceleration.norm();
      if (size == 0.0) continue;
      text +=
          "SHELL, GRAV, " + InpNumber(factor * size) + ", " + InpTriple(acceleration / size) + "\n";
    }
    if (!loads_.pressures.empty() || gas_pressure_ != 0.0) {
      // Gas has its pressure whatever the load factor.
      const std::vector<double> below = FaceRatios(mesh_, -1), above = FaceRatios(mesh_, 1);
      for (size_t e = 0; e < mesh_.elements().size(); ++e) {
        const double pressure =
            gas_pressure_ + (loads_.pressures.empty() ? 0.0 : factor * loads_.pressures[e]);
        const std::string number = std::to_string(e + 1);
        if (mesh_.is_solid()) {
          // On the face below it pushes along n; above, the other half pulls.
          text += number + ", P1, " + InpNumber(0.5 * pressure * below[e]) + "\n";
          text += number + ", P2, " + InpNumber(-0.5 * pressure * above[e]) + "\n";
        } else {
          text += number + ", P, " + InpNumber(pressure * below[e]) + "\n";
        }
      }
    }
    if (!text.empty()) steps_ += "*DLOAD\n" + text;
  }

  void WriteOutput() {
    const auto print = [this](const std::string& set, const std::string& what) {
      steps_ += "*NODE PRINT, NSET=" + set + ", FREQUENCY=100000" +
                (what == "U" ? ", GLOBAL=YES" : ", TOTALS=ONLY") + "\n" + what + "\n";
    };
    print("MIDDLE", "U");
    for (const ProbeSpec& probe : scene_.probes) print("PROBE_" + probe.name, "U");
    for (const Finger& finger : fingers_) {
      print("FINGER_" + finger.spec->name, "RF");
      if (finger.spec->force) print("TRAVEL_" + finger.spec->name, "U");
    }
    steps_ += "*NODE FILE, FREQUENCY=100000\nU\n*EL FILE, FREQUENCY=100000\nS\n";
  }

  void Remark() {
    if (scene_.path.control == PathControl::kArcLength) {
      remarks_.push_back(
          "path, arc_length: CalculiX has no arc length; the deck raises the load, "
          "which ends at a limit point (Abaqus: *STATIC, RIKS)");
    } else if (scene_.path.control == PathControl::kDisplacement) {
      remarks_.push_back("path, displacement: the deck raises the load itself" +
                         std::string(options_.solved ? ", to the factors that Darboux has found"
                                                     : " to the factor 1"));
    }
    if (scene_.shell.poisson_ratio > PoissonRatio()) {
      remarks_.push_back("shell.poisson_ratio: 0.4995 instead of " +
                         InpNumber(scene_.shell.poisson_ratio) + ", as solids need less than 1/2");
    }
    if (scene_.model.strains == Strains::kSeed) {
      remarks_.push_back("model.strains: seed: finite elements have strains of their own");
    }
    if (mesh_.element() == InpElement::kS3) {
      remarks_.push_back(
          "S3: CalculiX expands it to linear wedges, which do not bend; for programs "
          "with a bending element of three nodes");
    }
    if (mesh_.element() == InpElement::kS4) {
      remarks_.push_back("S4: flat elements of four nodes; curved shells need many");
    }
    const bool mirrors =
        std::any_of(scene_.supports.begin(), scene_.supports.end(), [](const SupportSpec& support) {
          return support.kind == SupportSpec::Kind::kSymmetry;
        });
    if (!mesh_.is_solid() && mirrors) {
      remarks_.push_back(
          "symmetry: CalculiX holds the mean of a shell's two faces on mirror planes, not its "
          "whole "
          "thickness, which is too soft by per cents in thick shells and on fine meshes; solid "
          "elements (C3D20R, C3D15) are held exactly");
    }
    if (!loads_.moments.empty()) {
      remarks_.push_back("moments: CalculiX makes each node with a moment a small rigid body");
    }
  }

  const ShellProblem& problem_;
  const Scene& scene_;
  const ShellSurface& surface_;
  const InpOptions& options_;
  InpMesh mesh_;
  RigidFrame frame_;
  InpSupports supports_;
  InpLoads loads_;
  std::vector<Finger> fingers_;
  std::vector<std::pair<InpDof, double>> prescribed_;
  double gas_pressure_ = 0.0;
  int next_node_ = 1, next_element_ = 1;
  std::string model_, steps_;
  std::vector<std::string> remarks_;
};

}  // namespace

InpElement InpElementFor(const Scene& scene, bool nonlinear) {
  const bool cells = scene.surface.surface != nullptr;
  if (nonlinear && HasEdgeMoments(scene)) return cells ? InpElement::kS8R : InpElement::kS6;
  return cells ? InpElement::kC3D20R : InpElement::kC3D15;
}

bool MakeInpDeck(const ShellProblem& problem,
                 const InpOptions& options,
                 InpDeck* deck,
                 std::string* error) {
  const InpElement element =
      options.element.value_or(InpElementFor(problem.scene(), problem.nonlinear()));
  if (IsQuadrilateral(element) && !problem.surface().is_parametric()) {
    *error = "found " + std::string(ToString(element)) +
             ", which has four corners; allowed on a mesh S3 | S6 | C3D15";
    return false;
  }
  Writer(problem, options, element).Write(deck);
  return true;
}

}  // namespace darboux
