#include "join_report.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <string>

#include "console.h"
#include "json_text.h"

namespace plait {

int report_incomplete(const std::filesystem::path& plan, const JoinResult& parts, bool json) {
  for (const std::string& reason : parts.reasons) report_warning(reason);
  if (json)
    print(json_text(nlohmann::ordered_json({{"plan", plan.string()},
                                            {"missing", parts.missing},
                                            {"bad", parts.bad},
                                            {"array", parts.again()}})));
  else
    print(parts.again() + "\n");
  return kExitIncomplete;
}

int report_join(const JoinResult& joined, const std::filesystem::path& plan,
                const std::filesystem::path& store, double seconds, bool json) {
  if (!joined.has_store) return report_incomplete(plan, joined, json);
  if (!json) {
    print(fmt::format("{}: version {}, {:.2f} s\n{}\n", store.native(), joined.version, seconds,
                      joined.digest));
    return kExitDone;
  }
  const nlohmann::ordered_json report = {{"plan", plan.string()},
                                         {"store", store.string()},
                                         {"version", joined.version},
                                         {"digest", joined.digest},
                                         {"seconds", seconds}};
  print(json_text(report));
  return kExitDone;
}

}  // namespace plait
