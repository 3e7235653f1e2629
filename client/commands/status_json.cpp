#include "commands/status_json.h"

#include "bus/daemons.h"
#include "study/tally.h"

namespace torqued
{

nlohmann::ordered_json status_json(const status_t& status)
{
  nlohmann::ordered_json last_reason;
  if (status.last_reason != 0)
    last_reason = reason_name(status.last_reason);
  return {{"utime", status.utime},
          {"instance_id", status.instance_id},
          {"uptime_us", status.uptime_us},
          {"model_id", status.model_id},
          {"settings_id", status.settings_id},
          {"state", state_name(status.state)},
          {"received", status.received},
          {"answered", status.answered},
          {"rejected", status.rejected},
          {"superseded", status.superseded},
          {"late", status.late},
          {"conflicts", status.conflicts},
          {"dropped_logs", status.dropped_logs},
          {"dropped_upper_bound", status.dropped_upper_bound},
          {"last_reason", last_reason},
          {"input_age_us", status.input_age_us},
          {"latency_us_p50", status.latency_us_p50},
          {"latency_us_p90", status.latency_us_p90},
          {"latency_us_p99", status.latency_us_p99},
          {"latency_us_p999", status.latency_us_p999},
          {"latency_us_max", status.latency_us_max},
          {"version", status.version}};
}

} // namespace torqued
