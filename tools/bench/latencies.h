// bench/latencies.h: how long requests took.
#pragma once

#include <nlohmann/json.hpp>
#include <vector>

namespace plait::bench {

/// The member `latencies` of a record: quantiles, and a histogram whose bins double. null if there
/// was no request.
nlohmann::ordered_json latencies_to_json(std::vector<double> seconds);

}  // namespace plait::bench
