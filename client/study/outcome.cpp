#include "study/outcome.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

namespace torqued
{

namespace
{

// The short name of a phase of a walk.
std::string_view phase_name(const Support& support)
{
  const Contact leading = support.of(support.leading), trailing = support.of(support.trailing());
  if (leading == Contact::none && trailing == Contact::none)
    return "flight";
  if (leading == Contact::none || trailing == Contact::none)
    return "SSP";
  if (leading == Contact::sole && trailing == Contact::sole)
    return "flat";
  return trailing == Contact::sole ? "DSP1" : leading == Contact::sole ? "DSP2" : "points";
}

// Σ |τ θ̇| over the motors, W
double power(const Robot& robot, const DesiredState& state, const Answer& answer)
{
  return answer.torque.cwiseProduct(joint_rates(robot, state.v.head(robot.mechanism.num_theta()))).cwiseAbs().sum();
}

} // namespace

Answered answer_motion(const Robot& robot, AnswerSettings settings, const std::vector<DesiredState>& states,
                       const std::optional<Method>& by)
{
  Answered answered;
  settings.methods.method = by.value_or(settings.methods.method);
  StreamMemory memory;
  for (DesiredState desired : states)
  {
    desired.method = by.value_or(desired.method);
    const Result<Answer> result = answer(robot, settings, desired, memory);
    const Answer* found = std::get_if<Answer>(&result);
    answered.answers.push_back(found ? std::optional(*found) : std::nullopt);
    if (!found)
      ++answered.refused[std::string(name_of(std::get<Refusal>(result).reason()))];
  }
  return answered;
}

Changes find_changes(const std::vector<DesiredState>& states)
{
  Changes changes;
  changes.at.assign(states.size(), -1);
  for (std::size_t i = 1; i < states.size(); ++i)
  {
    if (states[i].stream_id != states[i - 1].stream_id || states[i].support.contact == states[i - 1].support.contact)
      continue;
    const std::string kind = fmt::format("{}→{}", phase_name(states[i - 1].support), phase_name(states[i].support));
    const auto known = std::ranges::find(changes.kinds, kind);
    changes.at[i] = static_cast<int>(known - changes.kinds.begin());
    if (known == changes.kinds.end())
      changes.kinds.push_back(kind);
    changes.longest = std::max(changes.longest, states[i].utime - states[i - 1].utime);
  }
  return changes;
}

double Outcome::rms() const
{
  return seconds > 0.0 ? std::sqrt(effort / seconds) : 0.0;
}

Outcome outcome_of(const Robot& robot, const std::vector<DesiredState>& states, const Answers& answers,
                   const Changes& changes)
{
  Outcome outcome;
  outcome.jumps.assign(changes.kinds.size(), 0.0);
  for (std::size_t i = 0; i < states.size(); ++i)
  {
    const std::optional<Answer>& found = answers[i];
    if (!found)
      continue;
    ++outcome.answered;
    for (std::int32_t bit = 1; bit <= flag::prior; bit <<= 1)
      if ((found->flags & bit) != 0)
        ++outcome.flagged[bit];
    outcome.peak = std::max(outcome.peak, found->torque.cwiseAbs().maxCoeff());
    if (i > 0 && answers[i - 1] && states[i].stream_id == states[i - 1].stream_id)
    {
      const VectorJ& before = answers[i - 1]->torque;
      const double dt = 1e-6 * static_cast<double>(states[i].utime - states[i - 1].utime);
      outcome.seconds += dt;
      outcome.effort += 0.5 * dt * (found->torque.squaredNorm() + before.squaredNorm());
      outcome.work += 0.5 * dt * (power(robot, states[i], *found) + power(robot, states[i - 1], *answers[i - 1]));
      if (const int kind = changes.at[i]; kind >= 0)
        outcome.jumps[static_cast<std::size_t>(kind)] =
            std::max(outcome.jumps[static_cast<std::size_t>(kind)], (found->torque - before).cwiseAbs().maxCoeff());
    }
    if (states[i].support.redundancy() > 0)
    {
      ++outcome.double_support;
      outcome.held += (found->flags & (flag::slips | flag::lifts | flag::tips)) == 0 ? 1 : 0;
      outcome.relaxed += (found->flags & flag::relaxed) != 0 ? 1 : 0;
    }
  }
  return outcome;
}

} // namespace torqued
