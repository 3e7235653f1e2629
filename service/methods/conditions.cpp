#include "methods/conditions.h"

namespace torqued
{

ContactConditions contact_conditions(const Robot& robot, const SupportEquations& equations, const Support& support,
                                     const ContactBounds& bounds)
{
  ContactConditions conditions;
  const Eigen::Matrix3d unit = Eigen::Matrix3d::Identity();
  for_each_condition(
      robot, equations, support, bounds,
      [&](Side side, double bound, double factor, bool is_window, const auto& form) {
        conditions.push_back({side, form(unit.col(0), unit.col(1), unit.col(2)), bound, factor, is_window});
      });
  return conditions;
}

bool windows_give_way(Conditions& conditions, std::bitset<kMaxRows>& active)
{
  if (!conditions.any(Rank::window))
    return false;
  const BoundedVector<kMaxVariables> y = BoundedVector<kMaxVariables>::Zero(conditions.variables());
  const QuadraticProgramSolution least = least_violation(conditions.up_to(Rank::window), y, active);
  if (least.status != QuadraticProgramStatus::optimal)
    return false;
  conditions.relax(Rank::window, least.y);
  active = least.active;
  return true;
}

} // namespace torqued
