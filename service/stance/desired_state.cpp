#include "stance/desired_state.h"

namespace torqued
{

std::string_view name_of(Contact contact)
{
  switch (contact)
  {
  case Contact::none: return "none";
  case Contact::heel: return "heel";
  case Contact::sole: return "sole";
  case Contact::toe: return "toe";
  }
  return "unknown";
}

} // namespace torqued
