#include "motion/support_course.h"

#include <algorithm>
#include <functional>
#include <optional>

namespace torqued
{

namespace
{

bool loaded(const Contacts& contacts, Side side)
{
  return contacts[static_cast<std::size_t>(side)] != Contact::none;
}

bool double_support(const Contacts& contacts)
{
  return loaded(contacts, Side::left) && loaded(contacts, Side::right);
}

// the only foot with contact, or none
std::optional<Side> single_foot(const Contacts& contacts)
{
  if (loaded(contacts, Side::left) == loaded(contacts, Side::right))
    return {};
  return loaded(contacts, Side::left) ? Side::left : Side::right;
}

// the first index after `begin` whose contacts are not alike those of `begin`; the size if there is none
template <typename Alike>
std::size_t end_of_stretch(const std::vector<Contacts>& contacts, std::size_t begin, Alike alike)
{
  std::size_t end = begin + 1;
  while (end < contacts.size() && alike(contacts[begin], contacts[end]))
    ++end;
  return end;
}

// the leading foot of the double support in [begin, end)
Side leading_foot(const std::vector<Contacts>& contacts, std::size_t begin, std::size_t end)
{
  if (begin > 0)
    if (const auto stood = single_foot(contacts[begin - 1]))
      return other(*stood);
  if (end < contacts.size())
    if (const auto stays = single_foot(contacts[end]))
      return *stays;
  return Side::left;
}

} // namespace

bool stands_throughout(const std::vector<Contacts>& contacts)
{
  return !contacts.empty() && double_support(contacts.front()) &&
         end_of_stretch(contacts, 0, std::equal_to<Contacts>()) == contacts.size();
}

std::vector<Support> follow_contacts(const std::vector<std::int64_t>& utime, const std::vector<Contacts>& contacts)
{
  const std::size_t size = contacts.size();
  std::vector<Support> supports;
  for (const Contacts& pair : contacts)
    supports.push_back({{pair}, Side::left, 0.0, 0.0});

  // the share of the time of [begin, end) that has passed at a sample
  const auto share = [&](std::size_t begin, std::size_t end, std::size_t sample)
  {
    const std::int64_t duration = utime[std::min(end, size - 1)] - utime[begin];
    return duration > 0 ? static_cast<double>(utime[sample] - utime[begin]) / static_cast<double>(duration) : 0.0;
  };

  for (std::size_t begin = 0, end; begin < size; begin = end)
  {
    end = end_of_stretch(contacts, begin, std::equal_to<Contacts>());
    for (std::size_t sample = begin; sample < end; ++sample)
      supports[sample].phase = share(begin, end, sample);
  }

  const auto same_support = [](const Contacts& a, const Contacts& b)
  {
    return double_support(a) == double_support(b);
  };
  Side leading = Side::left;
  for (std::size_t begin = 0, end; begin < size; begin = end)
  {
    end = end_of_stretch(contacts, begin, same_support);
    const bool both = double_support(contacts[begin]);
    if (both)
      leading = leading_foot(contacts, begin, end);
    for (std::size_t sample = begin; sample < end; ++sample)
    {
      if (const auto side = single_foot(contacts[sample]))
        leading = *side;
      supports[sample].leading = leading;
      supports[sample].load_transfer = both ? share(begin, end, sample) : 0.0;
    }
  }
  if (stands_throughout(contacts))
    for (Support& support : supports)
      support.load_transfer = support.phase = 0.5;
  return supports;
}

} // namespace torqued
