#include "stance/refusal.h"

namespace torqued
{

std::string_view name_of(Reason reason)
{
  switch (reason)
  {
  case Reason::undecodable: return "UNDECODABLE";
  case Reason::wrong_model: return "WRONG_MODEL";
  case Reason::wrong_size: return "WRONG_SIZE";
  case Reason::not_finite: return "NOT_FINITE";
  case Reason::out_of_range: return "OUT_OF_RANGE";
  case Reason::unknown_method: return "UNKNOWN_METHOD";
  case Reason::out_of_order: return "OUT_OF_ORDER";
  case Reason::stale: return "STALE";
  case Reason::other_stream: return "OTHER_STREAM";
  case Reason::inconsistent: return "INCONSISTENT";
  case Reason::under_actuated: return "UNDER_ACTUATED";
  case Reason::infeasible: return "INFEASIBLE";
  case Reason::over_limit: return "OVER_LIMIT";
  case Reason::not_supported: return "NOT_SUPPORTED";
  case Reason::numerical: return "NUMERICAL";
  }
  return "UNKNOWN";
}

} // namespace torqued
