/// What a daemon says of itself, for scripts.
#pragma once

#include <nlohmann/json.hpp>
#include <torqued/status_t.hpp>

namespace torqued
{

/// The message's fields by their names; state and last_reason by the names of their values, last_reason null if
/// there was none.
nlohmann::ordered_json status_json(const status_t& status);

} // namespace torqued
