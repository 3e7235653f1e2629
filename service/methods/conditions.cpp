#include "methods/conditions.h"

namespace torqued
{

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
