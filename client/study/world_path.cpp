#include "study/world_path.h"

#include "stance/projection.h"

namespace torqued
{

std::optional<Kinematics> WorldPath::next(const DesiredState& desired)
{
  Result<Motion> completed = complete_motion(*robot_, desired);
  if (std::holds_alternative<Refusal>(completed))
    return std::nullopt;
  Kinematics now = std::get<Motion>(completed).now;

  std::array<std::optional<double>, 2> footholds;
  for (const Side side : kSides)
    if (const Contact contact = desired.support.of(side); contact != Contact::none)
      footholds[static_cast<std::size_t>(side)] = foothold(*robot_, now, side, contact);
  if (!desired.base_given && !robot_->fixed_root())
  {
    // the foot that carries most now is the one that rests
    const Side resting =
        desired.support.load_transfer > 0.5 || desired.support.of(desired.support.trailing()) == Contact::none
            ? desired.support.leading
            : desired.support.trailing();
    for (const Side side : {other(resting), resting})
      if (const auto s = static_cast<std::size_t>(side); footholds[s] && footholds_[s])
        offset_ = *footholds_[s] - *footholds[s];
    now.base.x() += offset_;
    for (std::optional<double>& x : footholds)
      if (x)
        *x += offset_;
  }
  footholds_ = footholds;
  return now;
}

} // namespace torqued
