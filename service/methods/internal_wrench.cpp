#include "methods/least_torque.h"

namespace torqued
{

static void list(InternalWrench& settings, SettingList& with)
{
  with.weights("weights", settings.weights);
}

MethodRow internal_wrench_row()
{
  return method_row<InternalWrench>("internal-wrench",
                                    [](const DoubleSupport& now) {
                                      return least_torque(now.robot, now.equations, now.support, now.all,
                                                          now.settings.of<InternalWrench>().weights);
                                    });
}

} // namespace torqued
