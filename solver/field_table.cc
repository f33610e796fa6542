#include "solver/field_table.h"

namespace darboux {

FieldTable::FieldTable(const ShellProblem& problem)
    : problem_(problem), mesh_(MakeOutputMesh(problem.surface())), points_("Points", {}, 0) {
  const size_t n = mesh_.points.size();
  const std::vector<std::string> xyz = {"x", "y", "z"};
  points_ = Field("Points", xyz, n);
  Field uv("uv", {"u", "v"}, n);
  Field curvatures("principal_curvatures", {"1", "2"}, n);
  Field direction("principal_direction_1", xyz, n);
  sites_.reserve(n);
  for (const ElementPoint& at : mesh_.points) {
    sites_.push_back(MakeFieldSite(problem.surface(), at));
    const FieldSite& site = sites_.back();
    points_.Add(site.point.position);
    uv.Add(site.uv[0]);
    uv.Add(site.uv[1]);
    curvatures.Add(site.principal_curvatures);
    direction.Add(site.principal_direction_1);
  }
  rest_fields_ = {std::move(uv), std::move(curvatures), std::move(direction)};
}

std::vector<Field> FieldTable::StateFields(const Eigen::Matrix3Xd& displacements) const {
  const size_t n = sites_.size();
  const std::vector<std::string> xyz = {"x", "y", "z"}, tensor = {"11", "22", "12"};
  Field displacement("displacement", xyz, n), normal("normal", xyz, n);
  Field membrane_strain("membrane_strain", tensor, n);
  Field principal("principal_membrane_strain", {"1", "2"}, n);
  Field bending_strain("bending_strain", tensor, n);
  Field membrane_force("membrane_force", tensor, n), moment("moment", tensor, n);
  Field top("von_mises_top", {}, n), bottom("von_mises_bottom", {}, n);
  Field energy("energy_density", {}, n);
  Field membrane_energy("membrane_energy_density", {}, n);
  Field bending_energy("bending_energy_density", {}, n);
  for (const FieldSite& site : sites_) {
    const ShellFields fields = EvaluateFields(problem_, displacements, site);
    displacement.Add(fields.displacement);
    normal.Add(fields.normal);
    membrane_strain.Add(fields.membrane_strain);
    principal.Add(fields.principal_membrane_strain);
    bending_strain.Add(fields.bending_strain);
    membrane_force.Add(fields.membrane_force);
    moment.Add(fields.moment);
    top.Add(fields.von_mises_top);
    bottom.Add(fields.von_mises_bottom);
    energy.Add(fields.membrane_energy_density + fields.bending_energy_density);
    membrane_energy.Add(fields.membrane_energy_density);
    bending_energy.Add(fields.bending_energy_density);
  }
  std::vector<Field> fields;
  for (Field* field : {&displacement,
                       &normal,
                       &membrane_strain,
                       &principal,
                       &bending_strain,
                       &membrane_force,
                       &moment,
                       &top,
                       &bottom,
                       &energy,
                       &membrane_energy,
                       &bending_energy}) {
    fields.push_back(std::move(*field));
  }
  return fields;
}

}  // namespace darboux
