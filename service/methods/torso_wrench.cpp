#include "methods/least_torque.h"

namespace torqued
{

static void list(TorsoWrench& settings, SettingList& with)
{
  with.weights("weights", settings.weights);
}

MethodRow torso_wrench_row()
{
  return method_row<TorsoWrench>(
      "torso-wrench", [](const DoubleSupport& now)
      { return least_torque(now.robot, now.equations, now.support, now.all, now.settings.of<TorsoWrench>().weights); });
}

} // namespace torqued
