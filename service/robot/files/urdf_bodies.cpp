#include "robot/files/urdf_model.h"

#include <Eigen/Eigenvalues>
#include <cmath>
#include <fmt/format.h>

namespace torqued::urdf
{

namespace
{

// a body's moments fulfil the triangle's inequality; thin plates and rods reach it
void look_at_tensor(Model& model, const Link& link)
{
  constexpr double rounding = 1e-3;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(link.inertia, Eigen::EigenvaluesOnly);
  const Eigen::Vector3d moments = solver.eigenvalues().unaryExpr(
      [&link](double moment) { return std::abs(moment) < 1e-12 * link.inertia.cwiseAbs().maxCoeff() ? 0.0 : moment; });
  const double least = moments(0), middle = moments(1), largest = moments(2);
  // a negative one breaks it, too: the largest is then more than the middle and it
  if (largest - middle - least <= rounding * largest)
    return;
  model.notes.push_back(fmt::format("{}:{}: link '{}': inertia: no body has the principal moments {:.6g}, {:.6g} and "
                                    "{:.6g} kg m^2, {}; only that about y is read, {:.6g}",
                                    model.file, link.inertia_line, link.name, least, middle, largest,
                                    least < -rounding * largest
                                        ? "of which one is negative"
                                        : "of which the largest is more than the sum of the others",
                                    moment_about_y(link)));
}

// the mass of a link and of all that is fixed to it
double mass_of_body(const Model& model, int index)
{
  double mass = 0.0;
  std::vector<int> body = {index};
  for (std::size_t done = 0; done < body.size(); ++done)
  {
    const Link& link = model.link(body[done]);
    mass += link.mass;
    for (const int i : link.joints)
      if (model.joint(i).type == Joint::Type::fixed)
        body.push_back(model.joint(i).child);
  }
  return mass;
}

} // namespace

double moment_about_y(const Link& link)
{
  return (link.inertia_R * link.inertia * link.inertia_R.transpose())(1, 1);
}

void look_at_bodies(Model& model)
{
  for (const int i : model.order)
  {
    const Link& link = model.link(i);
    look_at_tensor(model, link);
    if (i == model.root || link.bar_to >= 0) // the bar of a rolling joint has no mass
      continue;
    const Joint& joint = model.joint(link.joint);
    if (joint.type != Joint::Type::fixed && mass_of_body(model, i) == 0.0)
      model.notes.push_back(fmt::format(
          "{}:{}: link '{}' is massless as read, and {} moves it: neither it nor what is fixed to it has a mass",
          model.file, link.line, link.name, name_of(joint)));
  }
}

} // namespace torqued::urdf
