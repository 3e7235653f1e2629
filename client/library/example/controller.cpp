// A controller that sways a standing robot's trunk: asks torqued for the torques of each instant, and hands them on.
//
//   controller [LCM_URL]

#include <torqued/torque_client.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <exception>
#include <thread>

namespace
{

using namespace std::chrono_literals;

// Where your motors are told what to do.
void apply(const torqued::torque_command_t& command)
{
  static int count = 0;
  if (count++ % 50 == 0)
    std::printf("torques %7.2f %7.2f N m … flags %d\n", command.torque.front(), command.torque.back(), command.flags);
}
// Where your motors let go, or hold the robot as well as they can without torqued.
void let_go(const char* why)
{
  std::printf("no torques: %s\n", why);
}

} // namespace

int main(int argc, char** argv)
try
{
  torqued::TorqueClient client(argc > 1 ? argv[1] : "");
  if (!client.wait_for_model(5s))
  {
    std::fprintf(stderr, "controller: torqued is not on this bus\n");
    return 1;
  }
  const torqued::model_info_t& model = *client.model();
  const auto found = std::find(model.absolute_names.begin(), model.absolute_names.end(), "q6");
  if (found == model.absolute_names.end())
  {
    std::fprintf(stderr, "controller: %s has no coordinate q6, the trunk's angle\n", model.name.c_str());
    return 1;
  }
  const auto trunk = static_cast<std::size_t>(found - model.absolute_names.begin());

  // 2 s at 200 Hz: q = A (1 − cos ωt), at rest at the beginning. Both legs stay alike, so both feet carry the same.
  constexpr double A = 0.05, omega = 6.28;
  torqued::desired_state_t desired = client.standing();
  const auto start = torqued::TorqueClient::Clock::now();
  for (auto next = start; next < start + 2s; next += 5ms)
  {
    std::this_thread::sleep_until(next);
    const double t = std::chrono::duration<double>(next - start).count();
    desired.q[trunk] = A * (1.0 - std::cos(omega * t));
    desired.v[trunk] = A * omega * std::sin(omega * t);
    desired.a[trunk] = A * omega * omega * std::cos(omega * t);

    const torqued::Reply reply = client.ask(desired, 4ms);
    if (const auto* command = std::get_if<torqued::torque_command_t>(&reply))
      apply(*command);
    else if (const auto* rejection = std::get_if<torqued::rejection_t>(&reply))
      let_go(rejection->detail.c_str());
    else if (const auto* discarded = std::get_if<torqued::Discarded>(&reply))
      let_go(discarded->detail.c_str());
    else
      let_go("torqued is silent");
  }
  let_go("the motion is over");
}
catch (const std::exception& error)
{
  let_go("the controller ends");
  std::fprintf(stderr, "controller: %s\n", error.what());
  return 1;
}
