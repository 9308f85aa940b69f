#include "final_name.h"

#include <algorithm>
#include <string>
#include <string_view>

namespace plait {

Error with_final_name(const Error& error, const PartialOutput& output) {
  const std::string& temporary = output.path().native();
  const std::string& final_name = output.final_path().native();
  // What writes a file by way of a temporary name of its own adds a suffix, as write_ply does.
  constexpr std::string_view kSuffix = ".partial-", kRest = "0123456789-";
  std::string message = error.what();
  for (std::size_t at = 0; (at = message.find(temporary, at)) != std::string::npos;) {
    std::size_t end = at + temporary.size();
    if (message.compare(end, kSuffix.size(), kSuffix) == 0)
      end = std::min(message.find_first_not_of(kRest, end + kSuffix.size()), message.size());
    message.replace(at, end - at, final_name);
    at += final_name.size();
  }
  return {error.code(), message};
}

}  // namespace plait
