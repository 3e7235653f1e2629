/// The methods: rules that choose the ground reactions of double support. Each is a file of this folder, which says
/// what the rule is, what can be set, and its number and name.
#pragma once

#include "methods/method_settings.h"
#include "stance/reactions.h"
#include "stance/refusal.h"

#include <any>
#include <string_view>
#include <utility>
#include <vector>

namespace torqued
{

/// One double support, and all that a rule chooses from.
struct DoubleSupport
{
  const Robot& robot;
  const SupportEquations& equations;
  const Support& support;
  const AdmissibleReactions& all;
  const MethodSettings& settings;
};

/// A method, as its file describes it.
struct MethodRow
{
  Method method;         ///< its number in desired_state_t
  std::string_view name; ///< in configurations, on command lines and in tables
  Result<Reactions> (*choose)(const DoubleSupport&);
  std::any (*settings)() = nullptr; ///< the defaults of what can be set; null: nothing can
  void (*list)(std::any&, SettingList&) = nullptr;
};

/// A method with settings. list(Settings&, SettingList&) lists them.
template <typename Settings>
MethodRow method_row(std::string_view name, Result<Reactions> (*choose)(const DoubleSupport&))
{
  return {Settings::kMethod, name, choose, [] { return std::any(Settings()); },
          [](std::any& settings, SettingList& with)
          {
            list(*std::any_cast<Settings>(&settings), with);
          }};
}

/// All methods, in the order of their numbers, from 1 on.
const std::vector<MethodRow>& methods();
/// Rows in that order. Throws std::logic_error if they are not numbered from 1 on, each once.
std::vector<MethodRow> by_number(std::vector<MethodRow> rows);

} // namespace torqued
